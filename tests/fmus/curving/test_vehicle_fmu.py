"""vehicle.fmu in FMPy: the component's numbers, nothing to do while nothing changes, a failure that is said."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from curving_cases import balanced, solved
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from fmus.component import Instance
from fmus.curving.bogie import Curve
from fmus.curving.component import vehicle
from fmus.errors import DataError
from fmus.packaging.build import build_fmu
from fmus.packaging.target import Target

STEP = 1e-3
OUTPUT = "leading_left_steady_creepage_lat"


@pytest.fixture(scope="module", params=[("native", 2), ("native", 3), ("python", 2)], ids=lambda p: f"{p[0]}-{p[1]}")
def fmu(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    flavour, fmi = request.param
    folder = tmp_path_factory.mktemp("vehicle")
    return build_fmu(vehicle(), folder / "vehicle.fmu", Target(flavour, fmi))


def transition(time: float) -> float:
    """Curvature of a transition of 1 s into a left curve of 150 m."""
    return min(time, 1.0) / 150


class Driven:
    """An FMU in FMPy's binding, of either version of FMI."""

    def __init__(self, file: Path, folder: Path) -> None:
        fmpy.extract(str(file), str(folder))
        description = fmpy.read_model_description(str(file))
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.three = description.fmiVersion.startswith("3")
        kind = FMU3Slave if self.three else FMU2Slave
        self.slave: Any = kind(
            guid=description.guid, unzipDirectory=str(folder), instanceName="vehicle",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        self.slave.instantiate()

    def set(self, **values: float) -> None:
        """Set variables by name."""
        write = self.slave.setFloat64 if self.three else self.slave.setReal
        write([self.references[n] for n in values], list(values.values()))

    def get(self, *names: str) -> list[float]:
        """Return variables by name."""
        read = self.slave.getFloat64 if self.three else self.slave.getReal
        return list(read([self.references[n] for n in names]))

    def start(self, **values: float) -> None:
        """Initialise with some values."""
        if not self.three:
            self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.set(**values)
        self.slave.exitInitializationMode()

    def step(self, time: float, h: float = STEP) -> None:
        """Make a step."""
        self.slave.doStep(currentCommunicationPoint=time, communicationStepSize=h)


@contextmanager
def driven(file: Path, folder: Path) -> Iterator[Driven]:
    one = Driven(file, folder)
    yield one
    one.slave.freeInstance()


@pytest.mark.slow
def test_fmpy_finds_no_problem(fmu: Path) -> None:
    assert validate_fmu(str(fmu)) == []


@pytest.mark.slow
def test_the_fmu_is_the_component_through_a_transition(fmu: Path, tmp_path: Path) -> None:
    """Both follow the same solution; machine code of another compiler differs by what the residual of 1e-12 leaves."""
    own = Instance(vehicle())
    names = [v.name for v in own.component.of("output") if v.name not in ("iterations", "residual")]
    with driven(fmu, tmp_path) as one:
        one.start(velocity=10.0, mu0=0.3)
        own.initialise()
        for k in range(30):
            curvature = transition(k / 25)
            one.set(curvature=curvature)
            own.inputs[0] = curvature
            one.step(k * STEP)
            own.do_step(STEP)
        assert one.get(*names) == pytest.approx(own.outputs[: len(names)].tolist(), rel=1e-9, abs=1e-10)
        before = one.get(*names)
        one.step(30 * STEP, 5e-6)
        assert one.get("iterations") == [0.0]
        assert one.get(*names) == before


@pytest.mark.slow
def test_no_steady_state_is_an_error_and_nothing_is_kept(fmu: Path, tmp_path: Path) -> None:
    with driven(fmu, tmp_path) as one:
        one.start(curvature=1 / 300, velocity=10.0)
        one.set(curvature=1 / 12, velocity=30.0)
        with pytest.raises(Exception, match=r"failed with status|doStep"):
            one.step(0.0)


def test_the_component_is_the_bogie_and_names_the_radius_it_reached() -> None:
    """Left and right, not inner and outer; a failure leaves no numbers behind."""
    own = Instance(vehicle())
    curve = balanced(150)
    own.inputs[:] = curve.inputs
    own.initialise()
    outputs = dict(zip([v.name for v in own.component.of("output")], own.outputs, strict=True))
    assert outputs[OUTPUT] == pytest.approx(solved(curve).place(1, "leading_inner").steady_creepage_lat, rel=1e-12)
    own.inputs[:] = Curve(1 / 12, 30.0).inputs
    with pytest.raises(DataError, match=r"no steady state in this curve; found down to a radius of \d+"):
        own.do_step(STEP)
    assert np.isnan(own.outputs).all()


def test_through_a_transition_the_warm_start_needs_few_iterations() -> None:
    """Steps of 1 ms at 10 m/s in a transition of 50 m: two or three Newton iterations each."""
    own = Instance(vehicle())
    own.initialise()
    iterations = []
    for k in range(1, 1001):
        own.inputs[0] = transition(k * STEP)
        own.do_step(STEP)
        iterations.append(own.outputs[-2])
    assert max(iterations[1:]) <= 6
    assert np.mean(iterations) < 3
