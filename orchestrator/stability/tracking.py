"""Poles of many neighbouring systems: wheel, rail and contact in, the poles that `exact_poles` gives out, much faster.

The modes of wheel and rail move on their own but for four forces between them. So the characteristic polynomial is
prod d_k(s) det(I - L(s) Y(s)) with d_k = s^2 + 2 zeta_k omega_k s + omega_k^2, the 4 x 4 receptance
Y = sum R_k R_k^T/d_k and the contact L(s) = L_0 + s L_1. All roots are improved at once from those of the system
before, by the method of Ehrlich and Aberth. That none is missed and none found twice is checked by their sum and their
sum of squares, the traces of the state matrix and of its square; where that fails, eigenvalues are computed anew.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fmus.compile import kernel
from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes

from .poles import NORMAL, TANGENTIAL, Poles, eigenvalues, poles_of

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

CLOSE = 1e-9
"""Last relative change of a root; the method converges cubically, so what is left is rounding."""

_SWEEPS = 30
_ROUNDING = 1e-12
"""Relative error that rounding may leave in the sum of the roots and of their squares."""

_FREE = 1e-10
"""Shift of a pole by the contact that does not count [1/s]; such modes are on their own."""

_REAL = 1e-9
"""Imaginary part of a real root, relative to its size."""


class _Block(NamedTuple):
    """Modes and directions that couple.

    Attributes
    ----------
    omega, zeta : (n,) of the modes
    R : (n, d) their motion in the directions
    L0, L1 : (d, d) forces per displacement and per velocity
    """

    omega: Real
    zeta: Real
    R: Real
    L0: Real
    L1: Real


@dataclass
class TrackedPoles:
    """Poles of one system after another; what was found last is where the next search starts.

    Attributes
    ----------
    roots : by block, those with imaginary part above 0, and real ones
    fresh : how often eigenvalues had to be computed anew
    """

    roots: dict[bytes, tuple[Complex, Real]] = field(default_factory=dict)
    fresh: int = 0

    def poles(self, wheel: Modes, rail: Modes, contact: LinearContact) -> Poles:
        """Return the poles of the coupled system without any step."""
        omega, zeta = np.concatenate([wheel.omega, rail.omega]), np.concatenate([wheel.zeta, rail.zeta])
        R = np.vstack([wheel.shape, -rail.shape]) @ contact.turn.T
        L0, L1 = _forces(contact)
        shift = (np.abs(R) @ (np.abs(L1) / 2) + np.abs(R) @ np.abs(L0) / (2 * omega[:, None])) * np.abs(R)
        moved = shift.sum(axis=1) > _FREE
        found = [omega[~moved] * (-zeta[~moved] + 1j * np.sqrt(1 - zeta[~moved] ** 2 + 0j))]
        for modes, directions in _coupled(np.where(moved[:, None], np.abs(R), 0), np.abs(L0) + np.abs(L1)):
            own = np.ix_(directions, directions)
            block = _Block(
                omega[modes], zeta[modes], R[np.ix_(modes, directions)].copy(), L0[own].copy(), L1[own].copy()
            )
            found.append(self._upper(block, directions.tobytes() + modes.tobytes()))
        return poles_of(np.concatenate(found))

    def _upper(self, block: _Block, key: bytes) -> Complex:
        """Return the roots of a block with imaginary part above 0."""
        if key in self.roots:
            upper, real = self.roots[key][0].copy(), self.roots[key][1].copy()
            if _improve(upper, real, block, CLOSE, _SWEEPS) and _complete(upper, real, block):
                self.roots[key] = upper, real
                return upper
        self.fresh += 1
        values = eigenvalues(_state_matrix(block))
        flat = np.abs(values.imag) <= _REAL * np.abs(values)
        self.roots[key] = values[(values.imag > 0) & ~flat].copy(), values[flat].real.copy()
        return self.roots[key][0]


def _forces(contact: LinearContact) -> tuple[Real, Real]:
    """Return the contact's forces on the wheel per relative displacement and per velocity, (4, 4) each."""
    L0, L1 = np.zeros((4, 4)), np.zeros((4, 4))
    L0[NORMAL, NORMAL] = -contact.stiffness
    L0[TANGENTIAL, NORMAL] = -contact.stiffness * contact.h2
    L1[np.ix_(TANGENTIAL, TANGENTIAL)] = contact.H1
    return L0, L1


