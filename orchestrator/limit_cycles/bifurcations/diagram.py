"""A cycle against a parameter: where it is born, where it turns back, where it stops to last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fmus.errors import DataError

from ...errors import InputError
from ..balance import Balance, State, Truncation
from ..catalogue import Cycle
from ..continuation import Curve, newton, tangent
from ..fate import UNDECIDED
from ..floquet import floquet
from ..measures import motion_of, rms
from .marks import FREE, SMALLEST, Mark, marks_of, state_between
from .parameter import Parameter

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

TRUNCATION = Truncation(20, 256)
LARGEST = 0.6
_POINTS = 150


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
    unit : of the parameter
    """

    parameter: str
    value: Real
    amplitude: Real
    frequency_hz: Real
    wheel_rms: Real
    exponent: Complex
    marks: tuple[Mark, ...]
    ends: tuple[str, str]
    unit: str = "1"

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
    span : smallest and largest value; beyond what the parameter can be the branch stops and says so

    Raises
    ------
    InputError
        If the range is none, does not contain the value of the system, or the cycle is not found again.
    """
    low, high = span
    if not low < high:
        raise InputError(f"{parameter.name} = {low:g}:{high:g}: must be a range from a smaller to a larger number")
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
        inside = Span(max(low, parameter.low), min(high, parameter.high), span)
        back, first = _walk(balance, start, -1.0, inside)
        on, last = _walk(balance, start, 1.0, inside)
        states = [*back[:0:-1], *on]
        exponents = _exponents(balance, states, with_stability, report)
        marks = marks_of(balance, states, exponents)
    return Branch(
        parameter.name,
        np.array([s.free for s in states]),
        np.array([s.amplitude for s in states]),
        np.array([s.frequency_hz for s in states]),
        np.array([float(rms(motion_of(balance, s).wheel)[1]) for s in states]),
        exponents,
        tuple(marks),
        (first, last),
        parameter.unit,
    )


@dataclass(frozen=True)
class Span:
    """The values of a parameter that a branch is followed through, of those that were asked for."""

    low: float
    high: float
    asked: tuple[float, float]

    def words(self, end: float) -> str:
        """Say why a branch ends at an end of the range."""
        return "leaves the range" if end in self.asked else f"stops: the parameter cannot go beyond {end:g}"


def _walk(balance: Balance, start: State, side: float, span: Span) -> tuple[list[State], str]:
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
        try:
            found_next = curve.advance()
        except (DataError, InputError) as reason:
            return states, f"stops at {states[-1].free:.4g}: {reason}"
        if found_next is None:
            return states, f"cannot be followed beyond {states[-1].free:.4g}"
        state = balance.unpack(curve.x)
        if state.amplitude < SMALLEST:
            return [*states, *_birth(balance, states[-1])], "is born there"
        if not span.low <= state.free <= span.high:
            end = span.low if state.free < span.low else span.high
            last = state_between(balance, states[-1], state, FREE, end)
            return [*states, *([] if last is None else [last])], span.words(end)
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
        "unit": branch.unit,
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
