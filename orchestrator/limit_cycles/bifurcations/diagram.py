"""A cycle against a parameter: where it is born, where it turns back, where it stops to last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ...errors import InputError
from ..balance import Balance, State, Truncation
from ..catalogue import Cycle
from ..continuation import Curve, newton, tangent
from ..fate import UNDECIDED
from ..floquet import floquet
from ..measures import motion_of, rms
from .parameter import Parameter

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

TRUNCATION = Truncation(20, 256)
SMALLEST = 0.004
"""Amplitude at which a branch has come to its birth [m/s]."""

LARGEST = 0.6
_POINTS = 150
_HALF = 0.49


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


@dataclass(frozen=True)
class Branch:
    """A cycle followed through a range of a parameter.

    Attributes
    ----------
    parameter : its name
    value, amplitude, frequency_hz, wheel_rms : (m,) along the branch
    exponent : (m,) largest exponent [1/s]; nan where it was not asked for
    marks : bifurcations in the order of the branch
    ends : why it ends at its first and at its last point, in words
    """

    parameter: str
    value: Real
    amplitude: Real
    frequency_hz: Real
    wheel_rms: Real
    exponent: Complex
    marks: tuple[Mark, ...]
    ends: tuple[str, str]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where the cycle lasts."""
        return self.exponent.real < -UNDECIDED

    def of(self, kind: str) -> list[float]:
        """Return the values of the parameter at the bifurcations of a kind."""
        return [m.value for m in self.marks if m.kind == kind]

    @property
    def words(self) -> str:
        """What the branch means, in words."""
        births, folds = self.of("Hopf"), self.of("fold")
        at_birth = [(b, f) for b in births for f in folds if np.sign(f - b) and self._turns(b, f)]
        if at_birth:
            b, f = at_birth[0]
            up = ("above", "below") if f < b else ("below", "above")
            return f"hysteresis: squeal starts {up[0]} {b:.4g} and stops {up[1]} {f:.4g}"
        if births:
            return f"squeal starts at {', '.join(f'{b:.4g}' for b in births)}"
        if folds:
            return f"the tone turns back at {', '.join(f'{f:.4g}' for f in folds)}"
        return "the tone is there over the whole range that was followed"

    def _turns(self, birth: float, fold: float) -> bool:
        """Whether the branch goes from its birth against the side of the tone to a fold."""
        small, large = self.amplitude < 0.5 * self.amplitude.max(), self.amplitude >= 0.5 * self.amplitude.max()
        beyond = np.sign(fold - birth)
        return bool(small.any() and large.any() and (np.sign(self.value[small] - birth) == beyond).mean() > 0.5)


def follow(
    cycle: Cycle,
    parameter: Parameter,
    span: tuple[float, float],
    with_stability: bool = True,
    report: Callable[[str, int, int], None] = lambda _what, _done, _all: None,
) -> Branch:
    """Follow a cycle through a range of a parameter, both ways.

    Parameters
    ----------
    cycle : at the value `parameter.start`, which must lie in the range
    span : smallest and largest value

    Raises
    ------
    InputError
        If the range is none, goes beyond what the parameter can have, or the cycle is not found again.
    """
    low, high = span
    if not parameter.low <= low < high <= parameter.high:
        raise InputError(
            f"{parameter.name} = {low:g}:{high:g}: must be a range within {parameter.low:g} to {parameter.high:g}"
        )
    if not low <= parameter.start <= high:
        raise InputError(
            f"{parameter.name} = {low:g}:{high:g}: must contain the value of the system, {parameter.start:g}"
        )
    with threadpool_limits(1, "blas"):
        balance = replace(
            cycle.balance.at(TRUNCATION.harmonics, TRUNCATION.samples),
            model_at=parameter.at,
            free_scale=(high - low) / 10,
        )
        start = replace(cycle.state.resized(TRUNCATION.harmonics), free=parameter.start)
        back, first = _walk(balance, start, -1.0, span)
        on, last = _walk(balance, start, 1.0, span)
        states = [*back[:0:-1], *on]
        exponents = _exponents(balance, states, with_stability, report)
    marks = _marks(states, exponents)
    return Branch(
        parameter.name,
        np.array([s.free for s in states]),
        np.array([s.amplitude for s in states]),
        np.array([s.frequency_hz for s in states]),
        np.array([float(rms(motion_of(balance, s).wheel)[1]) for s in states]),
        exponents,
        tuple(marks),
        (first, last),
    )


