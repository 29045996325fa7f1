"""What becomes of a cycle, in words: stable, threshold, breaks up through sidebands, period doubles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .balance import LADDER, Balance, State
from .floquet import Floquet, floquet
from .hill import Sidebands, hill
from .model import LAT
from .refinement import solve_free

Complex = NDArray[np.complexfloating[Any, Any]]

UNDECIDED = 0.02
"""Growth rate below which, either sign, nothing is said about stability [1/s]."""

PHASE_ERROR = 0.25
"""Growth rate of the phase, which is 0, beyond which the cycle needs more harmonics [1/s]."""

FEWEST_HARMONICS = 40
"""Harmonics that the stability of a cycle needs: the slopes of the law jump between stick and slip."""

_REAL_HZ = 0.05
_HALF = 2e-3


@dataclass(frozen=True)
class Stability:
    """Whether a cycle lasts.

    Attributes
    ----------
    floquet : exponents from the monodromy matrix
    sidebands : the fastest growing perturbation at frequencies; None where the exponent is real or it was not found
    error : what the exponent may be off by: the difference of both ways, or the phase's distance from zero [1/s]
    kind : stable, undecided, threshold, sidebands or period doubling
    threshold : whether a perturbation without frequency grows: less than the cycle falls, more rises
    sideband_hz : frequencies of the strongest lines of the perturbation [Hz]
    """

    floquet: Floquet
    sidebands: Sidebands | None
    error: float
    kind: str
    threshold: bool
    sideband_hz: tuple[float, ...]

    @property
    def largest(self) -> complex:
        """The exponent that grows fastest [1/s]."""
        return self.floquet.largest

    @property
    def largest_hz(self) -> float:
        """Its frequency [Hz]."""
        return self.largest.imag / (2 * np.pi)

    @property
    def stable(self) -> bool | None:
        """Whether all perturbations die out; None if that is within the error."""
        return {"stable": True, "undecided": None}.get(self.kind, False)

    @property
    def words(self) -> str:
        """The fate in words."""
        first = "threshold: less falls, more rises" if self.threshold else ""
        if self.kind == "sidebands":
            lines = " and ".join(f"{f:.0f}" for f in self.sideband_hz)
            return "; ".join(filter(None, (first, f"breaks up through sidebands at {lines} Hz")))
        if self.kind == "period doubling":
            return "; ".join(filter(None, (first, f"period doubles: a line at {self.sideband_hz[0]:.1f} Hz grows")))
        undecided = f"not decided: its largest exponent, {self.largest.real:+.3f} 1/s, is within the error of zero"
        return {"stable": "stable", "undecided": undecided}.get(self.kind, first)


def stability(balance: Balance, state: State) -> tuple[Balance, State, Stability]:
    """Return the stability of a cycle, and the cycle with as many harmonics as it took.

    Notes
    -----
    The verdict is the monodromy matrix's. The exponent of a complex pair is found a second time by Hill's determinant;
    a real one is not, for that is off by some 1/s there.
    """
    tried: list[Floquet] = []
    for truncation in LADDER:
        if truncation.harmonics < max(FEWEST_HARMONICS, balance.truncation.harmonics):
            continue
        if truncation != balance.truncation:
            finer = balance.at(truncation.harmonics, truncation.samples)
            solved = solve_free(finer, state.resized(truncation.harmonics))
            if solved is None:
                break
            balance, state = finer, solved[0]
        tried.append(floquet(balance, state))
        if abs(tried[-1].phase) < PHASE_ERROR:
            break
    return balance, state, _judge(balance, state, tried or [floquet(balance, state)])


def _judge(balance: Balance, state: State, tried: Sequence[Floquet]) -> Stability:
    """Put exponents into words: those of the last truncation that was tried."""
    exponents = tried[-1]
    largest = exponents.largest
    pair = not _is_real(largest)
    sidebands = hill(balance, state, largest) if pair else None
    error = abs(exponents.phase) if np.isfinite(exponents.phase) else float("inf")
    if sidebands is not None:
        error = abs(sidebands.exponent.real - largest.real)
    # a motion that the contact does not see keeps its exponent from truncation to truncation, whatever the phase does
    moved = max((abs(largest - other.largest) for other in tried[:-1]), default=error)
    doubtful = not abs(exponents.phase) < PHASE_ERROR and abs(largest.real) < moved
    if abs(largest.real) < UNDECIDED or doubtful:
        kind = "undecided"
    elif largest.real < 0:
        kind = "stable"
    elif not pair:
        kind = "threshold"
    else:
        kind = "period doubling" if abs(largest.imag) / state.omega > 0.5 - _HALF else "sidebands"
    lines = () if sidebands is None else strongest_lines(balance, state, sidebands)
    if kind == "period doubling":
        lines = (state.frequency_hz / 2,)
    growing = exponents.exponents[exponents.exponents.real > UNDECIDED]
    return Stability(exponents, sidebands, float(error), kind, any(map(_is_real, growing)), lines)


def _is_real(exponent: complex) -> bool:
    """Whether an exponent is that of a perturbation without frequency."""
    return abs(exponent.imag) < 2 * np.pi * _REAL_HZ


def strongest_lines(balance: Balance, state: State, sidebands: Sidebands, count: int = 2) -> tuple[float, ...]:
    """Return the frequencies of the strongest lateral lines of a perturbation [Hz], rising."""
    H = balance.truncation.harmonics
    s = sidebands.exponent + 1j * np.arange(-H, H + 1) * state.omega
    T, _ = balance.model_of(state).response(s)
    motion = np.abs((T @ sidebands.forces[:, :, None])[:, balance.active.index(LAT), 0])
    chosen = np.argsort(-motion)[:count]
    return tuple(sorted(float(abs(s[k].imag)) / (2 * np.pi) for k in chosen))
