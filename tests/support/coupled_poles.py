"""The cases of the paper as linear systems, and what tests of coupled components measure on them."""

from __future__ import annotations

import numpy as np
from coupled import Coupled, linear_contact, modes_of, output, rail_of, wheel
from numpy.typing import NDArray

from fmus.contact.component import contact
from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes
from fmus.wheel.wheelset import DATA, read_wheelset

CASES = (1, 2, 3, 4)

WHEEL = modes_of(wheel())

TALLEST_HZ = 5000.0


def parts(case: int) -> tuple[Modes, Modes, LinearContact]:
    """Return wheel, rail and contact of a case."""
    return WHEEL, modes_of(rail_of(case)), linear_contact(case)


def assert_steps_as(M: NDArray[np.float64], z: NDArray[np.float64], system: Coupled, turn: NDArray[np.float64]) -> None:
    """Step components 40 times beside their step map and compare states and held forces, `turn` being the contact's.

    The tolerance is what the non-linear terms and finite differences leave at 1e-7 of the sliding velocity.
    """
    n = len(system.state) // 2
    for _ in range(40):
        system.step()
        z = M @ z
    np.testing.assert_allclose(system.state[:n], z[:n], atol=2e-4 * abs(z[:n]).max())
    held = z[2 * n : 2 * n + 4]
    np.testing.assert_allclose(turn @ system.wheel.inputs, held, atol=2e-4 * abs(held).max())


def friction_in_stick(h: float, seconds: float = 4e-3, speed: float = 0.22, **how: object) -> NDArray[np.float64]:
    """Return the lateral friction force while Case 1 starts at 0.2 m/s on the mode at 1102 Hz, where it sticks."""
    labels = read_wheelset(DATA / "generic840.toml").modes.labels
    mode = labels.index("(3,0) cosine")
    start = np.zeros(len(WHEEL) + len(modes_of(rail_of(1))))
    start[mode] = -speed / WHEEL.shape[mode, 1]
    record = Coupled.of(1, h, start, **how).run(round(seconds / h))  # type: ignore[arg-type]
    force = record["contact"][:, output(contact(), "tangential_force_lat")]
    return force[round(0.5e-3 / h) :]  # after the jolt of the start


def reversals(force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smaller of two successive changes where they have opposite signs [N], else 0."""
    before, after = np.diff(force)[:-1], np.diff(force)[1:]
    return np.where(before * after < 0, np.minimum(abs(before), abs(after)), 0.0)


def zigzag(reversed_: NDArray[np.float64]) -> float:
    """Return the largest force that goes back and forth in three successive steps [N]."""
    return float(np.minimum(reversed_[:-1], reversed_[1:]).max())
