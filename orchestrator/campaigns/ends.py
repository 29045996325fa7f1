"""Where runs end, against the list of cycles: a frequency and a level in, what that motion is in words out."""

from __future__ import annotations

from collections.abc import Iterable

from ..limit_cycles.catalogue import Catalogue, Cycle
from ..limit_cycles.tori.search import BreakUp, break_up
from ..limit_cycles.tori.torus import Torus

NOT_LISTED = "not on the list"
NOT_SETTLED = "not settled"
IRREGULAR = "irregular"
AT_REST = "at rest"
"""Ends of runs that are no cycle and no torus."""

SAME_HZ = 0.005
"""Relative distance within which a run's dominant frequency is that of a cycle: windows of a second tell 0.1 Hz."""

SAME_LEVEL = 0.03
"""Relative distance within which its lateral rms is that of the cycle: the step makes it lower by up to 1.2 %."""


class Ends:
    """The list of cycles of a system, and of what those break up into that a run came near to.

    Attributes
    ----------
    found : cycles with their stability
    """

    def __init__(self, found: Catalogue) -> None:
        """Take a list of cycles."""
        self.found = found
        self._tori: dict[int, BreakUp] = {}

    def words(self, frequency_hz: float, lateral_rms: float) -> str:
        """Return what a run is that ended at a frequency [Hz] with a lateral rms of the wheel [m/s].

        A cycle that lasts must have the same level, and so must two tones at once, which have their strongest line at
        the frequency.
        """
        near = self._near(frequency_hz)
        lasting = _nearest([c for c in near if c.stable], lateral_rms)
        if lasting is not None and _difference(lasting, lateral_rms) < SAME_LEVEL:
            return f"the cycle at {lasting.frequency_hz:.2f} Hz, which lasts"
        broken = _nearest([c for c in near if c.stable is False], lateral_rms)
        if broken is not None:
            torus = self._torus(broken, frequency_hz, lateral_rms)
            fate = self._broken_up(broken).words
            is_it = "" if torus is None else f"two tones at once, {_pair(torus)}: "
            return f"no tone by itself: {is_it}the cycle at {broken.frequency_hz:.2f} Hz {fate}"
        if near:
            off = lateral_rms / near[0].wheel_velocity_rms["lat"] - 1
            nearest_hz = near[0].frequency_hz
            return f"not the cycle at {nearest_hz:.2f} Hz: its level is {off:+.0%} off, not settled or another motion"
        return f"no cycle of the list; {self.found.nearest_words(frequency_hz)}"

    def label(self, frequency_hz: float, lateral_rms: float) -> str:
        """Return the same in a word or two, for a table."""
        near = self._near(frequency_hz)
        lasting = _nearest([c for c in near if c.stable], lateral_rms)
        if lasting is not None and _difference(lasting, lateral_rms) < SAME_LEVEL:
            return f"cycle {lasting.frequency_hz:.2f} Hz"
        broken = _nearest([c for c in near if c.stable is False], lateral_rms)
        torus = None if broken is None else self._torus(broken, frequency_hz, lateral_rms)
        return NOT_LISTED if torus is None else f"tones {_pair(torus)}"

    def _near(self, frequency_hz: float) -> list[Cycle]:
        return [c for c in self.found.cycles if abs(frequency_hz / c.frequency_hz - 1) < SAME_HZ]

    def _broken_up(self, cycle: Cycle) -> BreakUp:
        """Return what a cycle that does not last breaks up into, found once."""
        if id(cycle) not in self._tori:
            sidebands = cycle.stability is not None and cycle.stability.kind == "sidebands"
            self._tori[id(cycle)] = break_up(cycle) if sidebands else BreakUp(cycle, None, ())
        return self._tori[id(cycle)]

    def _torus(self, cycle: Cycle, frequency_hz: float, lateral_rms: float) -> Torus | None:
        """Return the two tones from a cycle if a run ended there."""
        torus = self._broken_up(cycle).torus
        if torus is None or abs(frequency_hz / torus.lines[0].frequency_hz - 1) > SAME_HZ:
            return None
        return torus if abs(lateral_rms / torus.wheel_velocity_rms["lat"] - 1) < SAME_LEVEL else None


def _nearest(cycles: list[Cycle], lateral_rms: float) -> Cycle | None:
    """Return the cycle with the level that is nearest."""
    return min(cycles, key=lambda c: _difference(c, lateral_rms), default=None)


def _pair(torus: Torus) -> str:
    """Return both frequencies of a torus."""
    first, second = torus.frequencies_hz
    return f"{first:.2f} + {second:.2f} Hz"


def missing_words(found: Catalogue, frequencies_hz: Iterable[float]) -> str | None:
    """Return the cycles that last and no run ended in, with what tells of their basins; None if there are none."""
    ends = list(frequencies_hz)
    missing = [c for c in found.cycles if c.stable and all(abs(f / c.frequency_hz - 1) > SAME_HZ for f in ends)]
    if not missing:
        return None
    return "last, too, but no run ended there: " + ", ".join(map(_hint, missing))


def _hint(cycle: Cycle) -> str:
    """Return a cycle with the growth from rest that leads to it."""
    rate = cycle.pole.growth_rate
    how = f"grows from rest by {rate:.3g} 1/s" if rate > 0 else "needs a push"
    return f"{cycle.frequency_hz:.1f} Hz ({how})"


def _difference(cycle: Cycle, lateral_rms: float) -> float:
    return abs(lateral_rms / cycle.wheel_velocity_rms["lat"] - 1)
