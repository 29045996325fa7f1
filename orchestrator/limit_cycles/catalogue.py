"""All cycles of a system: poles in, a list of cycles with level and fate out."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from fmus.interface import DIRECTIONS

from ..errors import InputError
from .balance import Balance, State, Truncation
from .fate import Stability, stability
from .level import Radiator
from .measures import Contact, Motion, contact_over_a_period, motion_of, rms
from .model import SquealModel
from .refinement import Lost, Refined, refine
from .tracing import EFFORT, Effort, Pole, Trace, find_poles, trace

Real = NDArray[np.floating[Any]]

HIGHEST_HZ = 6500.0
"""Poles up to here are followed [Hz]: the modes of the wheels end there."""

NEAR = -1.0
"""Growth rate down to which stable poles are followed, too [1/s]: their tones need a push."""

SAME_HZ, SAME_AMPLITUDE = 0.05, 2e-3
"""Cycles that are nearer than this in frequency [Hz] and amplitude [m/s] are one."""

NEAR_TONE = 0.05
"""Relative distance from a tone within which poles are followed that it may be born from."""

COARSE = Truncation(6, 64)
RIGID = Truncation(12, 128)
"""Truncations of the curves: with a rail, and on a rigid one, where the normal force swings far."""


@dataclass(frozen=True)
class Cycle:
    """A periodic vibration that the system can have.

    Attributes
    ----------
    pole : that it is born from
    balance, state : equations and solution
    residual : largest scaled residual of the equations
    rms_change : relative change of the rms velocity at the last refinement
    motion : lines of forces, motion and modal displacements
    contact : what the contact does over a period
    level_dba : A-weighted level of the wheel at 7.5 m [dB(A)]; None if its radiating areas are not known
    stability : None if it was not asked for
    """

    pole: Pole
    balance: Balance
    state: State
    residual: float
    rms_change: float
    motion: Motion
    contact: Contact
    level_dba: float | None
    stability: Stability | None

    @property
    def frequency_hz(self) -> float:
        """Frequency [Hz]."""
        return self.state.frequency_hz

    @property
    def amplitude(self) -> float:
        """Amplitude of the first harmonic of the reference velocity [m/s]."""
        return self.state.amplitude

    @property
    def stable(self) -> bool | None:
        """Whether it lasts; None if that is not known."""
        return None if self.stability is None else self.stability.stable

    @property
    def fate(self) -> str:
        """What becomes of it, in words."""
        return "not looked at" if self.stability is None else self.stability.words

    @property
    def wheel_velocity_rms(self) -> dict[str, float]:
        """Rms velocity of the wheel by direction [m/s, rad/s]."""
        return dict(zip(DIRECTIONS, rms(self.motion.wheel).tolist(), strict=True))

    @property
    def rail_velocity_rms(self) -> dict[str, float]:
        """Rms velocity of the rail by direction [m/s, rad/s]."""
        return dict(zip(DIRECTIONS, rms(self.motion.rail).tolist(), strict=True))

    @property
    def normal_force(self) -> tuple[float, float]:
        """Smallest and largest normal force [N]."""
        force = self.contact.of("normal_force")
        return float(force.min()), float(force.max())


@dataclass(frozen=True)
class Catalogue:
    """The cycles of a system.

    Attributes
    ----------
    model : the system
    poles : all poles that move the contact below `HIGHEST_HZ`
    traces : curves that were followed
    cycles : sorted by frequency
    notes : what could not be followed, one sentence each
    """

    model: SquealModel
    poles: tuple[Pole, ...]
    traces: tuple[Trace, ...]
    cycles: tuple[Cycle, ...]
    notes: tuple[str, ...]

    def near(self, frequency_hz: float) -> Cycle:
        """Return the cycle at a frequency, the stable or else the largest one of those within 2 %.

        Raises
        ------
        InputError
            If there is none; the nearest ones are named.
        """
        return max(self.all_near(frequency_hz), key=lambda c: (c.stable is True, c.amplitude))

    def all_near(self, frequency_hz: float) -> tuple[Cycle, ...]:
        """Return all cycles within 2 % of a frequency; errors as of `near`."""
        close = tuple(c for c in self.cycles if abs(c.frequency_hz / frequency_hz - 1) < 0.02)
        if not close:
            words = "; ".join((f"no tone within 2 % of {frequency_hz:g} Hz", self.nearest_words(frequency_hz)))
            raise InputError("; ".join((words, *(self.notes if self.cycles else ()))))
        return close

    def nearest_words(self, frequency_hz: float) -> str:
        """Return the tones nearest to a frequency in words."""
        near = sorted(self.cycles, key=lambda c: abs(c.frequency_hz - frequency_hz))[:3]
        if not near:
            return self.quiet_words()
        return "the nearest are at " + ", ".join(f"{c.frequency_hz:.1f}" for c in near) + " Hz"

    def quiet_words(self) -> str:
        """Say that there is no tone, and which pole is nearest to one; or that none was found."""
        if not self.poles:
            return "no tone: nothing moves the contact"
        if self.notes:
            return "no tone was found, which does not mean that there is none: " + "; ".join(self.notes)
        p = max(self.poles, key=lambda p: p.growth_rate)
        return f"no tone: quiet, nearest pole {p.frequency_hz:.1f} Hz with {p.growth_rate:.3g} 1/s"


def find_cycles(  # noqa: PLR0913 - one argument per wish
    model: SquealModel,
    *,
    tone_hz: float | None = None,
    with_stability: bool = True,
    down_to: float = NEAR,
    radiator: Radiator | None = None,
    effort: Effort = EFFORT,
    report: Callable[[str, int, int], None] = lambda _what, _done, _all: None,
) -> Catalogue:
    """Return the cycles that are born from the poles of a system.

    Parameters
    ----------
    tone_hz : only the poles within 5 % of this frequency
    with_stability : whether to judge whether they last
    down_to : growth rate down to which stable poles are followed [1/s]
    radiator : what makes a level of the motion
    effort : how much is done for a curve until it is given up
    report : called with what is being done, and how much of it is done
    """
    with threadpool_limits(1, "blas"):  # matrices of this size are slower on several threads
        poles = tuple(p for p in find_poles(model) if p.frequency_hz < HIGHEST_HZ)
        chosen = _chosen(poles, tone_hz, down_to)
        truncation = COARSE if len(model.parts[1].blocks) else RIGID
        traces, notes = list[Trace](), list[str]()
        found: list[Cycle] = []
        for number, pole in enumerate(chosen):
            report(f"pole at {pole.frequency_hz:.0f} Hz", number, len(chosen))
            curve = trace(model, pole, truncation, effort)
            traces.append(curve)
            refined, sentences = _refined(curve)
            notes += sentences
            found += [_cycle(pole, r, with_stability, radiator) for r in refined if not _known(r, found)]
        report("done", len(chosen), len(chosen))
    return Catalogue(model, poles, tuple(traces), tuple(sorted(found, key=lambda c: c.frequency_hz)), tuple(notes))


def _chosen(poles: Iterable[Pole], tone_hz: float | None, down_to: float) -> list[Pole]:
    """Return the poles to follow, the unstable ones first."""
    near = sorted((p for p in poles if p.growth_rate > down_to), key=lambda p: -p.growth_rate)
    if tone_hz is None or not near:
        return near
    close = [p for p in near if abs(p.frequency_hz / tone_hz - 1) < NEAR_TONE]
    if close:
        return close
    named = [p.frequency_hz for p in near if p.growth_rate > 0] or [p.frequency_hz for p in near]
    words = ", ".join(f"{f:.1f}" for f in sorted(sorted(named, key=lambda f: abs(f - tone_hz))[:3]))
    raise InputError(f"no tone near {tone_hz:g} Hz: the nearest poles that could make one are at {words} Hz")


def _refined(curve: Trace) -> tuple[list[Refined], list[str]]:
    """Return the cycles of a curve as they are, and sentences about those that got lost."""
    place = f"pole at {curve.pole.frequency_hz:.1f} Hz ({curve.pole.growth_rate:.3g} 1/s)"
    if not curve.amplitude.size:
        return [], [f"{place}: not followed, its curve {curve.ended}"]
    endless = not curve.crossings and not curve.lost and curve.sigma[-1] > 0
    notes = [] if curve.complete and not endless else [f"{place}: its curve {curve.ended}"]
    notes += [f"{place}: {words}" for words in curve.lost]
    refined = []
    for crossing in curve.crossings:
        cycle = refine(curve.balance, crossing)
        if isinstance(cycle, Lost):
            notes.append(f"{place}: {cycle.words}")
        else:
            refined.append(cycle)
    return refined, notes


def _known(refined: Refined, found: Iterable[Cycle]) -> bool:
    """Whether a cycle is already there: twin poles reach the same one."""
    return any(
        abs(c.frequency_hz - refined.state.frequency_hz) < SAME_HZ
        and abs(c.amplitude - refined.state.amplitude) < SAME_AMPLITUDE
        for c in found
    )


def _cycle(pole: Pole, refined: Refined, with_stability: bool, radiator: Radiator | None) -> Cycle:
    """Return a cycle with everything that is told of it."""
    balance, state = refined.balance, refined.state
    judged = None
    if with_stability:
        balance, state, judged = stability(balance, state)
    motion = motion_of(balance, state)
    contact = contact_over_a_period(balance.model_of(state), motion)
    residual = float(np.abs(balance.residual(balance.pack(state))).max())
    level = None if radiator is None else radiator.level_dba(motion)
    return Cycle(pole, balance, state, residual, refined.change, motion, contact, level, judged)
