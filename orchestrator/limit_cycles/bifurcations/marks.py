"""Bifurcations along a branch of cycles: states and their exponents in, births, folds and losses of stability out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from ..balance import AMPLITUDE_SCALE, Balance, State
from ..continuation import newton
from ..floquet import floquet

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

SMALLEST = 0.004
"""Amplitude at which a branch has come to its birth [m/s]."""

AMPLITUDE, FREE = -2, -1
"""Places of amplitude and parameter among the unknowns."""

_HALF = 0.49
"""Part of the cycle's frequency from which a perturbation's frequency counts as half of it."""

_REAL = 1.0
"""Angular frequency below which a perturbation counts as one without frequency [rad/s]."""


@dataclass(frozen=True)
class Mark:
    """A bifurcation.

    Attributes
    ----------
    kind : Hopf, fold, Neimark-Sacker or period doubling
    value : of the parameter
    amplitude : of the cycle there [m/s]
    """

    kind: str
    value: float
    amplitude: float


def marks_of(balance: Balance, states: list[State], exponents: Complex) -> list[Mark]:
    """Return the bifurcations along a branch.

    Parameters
    ----------
    exponents : (m,) the largest of each state; nan where they were not asked for
    """
    value = np.array([s.free for s in states])
    amplitude = np.array([s.amplitude for s in states])
    marks: list[tuple[float, Mark]] = []
    for end, inner in ((0, 1), (-1, -2)):
        if len(states) > 2 and max(amplitude[end], amplitude[inner]) < 1.5 * SMALLEST:
            # near its birth the parameter is linear in the square of the amplitude
            squares = amplitude[[end, inner]] ** 2
            slope = (value[end] - value[inner]) / (squares[0] - squares[1])
            marks.append((end % len(states), Mark("Hopf", float(value[end] - slope * squares[0]), 0.0)))
    step = np.diff(value)
    for k in np.flatnonzero(step[:-1] * step[1:] < 0) + 1:
        marks.append((float(k), _fold(balance, states[k - 1 : k + 2])))
    for k in np.flatnonzero(exponents[:-1].real * exponents[1:].real < 0):
        if np.abs(exponents[k : k + 2].imag)[int(exponents[k : k + 2].real.argmax())] > _REAL:
            marks.append((float(k) + 0.5, _loss(balance, states[k], states[k + 1], exponents[k : k + 2])))
    return [mark for _, mark in sorted(marks, key=lambda m: m[0])]


def _fold(balance: Balance, states: list[State]) -> Mark:
    """Return the fold among three states: where the parameter over the amplitude has its extreme value.

    The vertex of the parabola through the three where that cannot be solved for.
    """
    before, middle, after = states
    sign = 1.0 if middle.free < before.free else -1.0
    value, amplitude = np.array([s.free for s in states]), np.array([s.amplitude for s in states])

    def at(a: float) -> float:
        near = before if (a - middle.amplitude) * (before.amplitude - middle.amplitude) > 0 else after
        found = state_between(balance, middle, near, AMPLITUDE, a)
        return float("inf") if found is None else sign * found.free

    best = minimize_scalar(at, bounds=(amplitude.min(), amplitude.max()), method="bounded", options={"xatol": 1e-5})
    if np.isfinite(best.fun) and best.fun <= sign * middle.free:
        return Mark("fold", float(sign * best.fun), float(best.x))
    second, first, rest = np.polyfit(amplitude, value, 2)
    vertex = float(np.clip(-first / (2 * second), amplitude.min(), amplitude.max()))
    return Mark("fold", float((second * vertex + first) * vertex + rest), vertex)


def _loss(balance: Balance, one: State, other: State, exponents: Complex) -> Mark:
    """Return the loss of stability between two states whose largest exponents differ in sign."""
    apart = np.abs(balance.pack(other) - balance.pack(one))
    place = AMPLITUDE if apart[AMPLITUDE] > apart[FREE] else FREE
    ends = (one.amplitude, other.amplitude) if place == AMPLITUDE else (one.free, other.free)
    known = {ends[0]: (one, complex(exponents[0])), ends[1]: (other, complex(exponents[1]))}

    def growth(at: float) -> float:
        if at not in known:
            state = state_between(balance, one, other, place, at)
            if state is None:
                raise _NotSolvedError
            known[at] = state, floquet(balance, state).largest
        return known[at][1].real

    try:
        at = float(brentq(growth, *ends, xtol=1e-2 * abs(ends[1] - ends[0])))
        growth(at)
    except _NotSolvedError:
        at = ends[int(np.abs(exponents.real).argmin())]
    state = known[at][0]
    grown = min((v for v in known.values() if v[1].real > 0), key=lambda v: v[1].real)
    doubled = abs(grown[1].imag) > _HALF * grown[0].omega
    return Mark("period doubling" if doubled else "Neimark-Sacker", state.free, state.amplitude)


class _NotSolvedError(Exception):
    """A state between two others is not found."""


def state_between(balance: Balance, one: State, other: State, place: int, value: float) -> State | None:
    """Return the state between two neighbours at a value of `AMPLITUDE` or `FREE`; None if it is not solved."""
    first, second = balance.pack(one), balance.pack(other)
    wanted = value / (AMPLITUDE_SCALE if place == AMPLITUDE else balance.free_scale)
    row = np.zeros(balance.size)
    row[place] = 1.0
    part = (wanted - first[place]) / (second[place] - first[place])
    found = newton(balance, first + part * (second - first), row, wanted, limit=30)
    state = balance.unpack(found.x)
    beside = abs(state.amplitude - one.amplitude) < 0.2 * one.amplitude + abs(other.amplitude - one.amplitude)
    return state if found.solved and beside else None
