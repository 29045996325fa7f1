"""Every call of the standard in every state of a native FMU: what is forbidden is an error, never a crash."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
import pytest
from slaves import Caught, H, Slave3


def step(s: Caught) -> None:
    """Make a step."""
    s.slave.doStep(0.0, H)


def steps(s: Caught) -> bool:
    """Bring a slave into step mode."""
    s.start()
    return True


FORBIDDEN: dict[str, tuple[Callable[[Caught], Any], str]] = {
    "doStep before initialisation": (step, "fmi2DoStep is not allowed before initialisation"),
    "exit without enter": (lambda s: s.slave.exitInitializationMode(), "not allowed before initialisation"),
    "initialise twice": (lambda s: steps(s) and (s.slave.enterInitializationMode()), "not allowed in step mode"),
    "get before initialisation": (lambda s: s.slave.getReal([0]), "fmi2GetReal is not allowed before initialisation"),
    "set a fixed parameter": (
        lambda s: steps(s) and (s.slave.setReal([s.reference["hertz_stiffness"]], [1e9])),
        "hertz_stiffness is a fixed parameter",
    ),
    "set an output": (lambda s: s.slave.setReal([s.reference["normal_force"]], [1.0]), "normal_force is calculated"),
    "unknown reference": (lambda s: s.slave.setReal([9999], [1.0]), "no variable with value reference 9999"),
    "wrong type": (lambda s: s.slave.setInteger([s.reference["mu0"]], [1]), "mu0 is of type Real"),
    "out of range": (lambda s: s.slave.setReal([s.reference["mu0"]], [3.0]), "mu0 = 3: must be in the range 0 to 2"),
    "integer out of range": (lambda s: s.slave.setInteger([s.reference["grid_cells"]], [0]), "grid_cells = 0"),
    "not finite": (lambda s: s.slave.setReal([s.reference["wheel_v_lat"]], [np.inf]), "wheel_v_lat = inf"),
    "step of zero": (lambda s: steps(s) and (s.slave.doStep(0.0, 0.0)), "step size = 0 s: must be > 0"),
    "step of nan": (lambda s: steps(s) and (s.slave.doStep(0.0, np.nan)), "must be > 0"),
    "too large": (
        lambda s: steps(s) and (s.slave.setReal([s.reference["wheel_u_lat"]], [-1e300]), s.slave.doStep(0.0, H)),
        "not finite",
    ),
    "derivative by a parameter": (
        lambda s: steps(s) and (s.slave.getDirectionalDerivative([12], [s.reference["mu0"]], [1.0])),
        "mu0 is no input",
    ),
    "step after terminate": (
        lambda s: steps(s) and (s.slave.terminate(), s.slave.doStep(0.0, H)),
        "not allowed after termination",
    ),
    "input derivatives": (lambda s: s.slave.setRealInputDerivatives([0], [1], [1.0]), "inputs are held"),
}  # fmt: skip


@pytest.mark.parametrize("what", FORBIDDEN)
def test_what_is_forbidden_is_an_error_with_a_message_and_reset_helps(native: Path, what: str) -> None:
    call, message = FORBIDDEN[what]
    slave = Caught(native / "contact.fmu")
    with pytest.raises(fmpy.fmi1.FMICallException):
        call(slave)
    assert any(message in m for m in slave.messages), slave.messages
    slave.slave.reset()
    slave.start()
    slave.step()
    assert slave.outputs()[8] == pytest.approx(60e3)
    slave.close()


def test_fmi3_declines_what_it_does_not_offer(native3: Path) -> None:
    slave = Slave3(native3 / "wheel.fmu")
    for name in ("enterEventMode", "enterConfigurationMode"):
        with pytest.raises(fmpy.fmi1.FMICallException):
            getattr(slave.slave, name)()
        slave.slave.reset()
    slave.close()