def _walk(balance: Balance, start: State, side: float, span: tuple[float, float]) -> tuple[list[State], str]:
    """Return the states on one side of a start, beginning with it, and why they end."""
    row = np.zeros(balance.size)
    row[-1] = 1.0
    x = balance.pack(start)
    found = newton(balance, x, row, float(x[-1]), limit=30)
    state = balance.unpack(found.x)
    if not found.solved or abs(state.amplitude / start.amplitude - 1) > 0.2:
        raise InputError(
            f"the cycle at {start.frequency_hz:.1f} Hz is not found again with {TRUNCATION.harmonics} harmonics"
        )
    curve = Curve(balance, found.x, tangent(found.jacobian, balance.weights, side * row), largest=0.5)
    states = [state]
    while len(states) < _POINTS:
        if curve.advance() is None:
            return states, f"cannot be followed beyond {states[-1].free:.4g}"
        state = balance.unpack(curve.x)
        if state.amplitude < SMALLEST:
            return [*states, *_birth(balance, states[-1])], "is born there"
        if not span[0] <= state.free <= span[1]:
            return states, "leaves the range"
        if state.amplitude > LARGEST:
            return states, "leaves the amplitudes of interest"
        states.append(state)
    return states, "was left after many points"


def _birth(balance: Balance, last: State) -> list[State]:
    """Return the last two states before a branch vanishes, at `SMALLEST` and half of it."""
    states = []
    row = np.zeros(balance.size)
    row[-2] = 1.0
    for amplitude in (SMALLEST, SMALLEST / 2):
        guess = replace(last, forces=last.forces * (amplitude / last.amplitude), amplitude=amplitude)
        x = balance.pack(guess)
        found = newton(balance, x, row, float(x[-2]), limit=30)
        if found.solved:
            states.append(balance.unpack(found.x))
    return states


def branch_as_json(branch: Branch) -> dict[str, Any]:
    """Return a branch as one JSON object; exponents are null where they were not asked for."""
    asked = ~np.isnan(branch.exponent)
    return {
        "parameter": branch.parameter,
        "value": branch.value.tolist(),
        "amplitude": branch.amplitude.tolist(),
        "frequency_hz": branch.frequency_hz.tolist(),
        "wheel_velocity_rms_lat": branch.wheel_rms.tolist(),
        "largest_exponent": [float(e.real) if a else None for e, a in zip(branch.exponent, asked, strict=True)],
        "stable": [bool(s) if a else None for s, a in zip(branch.stable, asked, strict=True)],
        "marks": [asdict(mark) for mark in branch.marks],
        "ends": list(branch.ends),
        "words": branch.words,
    }


def _exponents(balance: Balance, states: list[State], wanted: bool, report: Callable[[str, int, int], None]) -> Complex:
    """Return the largest exponent of each state; nan where it is not wanted."""
    exponents = np.full(len(states), complex("nan"))
    for k, state in enumerate(states if wanted else []):
        report("stability along the branch", k, len(states))
        exponents[k] = floquet(balance, state).largest
    return exponents


def _marks(states: list[State], exponents: Complex) -> list[Mark]:
    """Return the bifurcations along a branch."""
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
        marks.append((float(k), _fold(value[k - 1 : k + 2], amplitude[k - 1 : k + 2])))
    half = 0.5 * np.array([s.omega for s in states])
    for k in np.flatnonzero(exponents[:-1].real * exponents[1:].real < 0):
        pair = np.abs(exponents[k : k + 2].imag)
        grown = pair[int(exponents[k : k + 2].real.argmax())]
        if grown > 1.0:
            doubled = grown > 2 * _HALF * half[k]
            part = exponents[k].real / (exponents[k].real - exponents[k + 1].real)
            at, a = (float(v[k] + part * (v[k + 1] - v[k])) for v in (value, amplitude))
            marks.append((k + part, Mark("period doubling" if doubled else "Neimark-Sacker", at, a)))
    return [mark for _, mark in sorted(marks, key=lambda m: m[0])]


def _fold(value: Real, amplitude: Real) -> Mark:
    """Return the fold at the vertex of the parabola of the parameter over the amplitude through three points."""
    second, first, rest = np.polyfit(amplitude, value, 2)
    at = float(np.clip(-first / (2 * second), amplitude.min(), amplitude.max()))
    return Mark("fold", float((second * at + first) * at + rest), at)
