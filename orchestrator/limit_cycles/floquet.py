"""Whether a cycle lasts: the growth of small perturbations over a period (monodromy matrix)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..stability.poles import NORMAL
from .balance import Balance, State
from .measures import Motion, motion_of, over_a_period
from .model import SquealModel
from .sampling import sample_law, step_perturbations

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

LONGEST_STEP = 8e-6
"""Longest step of the perturbations [s]."""

FEWEST_STEPS = 512

_NEAR_ZERO = 5.0


@dataclass(frozen=True)
class Floquet:
    """Exponents of a cycle: growth rates of perturbations.

    Attributes
    ----------
    exponents : (2n - 1,) without that of the phase, the largest growth first [1/s]; the imaginary part is an angular
        frequency between -omega/2 and omega/2
    phase : exponent of the phase as it was found; exactly 0 without numerical error [1/s]
    overlap : of its vector with the time derivative of the cycle, 0 to 1
    """

    exponents: Complex
    phase: float
    overlap: float

    @property
    def largest(self) -> complex:
        """The exponent that grows fastest, of a pair the one with positive frequency."""
        first = complex(self.exponents[0])
        return complex(first.real, abs(first.imag))


def floquet(balance: Balance, state: State) -> Floquet:
    """Return the exponents of a cycle.

    Notes
    -----
    Each mode steps exactly with the force of a step held; the slope of the law is the mean of those at the ends of the
    step, and the force it makes of the mean of the motion at both ends is solved for. The phase is told by its vector,
    not by its value: numerical errors move it, and an amplitude exponent may lie nearer to zero.
    """
    model, motion = balance.model_of(state), motion_of(balance, state)
    matrix = monodromy(model, motion)
    period = 2 * np.pi / state.omega
    values = np.linalg.eigvals(matrix).astype(complex)
    with np.errstate(divide="ignore"):
        exponents = np.log(values) / period
    own = _energy(model, _derivative(motion))
    near = np.flatnonzero(np.abs(exponents) < _NEAR_ZERO)
    overlaps = [abs(own @ _energy(model, _vector(matrix, complex(values[k])))) for k in near]
    if not overlaps:
        return Floquet(exponents[np.argsort(-exponents.real)], float("nan"), 0.0)
    phase = near[int(np.argmax(overlaps))]
    others = np.delete(exponents, phase)
    return Floquet(others[np.argsort(-others.real)], float(exponents[phase].real), float(max(overlaps)))


def _vector(matrix: Real, value: complex) -> Complex:
    """Return the eigenvector of an eigenvalue, by inverse iteration."""
    shifted = matrix - value * (1 + 1e-10) * np.eye(len(matrix))
    vector = np.ones(len(matrix), complex)
    for _ in range(2):
        vector = np.linalg.solve(shifted, vector)
        vector /= np.linalg.norm(vector)
    return vector


def monodromy(model: SquealModel, motion: Motion, steps: int | None = None) -> Real:
    """Return what one period makes of perturbations of the states of wheel and rail, (2n, 2n).

    States are ordered as the first of every pair, then the second: modal velocities, then modal displacements.
    """
    period = 2 * np.pi / motion.omega
    N = steps or max(FEWEST_STEPS, int(np.ceil(period / LONGEST_STEP)))
    part, active = model.whole.only(model.active), np.array(model.active)
    advance, force = part.exact_step(period / N)
    forces, at_ends = np.empty((N, active.size)), np.empty((N, active.size, active.size))
    contact = model.instance
    sample_law(contact.parameters, contact.derived, active, over_a_period(motion.relative, N), forces, at_ends)
    slopes = 0.5 * (at_ends + np.roll(at_ends, -1, axis=0))
    seen = np.where((active == NORMAL)[:, None, None], part.displace, part.move)
    mean = seen + np.einsum("dni,nij->dnj", seen, advance)
    own = np.einsum("dni,nie->de", seen, force)
    answers = np.linalg.solve(np.eye(active.size) - 0.5 * slopes @ own, 0.5 * slopes)
    state = np.eye(2 * len(advance))
    step_perturbations(advance, _flat(force.transpose(2, 0, 1)).T.copy(), _flat(mean), answers, state)
    return state


def _flat(pairs: NDArray[Any]) -> NDArray[Any]:
    """Return (..., n, 2) as (..., 2n), the first of every pair before the second."""
    return np.ascontiguousarray(np.concatenate([pairs[..., 0], pairs[..., 1]], axis=-1))


def _derivative(motion: Motion) -> Real:
    """Return the time derivative of the states at the start of the period, (2n,)."""
    s = 1j * motion.omega * np.arange(len(motion.forces))[:, None, None]
    return _flat(over_a_period(s * motion.states)[0])


def _energy(model: SquealModel, vector: Real | Complex) -> Complex:
    """Return a state weighted by the root of its energy and scaled to length one."""
    weighted = _flat(model.whole.weight) * vector
    return np.asarray(weighted / np.linalg.norm(weighted), complex)
