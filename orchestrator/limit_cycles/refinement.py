"""A cycle made exact: more harmonics and samples until its level stands still."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .balance import LADDER, Balance, State, Truncation
from .continuation import newton

Real = NDArray[np.floating[Any]]

STANDS_STILL = 3e-4
"""Relative change of the rms velocity at which a truncation is fine enough."""

_LARGEST_CHANGE = 0.2


@dataclass(frozen=True)
class Refined:
    """A cycle at the truncation that it needs.

    Attributes
    ----------
    balance, state : equations and solution
    residual : largest scaled residual
    change : relative change of the rms velocity against the truncation before
    """

    balance: Balance
    state: State
    residual: float
    change: float


@dataclass(frozen=True)
class Lost:
    """A cycle that is not found again with more harmonics.

    Attributes
    ----------
    words : how far it came
    """

    words: str


def refine(balance: Balance, state: State, ladder: tuple[Truncation, ...] = LADDER) -> Refined | Lost:
    """Return the cycle at a truncation from which its level does not change any more, or how far it was solved.

    The last truncation is taken as it is; `change` tells how far it is from the one before.
    """
    level = relative_rms(balance, state)
    residual, change = np.inf, np.inf
    for truncation in ladder:
        finer = balance.at(truncation.harmonics, truncation.samples)
        solved = solve_free(finer, state.resized(truncation.harmonics))
        if solved is None:
            return _lost(balance, state, truncation, "is not solved")
        found, residual = solved
        if abs(found.amplitude - state.amplitude) > _LARGEST_CHANGE * state.amplitude:
            return _lost(balance, state, truncation, f"becomes one of {found.amplitude:.3f} m/s")
        new = relative_rms(finer, found)
        finer_indeed = truncation.harmonics > balance.truncation.harmonics
        change = abs(new / level - 1) if finer_indeed else np.inf
        balance, state, level = finer, found, new
        if change < STANDS_STILL:
            break
    return Refined(balance, state, residual, change)


def _lost(balance: Balance, state: State, tried: Truncation, words: str) -> Lost:
    """Return the sentence about a cycle that was solved at one truncation and not at the next."""
    return Lost(
        f"the cycle at {state.frequency_hz:.1f} Hz, {state.amplitude:.3f} m/s, was solved with "
        f"{balance.truncation.harmonics} harmonics; with {tried.harmonics} it {words}"
    )


def solve_free(balance: Balance, state: State) -> tuple[State, float] | None:
    """Solve with the free unknown held; None without a solution. Amplitude zero solves, too: the caller compares."""
    row = np.zeros(balance.size)
    row[-1] = 1.0
    x = balance.pack(state)
    found = newton(balance, x, row, float(x[-1]), limit=30)
    return (balance.unpack(found.x), found.residual) if found.solved else None


def relative_rms(balance: Balance, state: State) -> float:
    """Return the rms of the relative motion in the reference direction."""
    T, _ = balance.responses(state)
    lines = (T @ state.forces[:, :, None])[1:, balance.active.index(balance.reference), 0]
    return float(np.sqrt(2 * np.sum(np.abs(lines) ** 2)))
