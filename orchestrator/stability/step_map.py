"""What a master algorithm makes of a linear system: the map from one step to the next, and the poles it shows.

A co-simulation of a linear system is itself linear: its state after a step is a matrix times its state before. The
matrix's eigenvalues z appear to an observer as poles ln(z)/h. Their real parts against the poles of the coupled system
are the growth that the algorithm adds, mode by mode.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.optimize import linear_sum_assignment

from fmus.contact.linearised import LinearContact
from fmus.contact.prediction import DECAY, MEMORY, SLIP, STICK
from fmus.modal.modes import Modes, state_space

from ..coupling.algorithms import find_algorithm
from .poles import NORMAL, TANGENTIAL, OpenSystem, Poles, Structure, eigenvalues, poles_of

Real = NDArray[np.float64]

COMPENSATED = "compensated"
"""Jacobi with the contact's parameter host_delay_steps = 1."""

BELOW_HZ = 5000.0
"""Modes up to here are compared [Hz]."""

WEAK = -5.0
"""Modes with an exact growth rate above this are those that a small error can make squeal [1/s]."""


def step_map(
    wheel: Structure,
    rail: Structure,
    contact: LinearContact,
    h: float,
    algorithm: str = "staggered",
    integrated: Collection[str] = (),
) -> Any:
    """Return the matrix of one step.

    Parameters
    ----------
    h : communication step [s]
    algorithm : name of a master algorithm, or `COMPENSATED`
    integrated : wheel, rail or both: whose velocities the contact integrates, for want of their displacements

    Returns
    -------
    (m + 12, m + 12) array for the state (the m states of the structures, held contact forces, the forces before them,
    the relative velocities before), all but the first in contact axes; with integrated velocities one more, their
    compression of the spring

    Notes
    -----
    The forces over a step are (1 - s) F_n + s F_n+1 with the algorithm's share s of new values; s = 0 holds the old
    ones. With s > 0 the contact's answer to its own force is solved for, which is what the iteration converges to.
    """
    if algorithm == COMPENSATED:
        return _compensated_step_map(wheel, rail, contact, h)
    rule = find_algorithm(algorithm)
    system, phi, drive = _sampled(wheel, rail, contact, h)
    V, m = system.V, len(phi)
    Y = (V @ drive).real
    unit = np.eye(m + (13 if integrated else 12))
    now, held, before, v_before, compression = np.split(unit, [m, m + 4, m + 8, m + 12])
    law = _Law(contact, Y, h)
    see = _compression(system, h, integrated)
    stepped = np.hstack([phi, (1 - rule.share) * drive, np.zeros((m, len(unit) - m - 4))])
    seen = now if rule.simultaneous else stepped
    v = V @ seen
    v_ahead = v + 0.5 * (v - v_before - Y @ (held - before))
    known = compression if integrated else 0.0
    forces = law.forces(v_ahead - Y @ held, known + see[0] @ seen)
    if rule.share:
        own = law.forces(1.5 * rule.share * V @ drive, rule.share * see[0] @ drive)
        forces = np.asarray(np.linalg.solve(np.eye(4) - own, forces))
        stepped = np.asarray(stepped + rule.share * drive @ forces)
        seen = stepped
        v = V @ seen
    kept = [known + see[1] @ seen] if integrated else []
    return np.vstack([stepped, forces, held, v, *kept])


def _compression(system: OpenSystem, h: float, integrated: Collection[str]) -> tuple[Any, Any]:
    """Return the spring's compression by the states, and the part of it that is kept: (1, m) each.

    A side with displacements compresses by -(u + h/2 v); the velocities of the others are summed up, -h v a step.
    """
    summed = np.where(system.rail, "rail" in integrated, "wheel" in integrated)
    kept = -h * system.V[[NORMAL]] * summed
    return kept - (system.U[[NORMAL]] + 0.5 * h * system.V[[NORMAL]]) * ~summed, kept


def _sampled(wheel: Structure, rail: Structure, contact: LinearContact, h: float) -> tuple[OpenSystem, Any, Any]:
    """Return wheel and rail side by side, the exact step of their state, and its answer to held contact forces."""
    open_system = OpenSystem.of(wheel, rail, contact.turn)
    if isinstance(wheel, Modes) and isinstance(rail, Modes):
        phi, gamma = _exact_step(open_system.A, len(wheel) + len(rail), h)
        return open_system, phi, gamma @ open_system.B[: gamma.shape[1]]
    steps = [_step_of(structure, h) for structure in (wheel, rail)]
    answer = block_diag(steps[0][1], steps[1][1])
    return open_system, block_diag(steps[0][0], steps[1][0]), answer @ open_system.B


def _step_of(structure: Structure, h: float) -> tuple[Any, Any]:
    """Return the exact step of one structure's state, and its integral over the step: the answer to a held rate."""
    if isinstance(structure, Modes):
        n = len(structure)
        phi, gamma = _exact_step(state_space(structure)[0], n, h)
        return phi, np.hstack([gamma, np.zeros((2 * n, n))])
    return np.diag(np.exp(structure.pole * h)), np.diag(np.expm1(structure.pole * h) / structure.pole)