def _coupled(motion: Real, forces: Real) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Return modes and directions of each part that does not couple with the others."""
    reach = (motion.T @ motion + forces + forces.T + np.eye(len(forces))) != 0
    for _ in range(2):
        reach = reach @ reach  # four directions: after four steps everything is reached
    parts = []
    for row in {tuple(np.flatnonzero(row).tolist()) for row in reach}:
        directions = np.array(row)
        modes = np.flatnonzero(motion[:, directions].any(axis=1))
        if modes.size:
            parts.append((modes, directions))
    return parts


def _state_matrix(block: _Block) -> Real:
    """Return the state matrix of a block, (2n, 2n), for all velocities, then all displacements."""
    n = block.omega.size
    damping, stiffness = np.diag(-2 * block.zeta * block.omega), np.diag(-(block.omega**2))
    R = block.R
    return np.block([[damping + R @ block.L1 @ R.T, stiffness + R @ block.L0 @ R.T], [np.eye(n), np.zeros((n, n))]])


def _complete(upper: Complex, real: Real, block: _Block) -> bool:
    """Return whether roots are all those of a block: their sum and sum of squares are the traces."""
    damping, G = -2 * block.zeta * block.omega, block.R.T @ block.R
    own = np.einsum("ki,ij,kj->k", block.R, block.L1, block.R)
    first = damping.sum() + own.sum()
    second = (damping**2).sum() + 2 * damping @ own + np.trace(block.L1 @ G @ block.L1 @ G)
    second += 2 * (np.trace(block.L0 @ G) - (block.omega**2).sum())
    sums = 2 * upper.real.sum() + real.sum(), 2 * (upper**2).real.sum() + (real**2).sum()
    sizes = 2 * np.abs(upper).sum() + np.abs(real).sum(), 2 * (np.abs(upper) ** 2).sum() + (real**2).sum()
    return all(abs(s - t) <= _ROUNDING * size for s, t, size in zip(sums, (first, second), sizes, strict=True))


@kernel
def _improve(upper, real, block, close, sweeps):  # type: ignore[no-untyped-def]
    """Improve all roots in place; return whether all of them settled.

    Each root z moves by 1/(p'/p - sum 1/(z - z_j)), the sum over all other roots, conjugate ones included.
    """
    settled_upper, settled_real = np.zeros(upper.size, np.bool_), np.zeros(real.size, np.bool_)
    for _ in range(sweeps):
        for i in range(upper.size):
            if not settled_upper[i]:
                z = upper[i]
                own = _inverse(z - z.conjugate())
                change = _inverse(_log_derivative(z, block) - own - _pull(z, upper, real, i, -1))
                change = change if np.isfinite(change) else 0.0  # p(z) is zero exactly
                upper[i] = z - change
                settled_upper[i] = abs(change) <= close * abs(z)
        for i in range(real.size):
            if not settled_real[i]:
                z = complex(real[i])
                change = 1 / (_log_derivative(z, block) - _pull(z, upper, real, -1, i)).real
                change = change if np.isfinite(change) else 0.0
                real[i] -= change
                settled_real[i] = abs(change) <= close * abs(z)
        if settled_upper.all() and settled_real.all():
            return np.isfinite(upper).all() and np.isfinite(real).all() and (upper.imag > 0).all()
    return False


@kernel
def _inverse(z):  # type: ignore[no-untyped-def]
    """Return 1/z; not a number for 0, where Numba's own division of complex numbers ends in an exception."""
    size = z.real * z.real + z.imag * z.imag
    return complex(z.real / size, -z.imag / size)


@kernel
def _pull(z, upper, real, not_upper, not_real):  # type: ignore[no-untyped-def]
    """Return the sum of 1/(z - z_j) over all roots but one, and but the conjugate of an upper one."""
    total = 0j
    for j in range(upper.size):
        if j != not_upper:
            total += _inverse(z - upper[j]) + _inverse(z - upper[j].conjugate())
    for j in range(real.size):
        if j != not_real:
            total += _inverse(z - real[j])
    return total


@kernel
def _log_derivative(s, block):  # type: ignore[no-untyped-def]
    """Return p'/p of the characteristic polynomial: sum d_k'/d_k + tr((I - L Y)^-1 (I - L Y)')."""
    omega, zeta, R, L0, L1 = block
    d = R.shape[1]
    Y, dY = np.zeros((d, d), np.complex128), np.zeros((d, d), np.complex128)
    total = 0j
    for k in range(omega.size):
        inverse = _inverse(s * s + 2 * zeta[k] * omega[k] * s + omega[k] * omega[k])
        slope = 2 * (s + zeta[k] * omega[k]) * inverse
        total += slope
        for i in range(d):
            for j in range(i + 1):
                value = R[k, i] * R[k, j] * inverse
                Y[i, j] += value
                dY[i, j] -= value * slope
    for i in range(d):
        for j in range(i):
            Y[j, i], dY[j, i] = Y[i, j], dY[i, j]
    L = L0 + s * L1
    M, dM = np.zeros((d, d), np.complex128), np.zeros((d, d), np.complex128)
    for i in range(d):
        M[i, i] = 1.0
        for j in range(d):
            for k in range(d):
                M[i, j] -= L[i, k] * Y[k, j]
                dM[i, j] -= L[i, k] * dY[k, j] + L1[i, k] * Y[k, j]
    return total + _trace_of_quotient(M, dM)


@kernel
def _trace_of_quotient(M, N):  # type: ignore[no-untyped-def]
    """Return tr(M^-1 N) by elimination with pivots; both matrices are used up."""
    d = M.shape[0]
    for p in range(d):
        best = p + np.abs(M[p:, p]).argmax()
        for j in range(d):
            M[p, j], M[best, j] = M[best, j], M[p, j]
            N[p, j], N[best, j] = N[best, j], N[p, j]
        for i in range(d):
            if i != p:
                factor = M[i, p] * _inverse(M[p, p])
                for j in range(d):
                    M[i, j] -= factor * M[p, j]
                    N[i, j] -= factor * N[p, j]
    total = 0j
    for p in range(d):
        total += N[p, p] * _inverse(M[p, p])
    return total
