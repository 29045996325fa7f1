"""Where runs end, against the list of cycles: a frequency and a level in, what that motion is in words out."""

from __future__ import annotations

from collections.abc import Iterable

from ..limit_cycles.catalogue import Catalogue, Cycle

SAME_HZ = 0.005
"""Relative distance within which a run's dominant frequency is that of a cycle: windows of a second tell 0.1 Hz."""

SAME_LEVEL = 0.03
"""Relative distance within which its lateral rms is that of the cycle: the step makes it lower by up to 1.2 %."""


def end_words(found: Catalogue, frequency_hz: float, lateral_rms: float) -> str:
    """Return what a run is that ended at a frequency [Hz] with a lateral rms of the wheel [m/s].

    A cycle that lasts must have the same level. One that does not last is what the motion comes from: sidebands that
    have grown beside it make two or more tones at once.
    """
    near = [c for c in found.cycles if abs(frequency_hz / c.frequency_hz - 1) < SAME_HZ]
    lasting = [c for c in near if c.stable and _difference(c, lateral_rms) < SAME_LEVEL]
    if lasting:
        nearest = min(lasting, key=lambda c: _difference(c, lateral_rms))
        return f"the cycle at {nearest.frequency_hz:.2f} Hz, which lasts"
    broken = [c for c in near if c.stable is False]
    if broken:
        nearest = min(broken, key=lambda c: _difference(c, lateral_rms))
        return f"no tone by itself: the cycle at {nearest.frequency_hz:.2f} Hz {nearest.fate}"
    if near:
        off = lateral_rms / near[0].wheel_velocity_rms["lat"] - 1
        nearest_hz = near[0].frequency_hz
        return f"not the cycle at {nearest_hz:.2f} Hz: its level is {off:+.0%} off, not settled or another motion"
    return f"no cycle of the list; {found.nearest_words(frequency_hz)}"


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
