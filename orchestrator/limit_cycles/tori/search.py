"""What a cycle with growing sidebands breaks up into: a cycle in, a torus out, or how far the equations were solved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ..catalogue import Catalogue, Cycle
from ..continuation import Curve, newton, tangent
from .balance import TwoToneBalance, TwoTones
from .lines import Lines
from .start import start_of
from .torus import Torus

Real = NDArray[np.floating[Any]]

WIDE, LONG = Lines((8, 8), (32, 32)), Lines((20, 6), (80, 28))
"""Lines with which a torus is looked for: as many of both frequencies, or most of the first, for slow second ones."""

FINER = {
    WIDE: (Lines((12, 12), (48, 48)), Lines((16, 16), (64, 64))),
    LONG: (Lines((30, 8), (128, 36)),),
}
"""Lines with which it is solved again."""

SLOW = 0.25
"""Second frequency, in parts of the first, below which that is slow."""

LARGEST = 0.6
"""Amplitude of the second tone up to which a curve is followed [m/s]."""

STANDS_STILL = 2e-3
"""Relative change of the rms velocity at which there are lines enough."""

_POINTS = 80
_LARGEST_CHANGE = 0.1
_LARGEST_STEP = 0.25

_NOTHING = 0.1
"""Amplitude of the first tone, in parts of the second, below which that has taken over."""


@dataclass(frozen=True)
class BreakUp:
    """What a cycle with growing sidebands breaks up into.

    Attributes
    ----------
    cycle : that breaks up
    torus : two tones at once; None if the equations were not solved
    tried : what was tried without an answer, and how far it came, one sentence each
    """

    cycle: Cycle
    torus: Torus | None
    tried: tuple[str, ...]

    @property
    def words(self) -> str:
        """The fate of the cycle in words."""
        if self.torus is not None:
            return f"{self.cycle.fate} into {self.torus.words}"
        if not self.tried:
            return self.cycle.fate
        return f"{self.cycle.fate}; two tones at once were not found: " + "; ".join(self.tried)


def break_ups(
    found: Catalogue, report: Callable[[str, int, int], None] = lambda _what, _done, _all: None
) -> tuple[BreakUp, ...]:
    """Return what each cycle with growing sidebands breaks up into; their stability must have been asked for."""
    chosen = [c for c in found.cycles if c.stability is not None and c.stability.kind == "sidebands"]
    results = []
    for number, cycle in enumerate(chosen):
        report(f"two tones from {cycle.frequency_hz:.0f} Hz", number, len(chosen))
        results.append(break_up(cycle))
    return tuple(results)


def break_up(cycle: Cycle) -> BreakUp:
    """Return what a cycle with growing sidebands breaks up into.

    Notes
    -----
    The second tone is followed from zero by its amplitude, with the growth rate at that amplitude as unknown, until
    that is zero. Which lines there must be is not known beforehand, so two choices are tried.
    """
    assert cycle.stability is not None
    exponent = cycle.stability.largest
    slow = exponent.imag < SLOW * cycle.state.omega
    tried: list[str] = []
    with threadpool_limits(1, "blas"):
        for lines in (LONG, WIDE) if slow else (WIDE, LONG):
            begin = start_of(cycle.balance, cycle.state, exponent, lines, folded=lines is LONG)
            words = f"with {len(lines.numbers)} lines"
            if begin is None:
                tried.append(f"{words} the cycle and its perturbation are not found again")
                continue
            walk = _walk(*begin)
            torus = _refined(begin[0], walk.closed) if walk.closed is not None else None
            if torus is not None:
                return BreakUp(cycle, torus, tuple(tried))
            tried.append(f"{words} {walk.words}")
            if walk.taken_over:
                break
    return BreakUp(cycle, None, tuple(tried))


@dataclass(frozen=True)
class _Walk:
    """How far a second tone was followed.

    Attributes
    ----------
    closed : motion at which it neither grows nor dies; None if none was found
    words : how far it was followed
    taken_over : whether nothing is left of the first tone there
    """

    closed: TwoTones | None
    words: str
    taken_over: bool = False


def _walk(balance: TwoToneBalance, guess: TwoTones) -> _Walk:
    """Follow a second tone from a first guess until it neither grows nor dies."""
    amplitude = np.zeros(balance.size)
    amplitude[-2] = 1.0
    x = balance.pack(guess)
    start = newton(balance, x, amplitude, float(x[-2]))
    if not start.solved:
        return _Walk(None, f"its second tone does not start (residual {start.residual:.1e})")
    direction = tangent(start.jacobian, balance.weights, amplitude)
    curve = Curve(balance, start.x, direction, smallest=1e-3, largest=_LARGEST_STEP)
    before, state = start.x, balance.unpack(start.x)
    for _ in range(_POINTS):
        found = curve.advance()
        if found is None:
            break
        state = balance.unpack(found.x)
        first, second = balance.amplitudes(state)
        if first < _NOTHING * second:
            words = f"the second tone takes over: at {second:.3f} m/s {first:.3f} m/s are left of the first"
            return _Walk(None, words, taken_over=True)
        if before[-1] * found.x[-1] < 0:
            return _zero(balance, before, found.x)
        if not 0 < state.amplitude < LARGEST:
            break
        before = found.x
    return _Walk(
        None,
        f"the second tone was followed to {state.amplitude:.3f} m/s, where its growth rate is {state.sigma:.2g} 1/s, "
        "and no further",
    )


def _zero(balance: TwoToneBalance, before: Real, after: Real) -> _Walk:
    """Return the motion without growth between two points of a curve."""
    row = np.zeros(balance.size)
    row[-1] = 1.0
    part = before[-1] / (before[-1] - after[-1])
    guess = before + part * (after - before)
    zero = newton(balance, guess, row, 0.0, limit=30)
    state, expected = balance.unpack(zero.x), balance.unpack(guess).amplitude
    if zero.solved and abs(state.amplitude - expected) < 0.3 * expected:
        return _Walk(state, f"two tones were solved at {expected:.3f} m/s and got lost with more lines")
    return _Walk(None, f"the equations are not solved at {expected:.3f} m/s (residual {zero.residual:.1e})")


def _refined(balance: TwoToneBalance, state: TwoTones) -> Torus | None:
    """Return a torus with as many lines as it takes; None if it gets lost."""
    torus = Torus(balance, state, 0.0, np.inf)
    for lines in FINER[balance.lines]:
        finer = balance.with_lines(lines)
        row = np.zeros(finer.size)
        row[-1] = 1.0
        found = newton(finer, finer.pack(torus.balance.resized(torus.state, lines)), row, 0.0, limit=30)
        again = Torus(finer, finer.unpack(found.x), found.residual, np.inf)
        change = abs(again.wheel_velocity_rms["lat"] / torus.wheel_velocity_rms["lat"] - 1)
        if not found.solved or change > _LARGEST_CHANGE:
            return None
        torus = replace(again, rms_change=change)
        if change < STANDS_STILL:
            break
    return torus
