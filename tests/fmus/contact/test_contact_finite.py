"""The contact FMU answers with numbers or with an error, whatever it is given; never with NaN and OK."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from slaves import H

ODD = [float("nan"), float("inf"), -float("inf"), 1e308, -1e308, 1e154, -1e154, 5e-324, 0.0, 1e-3, 1e9]
VALUES = st.sampled_from(ODD) | st.floats(-1.0, 1.0)
PAIRS = st.lists(st.tuples(st.integers(0, 10**6), VALUES), max_size=4)
STEPS = st.lists(st.tuples(PAIRS, st.booleans()), min_size=1, max_size=6)


class Host:
    """A contact FMU under FMPy's binding, which raises on every status that is worse than a warning."""

    def __init__(self, file: Path, folder: Path) -> None:
        fmpy.extract(str(file), unzipdir=str(folder))
        self.folder = folder
        self.about = fmpy.read_model_description(str(folder))
        self.third = self.about.fmiVersion.startswith("3")
        self.kind = "Float64" if self.third else "Real"
        reals = [v for v in self.about.modelVariables if v.type == self.kind and not v.dimensions]
        self.references = {
            causality: [v.valueReference for v in reals if v.causality == causality]
            for causality in ("parameter", "input", "output", "local")
        }
        self.answers = 0

    def begin(self) -> None:
        """Make an instance and enter initialisation mode."""
        make: Any = fmpy.fmi3.FMU3Slave if self.third else fmpy.fmi2.FMU2Slave
        identifier = self.about.coSimulation.modelIdentifier
        self.slave = make(
            guid=self.about.guid, unzipDirectory=str(self.folder), modelIdentifier=identifier, instanceName="x"
        )
        self._get, self._set = (getattr(self.slave, f"{word}{self.kind}") for word in ("get", "set"))
        self.slave.instantiate(loggingOn=False)
        if not self.third:
            self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()

    def set(self, causality: str, number: int, value: float) -> None:
        """Set one variable of a causality."""
        known = self.references[causality]
        self._set([known[number % len(known)]], [value])

    def look(self) -> None:
        """Get every output and local variable by itself, as each may be refused; what is answered are numbers."""
        for reference in (*self.references["output"], *self.references["local"]):
            with suppress(FMICallException):
                assert np.isfinite(self._get([reference])).all()
                self.answers += 1

    def differentiate(self) -> None:
        """Get all derivatives along one input, if they are offered."""
        if not self.about.coSimulation.providesDirectionalDerivative:
            return
        found = self.slave.getDirectionalDerivative(self.references["output"], self.references["input"][:1], [1e300])
        assert np.isfinite(found).all()


@pytest.fixture(scope="module", params=["native", "native3", pytest.param("built", marks=pytest.mark.slow)])
def host(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Host:
    """Return a host of the contact FMU in machine code, FMI 2.0 and 3.0, and of the one in Python."""
    return Host(request.getfixturevalue(request.param) / "contact.fmu", tmp_path_factory.mktemp("contact"))


def attempt(call: Callable[..., None], *arguments: Any) -> None:
    with suppress(FMICallException):
        call(*arguments)


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(parameters=PAIRS, start=PAIRS, steps=STEPS)
def test_an_answer_is_a_number_or_an_error(host: Host, parameters: Any, start: Any, steps: Any) -> None:
    """What is refused is passed over, as by a careless host: the next calls must not answer NaN either."""
    before = host.answers
    host.begin()
    host.look()
    assert host.answers > before
    for causality, pairs in (("parameter", parameters), ("input", start)):
        for number, value in pairs:
            attempt(host.set, causality, number, value)
    host.look()
    attempt(host.slave.exitInitializationMode)
    for k, (pairs, differentiate) in enumerate(steps):
        host.look()
        for number, value in pairs:
            attempt(host.set, "input", number, value)
        attempt(host.slave.doStep, k * H, H)
        host.look()
        if differentiate:
            attempt(host.differentiate)
    host.slave.freeInstance()