def _compensated_step_map(wheel: Structure, rail: Structure, contact: LinearContact, h: float) -> Any:
    """Return the matrix of one Jacobi step with a contact that makes up for its late inputs.

    The state of `step_map`, then the forces before those and the rests of the last two changes of the velocities, see
    `fmus.contact.prediction`: (m + 24, m + 24), m states of the structures.
    """
    system, phi, drive = _sampled(wheel, rail, contact, h)
    V, U, m = system.V, system.U, len(phi)
    Y = (V @ drive).real
    unit = np.eye(m + 24)
    now, held, before, v_before, older, b1, b2 = np.split(unit, range(m, len(unit), 4))
    stepped = phi @ now + drive @ held
    v, u = V @ now, U @ now
    known, known_before = (Y @ (f - (1 - MEMORY) * f_before) for f, f_before in ((held, before), (before, older)))
    b0 = v - v_before - known_before
    part = _part_of_parabola(contact, Y)
    rest = part * (3 * b0 - 3 * b1 + b2) + (1 - part) * DECAY * b0
    rest2 = part * (6 * b0 - 8 * b1 + 3 * b2) + (1 - part) * DECAY**2 * b0
    following, change = v + known + rest, MEMORY * Y @ held + rest2
    v_ahead = following + change / 2 - part * (rest2 - rest) / 6
    u_ahead = u + h * (v / 2 + following + (change - rest + b0) / 12)
    forces = _Law(contact, Y, h).forces(v_ahead - Y @ held, -u_ahead[[NORMAL]])
    return np.vstack([stepped, forces, held, v, before, b0, b1])


def _part_of_parabola(contact: LinearContact, Y: Real) -> Real:
    """Return how much of a parabola is in the extrapolation of each direction, (4, 1) from 0 to 1."""
    t = TANGENTIAL
    newton = np.linalg.inv(np.eye(3) - contact.H1 @ Y[np.ix_(t, t)])
    part = np.ones((4, 1))
    part[t] = np.clip((newton.diagonal().min() - STICK) / (SLIP - STICK), 0.0, 1.0)
    return part


@dataclass(frozen=True)
class _Law:
    """The linear contact in a step; matrices have one row per quantity and one column per unknown.

    Attributes
    ----------
    Y : (4, 4) interface mobility that the contact knows
    h : communication step [s]
    """

    contact: LinearContact
    Y: Real
    h: float

    def forces(self, v: Any, compression: Any) -> Any:
        """Return the contact forces that solve F = H1 (v + Y F) + h2 f_n and f_n = K times compression, (4, m)."""
        t, k, H1 = TANGENTIAL, NORMAL, self.contact.H1
        forces = np.zeros_like(v)
        forces[k] = self.contact.stiffness * compression[0]
        known = H1 @ (v[t] + np.outer(self.Y[t, k], forces[k])) + np.outer(self.contact.h2, forces[k])
        forces[t] = np.linalg.solve(np.eye(3) - H1 @ self.Y[np.ix_(t, t)], known)
        return forces


def _exact_step(A: Real, n: int, h: float) -> tuple[Real, Real]:
    """Return the exact step of the modes: (2n, 2n) transition and (2n, n) answer to a held modal force.

    Notes
    -----
    Each mode has the matrix [[2a, -w^2], [1, 0]] with the eigenvalues a + b and a - b; so exp(A h) is
    c I + s (A - a I) with c and s from the exponentials of these.
    """
    i = np.arange(n)
    a, w2 = 0.5 * A[i, i], -A[i, n + i]
    b = np.sqrt(a * a - w2 + 0j)
    fast, slow = np.exp((a - b) * h), np.exp((a + b) * h)
    c = 0.5 * (fast + slow).real
    s = np.where(np.abs(b) * h > 1e-6, ((slow - fast) / np.where(b == 0, 1, 2 * b)).real, h * np.exp(a * h))
    shift = np.where(w2 * h * h > 1e-12, (1 - c + a * s) / np.where(w2 == 0, 1, w2), 0.5 * h * h)
    phi, gamma = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, n))
    phi[i, i], phi[i, n + i], phi[n + i, i], phi[n + i, n + i] = c + a * s, -w2 * s, s, c - a * s
    gamma[i, i], gamma[n + i, i] = s, shift
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

    @property
    def largest(self) -> float:
        """Largest error of a growth rate, either sign [1/s]; 0 without modes."""
        return float(abs(self.error).max(initial=0.0))

    @property
    def largest_weak(self) -> float:
        """The same among the modes that decide about squeal: those with an exact growth rate above -5 1/s."""
        return float(abs(self.error[self.exact > WEAK]).max(initial=0.0))


def discrete_poles(matrix: Any, h: float) -> Poles:
    """Return the poles that an observer of the steps sees."""
    z = eigenvalues(matrix)
    return poles_of(np.log(z[np.abs(z) > 1e-12]) / h)


def compare_growth(exact: Poles, found: Poles) -> SchemeError:
    """Give each exact pole the nearest discrete one, each used once."""
    a = exact.growth_rate + 2j * np.pi * exact.frequency_hz
    b = found.growth_rate + 2j * np.pi * found.frequency_hz
    rows, columns = linear_sum_assignment(np.abs(a[:, None] - b[None, :]))
    return SchemeError(exact.frequency_hz[rows], exact.growth_rate[rows], found.growth_rate[columns])
