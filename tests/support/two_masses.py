"""Two oscillating masses and the spring between them, as FMUs of FMI 3.0 with arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from fmi3_fmu import StateSpace, state_space_fmu, write_ssd

from orchestrator.system.model import System
from orchestrator.system.reader import read_system

STIFFNESS, DAMPING = 4.0, 0.1

MASSES = (1.0, 2.0)


def write_masses(folder: Path) -> Path:
    """Write the FMUs of two oscillating masses, some of them slow or forgetful, and of the spring between them."""
    for name, mass in zip(("one", "two"), MASSES, strict=True):
        ground = StateSpace([[0, 1], [-1.0 / mass, 0]], [[0], [1 / mass]], np.eye(2))
        state_space_fmu(folder, name, ground)
        state_space_fmu(folder, f"{name}_slow", ground, fixed_step=0.04)
        state_space_fmu(folder, f"{name}_forgetful", ground, keeps_state=False)
    gain = np.array([[-STIFFNESS, -DAMPING, STIFFNESS, DAMPING]])
    state_space_fmu(folder, "spring", StateSpace([[0]], np.zeros((1, 4)), np.zeros((2, 1)), np.vstack([gain, -gain])))
    return folder


def two_masses(folder: Path, one: str = "one", two: str = "two") -> System:
    """Return the two-mass oscillator: two FMUs with forces in and motion out, and a spring and damper between them."""
    wires = [(f"{m}.y[{i}]", f"spring.u[{2 * k + i}]") for k, m in enumerate(("one", "two")) for i in (1, 2)]
    wires += [("spring.y[1]", "one.u[1]"), ("spring.y[2]", "two.u[1]")]
    parts = {"one": folder / f"{one}.fmu", "two": folder / f"{two}.fmu", "spring": folder / "spring.fmu"}
    system = read_system(write_ssd(folder / "two_masses.ssd", parts, wires))
    return system.with_parameters({"one": {"x0": "1 0"}})
