"""The tones that many runs ended in: dominant frequencies in, shares with confidence intervals out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from scipy.stats import binomtest

SAME_TONE = 0.01
"""Dominant frequencies that follow each other within this relative distance are one tone."""

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Tone:
    """A tone that some of the runs ended in.

    Attributes
    ----------
    frequency_hz : mean dominant frequency; None: at rest
    count, of : trials that ended here, and all
    low, high : confidence interval of the share (Clopper and Pearson)
    """

    frequency_hz: float | None
    count: int
    of: int
    low: float
    high: float

    @property
    def share(self) -> float:
        """Part of the runs that ended here."""
        return self.count / self.of


def tones(frequencies_hz: Iterable[float | None]) -> list[Tone]:
    """Return the tones among dominant frequencies, the most frequent first; None is a run that came to rest.

    >>> [(t.frequency_hz, t.count) for t in tones([1978.0, 1100.0, 1982.0])]
    [(1980.0, 2), (1100.0, 1)]
    """
    found = sorted(frequencies_hz, key=lambda f: f or 0.0)
    groups: list[list[float | None]] = []
    for f in found:
        last = groups[-1][-1] if groups else None
        if groups and (f == last or (f and last and f / last - 1 < SAME_TONE)):
            groups[-1].append(f)
        else:
            groups.append([f])
    return sorted((_tone(group, len(found)) for group in groups), key=lambda t: -t.count)


def _tone(group: list[float | None], of: int) -> Tone:
    interval = binomtest(len(group), of).proportion_ci(CONFIDENCE, method="exact")
    frequency = None if group[0] is None else float(np.mean([f for f in group if f is not None]))
    return Tone(frequency, len(group), of, float(interval.low), float(interval.high))
