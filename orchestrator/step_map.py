"""What a master algorithm makes of a linear system: the map from one step to the next, and the poles it shows.

A co-simulation of a linear system is itself linear: its state after a step is a matrix times its state before. The
matrix's eigenvalues z appear to an observer as poles ln(z)/h. Their real parts against the poles of the coupled system
are the growth that the algorithm adds, mode by mode.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.optimize import linear_sum_assignment

from fmus.contact.linearised import LinearContact
from fmus.contact.prediction import DECAY, MEMORY, SLIP, STICK
from fmus.modal import Modes

from .stability import NORMAL, TANGENTIAL, OpenSystem, Poles, closed_loop_poles, poles_of

Real = NDArray[np.float64]


def step_map(
    wheel: Modes, rail: Modes, contact: LinearContact, h: float, algorithm: str = "staggered", implicit: bool = True
) -> Real:
    """Return the matrix of one step.

    Parameters
    ----------
    h : communication step [s]
    algorithm : 'staggered', 'jacobi', or 'compensated': jacobi with the contact's host_delay_steps = 1
    implicit : whether the contact knows the interface mobility

    Returns
    -------
    (2n + 12, 2n + 12) array for the state (modal velocities, modal displacements, held contact forces, the forces
    before them, the relative velocities before), the last three in contact axes; compensated (2n + 24, 2n + 24): also
    the forces before those, and the rests of the last two changes of the velocities, see `fmus.contact.prediction`
    """
    open_system = OpenSystem.of(wheel, rail, contact.turn)
    R = open_system.R
    n = R.shape[1]
    phi, gamma = _exact_step(open_system.A, n, h)
    drive = gamma @ R.T
    Y = R @ drive[:n] if implicit else np.zeros((4, 4))
    unit = np.eye(2 * n + (24 if algorithm == "compensated" else 12))
    now, held, before, v_before, *history = np.split(unit, range(2 * n, len(unit), 4))
    stepped = phi @ now + drive @ held
    seen = {"staggered": stepped, "jacobi": now, "compensated": now}.get(algorithm)
    if seen is None:
        raise ValueError(f"algorithm {algorithm!r}: must be 'staggered', 'jacobi' or 'compensated'")
    v, u = R @ seen[:n], R @ seen[n:]
    if algorithm == "compensated":
        older, b1, b2 = history
        known, known_before = (Y @ (f - (1 - MEMORY) * f_before) for f, f_before in ((held, before), (before, older)))
        b0 = v - v_before - known_before
        part = _part_of_parabola(contact, Y)
        rest = part * (3 * b0 - 3 * b1 + b2) + (1 - part) * DECAY * b0
        rest2 = part * (6 * b0 - 8 * b1 + 3 * b2) + (1 - part) * DECAY**2 * b0
        following, change = v + known + rest, MEMORY * Y @ held + rest2
        v_ahead = following + change / 2 - part * (rest2 - rest) / 6
        u_ahead = u + h * (v / 2 + following + (change - rest + b0) / 12)
        return np.vstack([stepped, _law(contact, Y, v_ahead - Y @ held, u_ahead), held, v, before, b0, b1])
    v_ahead = v + 0.5 * (v - v_before - Y @ (held - before))
    return np.vstack([stepped, _law(contact, Y, v_ahead - Y @ held, u + 0.5 * h * v), held, v])


def _part_of_parabola(contact: LinearContact, Y: Real) -> Real:
    """Return how much of a parabola is in the extrapolation of each direction, (4, 1) from 0 to 1."""
    t = TANGENTIAL
    newton = np.linalg.inv(np.eye(3) - contact.H1 @ Y[np.ix_(t, t)])
    part = np.ones((4, 1))
    part[t] = np.clip((newton.diagonal().min() - STICK) / (SLIP - STICK), 0.0, 1.0)
    return part


def _law(contact: LinearContact, Y: Real, v: Real, u: Real) -> Real:
    """Return the contact forces that solve F = H1 (v + Y F) + h2 f_n and f_n = -K u; all are rows over the state."""
    t, k = TANGENTIAL, NORMAL
    forces = np.zeros_like(v)
    forces[k] = -contact.stiffness * u[k]
    known = contact.H1 @ (v[t] + np.outer(Y[t, k], forces[k])) + np.outer(contact.h2, forces[k])
    forces[t] = np.linalg.solve(np.eye(3) - contact.H1 @ Y[np.ix_(t, t)], known)
    return forces


def _exact_step(A: Real, n: int, h: float) -> tuple[Real, Real]:
    """Return the exact step of the modes: (2n, 2n) transition and (2n, n) answer to a held modal force."""
    block = np.zeros((3 * n, 3 * n))
    block[: 2 * n, : 2 * n] = A
    block[:n, 2 * n :] = np.eye(n)
    # modes do not couple: exponentials of 3 x 3 blocks
    phi, gamma = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, n))
    for i in range(n):
        index = np.array([i, n + i, 2 * n + i])
        e = expm(block[np.ix_(index, index)] * h)
        phi[np.ix_(index[:2], index[:2])] = e[:2, :2]
        gamma[index[:2], i] = e[:2, 2]
    return phi, gamma


@dataclass(frozen=True)
class SchemeError:
    """Exact and discrete growth rates of the same modes, sorted by frequency.

    Attributes
    ----------
    frequency_hz : (p,) of the coupled system [Hz]
    exact, discrete : (p,) growth rates [1/s]
    """

    frequency_hz: Real
    exact: Real
    discrete: Real

    @property
    def error(self) -> Real:
        """Growth that the scheme adds [1/s]."""
        return self.discrete - self.exact

    @property
    def invented(self) -> int:
        """Number of stable modes that the scheme makes unstable."""
        return int(((self.exact <= 0) & (self.discrete > 0)).sum())


def scheme_error(
    wheel: Modes, rail: Modes, contact: LinearContact, h: float, algorithm: str = "staggered", below_hz: float = 5000.0
) -> SchemeError:
    """Compare the growth rates of a scheme with those of the coupled system, for all modes below a frequency."""
    exact = closed_loop_poles(wheel, rail, contact).below(below_hz)
    z = np.linalg.eigvals(step_map(wheel, rail, contact, h, algorithm))
    found = poles_of(np.log(z[np.abs(z) > 1e-12]) / h)
    return _pair(exact, found)


def _pair(exact: Poles, found: Poles) -> SchemeError:
    """Give each exact pole the nearest discrete one, each used once."""
    a = exact.growth_rate + 2j * np.pi * exact.frequency_hz
    b = found.growth_rate + 2j * np.pi * found.frequency_hz
    rows, columns = linear_sum_assignment(np.abs(a[:, None] - b[None, :]))
    return SchemeError(exact.frequency_hz[rows], exact.growth_rate[rows], found.growth_rate[columns])
