"""Linear stability of the coupled system: modes of wheel and rail and the linearised contact in, eigenvalues out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes, state_space

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

TANGENTIAL = [0, 1, 3]
"""Directions lon, lat, spin in the order lon, lat, normal, spin."""

NORMAL = 2


@dataclass(frozen=True)
class Identified:
    """A structure that shows no modes, as its response tells it: velocities after an impulse are sums of exponentials.

    Attributes
    ----------
    pole : (n,) [1/s]; of a complex pair both
    observe : (4, n) velocity in track axes per state
    drive : (n, 4) rate of the states per force in track axes
    """

    pole: Complex
    observe: Complex
    drive: Complex


Structure = Modes | Identified


@dataclass(frozen=True)
class OpenSystem:
    """Wheel and rail side by side, without the contact, seen from the contact.

    Attributes
    ----------
    A : (m, m) state matrix; two modal structures have all modal velocities, then all modal displacements
    B : (m, 4) rate of the state per contact force on the wheel, in contact axes
    V, U : (4, m) relative velocity and displacement, wheel minus rail, in contact axes
    rail : (m,) whether a state belongs to the rail
    """

    A: Any
    B: Any
    V: Any
    U: Any
    rail: NDArray[np.bool_]

    @classmethod
    def of(cls, wheel: Structure, rail: Structure, turn: Real) -> OpenSystem:
        """Put wheel and rail together; `turn` is the rotation from track to contact axes."""
        if isinstance(wheel, Modes) and isinstance(rail, Modes):
            both = Modes(
                np.concatenate([wheel.omega, rail.omega]),
                np.concatenate([wheel.zeta, rail.zeta]),
                np.vstack([wheel.shape, -rail.shape]),
            )
            A, B, C, C_d = state_space(both)
            own = np.repeat([False, True, False, True], [len(wheel), len(rail)] * 2)
            return cls(A, B @ turn.T, turn @ C, turn @ C_d, own)
        parts = [_matrices(wheel), _matrices(rail)]
        return cls(
            block_diag(parts[0][0], parts[1][0]),
            np.vstack([parts[0][1], -parts[1][1]]) @ turn.T,
            turn @ np.hstack([parts[0][2], -parts[1][2]]),
            turn @ np.hstack([parts[0][3], -parts[1][3]]),
            np.repeat([False, True], [len(parts[0][0]), len(parts[1][0])]),
        )


def _matrices(structure: Structure) -> tuple[Any, Any, Any, Any]:
    """Return A, B, C (velocities) and C_d (displacements) of one structure."""
    if isinstance(structure, Modes):
        return state_space(structure)
    return np.diag(structure.pole), structure.drive, structure.observe, structure.observe / structure.pole


def closed_loop_matrix(wheel: Structure, rail: Structure, contact: LinearContact) -> Any:
    """Return the state matrix of the coupled system, (m, m).

    Notes
    -----
    f_n = -K u_n and f_t = H1 v_t + h2 f_n: the friction force follows the normal force without delay.
    """
    open_system = OpenSystem.of(wheel, rail, contact.turn)
    force = np.zeros_like(open_system.V)
    force[NORMAL] = -contact.stiffness * open_system.U[NORMAL]
    force[TANGENTIAL] = contact.H1 @ open_system.V[TANGENTIAL] + np.outer(contact.h2, force[NORMAL])
    return open_system.A + open_system.B @ force


@dataclass(frozen=True)
class Poles:
    """Poles of a system with positive frequency, sorted by frequency.

    Attributes
    ----------
    frequency_hz : (p,) imaginary part over 2 pi [Hz]
    growth_rate : (p,) real part [1/s]
    """

    frequency_hz: Real
    growth_rate: Real

    def unstable(self) -> Poles:
        """Return only the growing ones."""
        keep = self.growth_rate > 0
        return Poles(self.frequency_hz[keep], self.growth_rate[keep])

    def below(self, frequency_hz: float) -> Poles:
        """Return only those below a frequency."""
        keep = self.frequency_hz < frequency_hz
        return Poles(self.frequency_hz[keep], self.growth_rate[keep])


def poles_of(eigenvalues: NDArray[Any]) -> Poles:
    """Return the poles of eigenvalues [1/s]; of each complex pair one."""
    positive = eigenvalues[eigenvalues.imag > 1e-9]
    positive = positive[np.argsort(positive.imag)]
    return Poles(positive.imag / (2 * np.pi), positive.real)


def exact_poles(wheel: Structure, rail: Structure, contact: LinearContact) -> Poles:
    """Return the poles of the coupled system without any step."""
    return poles_of(eigenvalues(closed_loop_matrix(wheel, rail, contact)))


def eigenvalues(matrix: Any) -> NDArray[np.complex128]:
    """Return the eigenvalues of a matrix, part by part where it falls apart into parts that do not couple.

    Motion along the track and in its cross-section often do not; that makes the work a quarter.
    """
    count, part = connected_components(matrix != 0, directed=False)
    places = (np.flatnonzero(part == k) for k in range(count))
    with threadpool_limits(1, "blas"):  # matrices of this size are slower on several threads, much so on a busy machine
        return np.concatenate([np.linalg.eigvals(matrix[np.ix_(p, p)]).astype(complex) for p in places])
