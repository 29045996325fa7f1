"""Linear stability of the coupled system: modes of wheel and rail and the linearised contact in, eigenvalues out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes, state_space

Real = NDArray[np.float64]

TANGENTIAL = [0, 1, 3]
"""Directions lon, lat, spin in the order lon, lat, normal, spin."""

NORMAL = 2


@dataclass(frozen=True)
class OpenSystem:
    """Wheel and rail side by side, without the contact, seen from the contact.

    Attributes
    ----------
    A : (2n, 2n) state matrix of the state (all modal velocities, all modal displacements)
    R : (4, n) relative motion wheel minus rail in contact axes per modal coordinate; R.T turns contact forces on the
        wheel into modal forces
    """

    A: Real
    R: Real

    @classmethod
    def of(cls, wheel: Modes, rail: Modes, turn: Real) -> OpenSystem:
        """Put wheel and rail together; `turn` is the rotation from track to contact axes."""
        modes = Modes(
            np.concatenate([wheel.omega, rail.omega]),
            np.concatenate([wheel.zeta, rail.zeta]),
            np.vstack([wheel.shape, -rail.shape]),
        )
        A, _, _, _ = state_space(modes)
        return cls(A, turn @ modes.shape.T)


def closed_loop_matrix(wheel: Modes, rail: Modes, contact: LinearContact) -> Real:
    """Return the state matrix of the coupled system, (2n, 2n).

    Notes
    -----
    f_n = -K R_n q and f_t = H1 R_t q' + h2 f_n: the friction force follows the normal force without delay.
    """
    open_system = OpenSystem.of(wheel, rail, contact.turn)
    n = open_system.R.shape[1]
    R_n, R_t = open_system.R[NORMAL], open_system.R[TANGENTIAL]
    A = open_system.A.copy()
    A[:n, :n] += R_t.T @ contact.H1 @ R_t
    A[:n, n:] -= contact.stiffness * np.outer(R_n + contact.h2 @ R_t, R_n)
    return A


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


def closed_loop_poles(wheel: Modes, rail: Modes, contact: LinearContact) -> Poles:
    """Return the poles of the coupled system."""
    return poles_of(np.linalg.eigvals(closed_loop_matrix(wheel, rail, contact)))


def exact_poles(wheel: Modes, rail: Modes, contact: LinearContact) -> Poles:
    """Return the poles of the coupled system without any step."""
    return poles_of(eigenvalues(closed_loop_matrix(wheel, rail, contact)))


def eigenvalues(matrix: Real) -> NDArray[np.complex128]:
    """Return the eigenvalues of a matrix, part by part where it falls apart into parts that do not couple.

    Motion along the track and in its cross-section often do not; that makes the work a quarter.
    """
    count, part = connected_components(matrix != 0, directed=False)
    places = (np.flatnonzero(part == k) for k in range(count))
    with threadpool_limits(1, "blas"):  # matrices of this size are slower on several threads, much so on a busy machine
        return np.concatenate([np.linalg.eigvals(matrix[np.ix_(p, p)]).astype(complex) for p in places])
