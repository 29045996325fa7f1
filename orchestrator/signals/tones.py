"""The tones that many runs ended in: dominant frequencies in, shares with confidence intervals out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.stats import binomtest

SAME_TONE = 0.01
"""Dominant frequencies that follow each other within this relative distance are one tone."""

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Tone:
    """A tone that some of the runs ended in.

    Attributes
    ----------
    frequency_hz : mean dominant frequency; None: at rest, or irregular
    count, of : trials that ended here, and all
    low, high : confidence interval of the share (Clopper and Pearson)
    irregular : whether these runs ended in motion without a tone
    """

    frequency_hz: float | None
    count: int
    of: int
    low: float
    high: float
    irregular: bool = False

    @property
    def words(self) -> str:
        """The tone in words."""
        if self.frequency_hz is None:
            return "irregular" if self.irregular else "at rest"
        return f"{self.frequency_hz:.1f} Hz"

    @property
    def share(self) -> float:
        """Part of the runs that ended here."""
        return self.count / self.of

    def as_data(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {**asdict(self), "share": self.share, "words": self.words}


def tones(frequencies_hz: Iterable[float | None], irregular: int = 0) -> list[Tone]:
    """Return the tones among dominant frequencies, the most frequent first; None is a run that came to rest.

    Parameters
    ----------
    irregular : number of further runs that ended in motion without a line spectrum

    Examples
    --------
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
    of = len(found) + irregular
    ended = [_tone(_mean(group), len(group), of) for group in groups]
    if irregular:
        ended.append(_tone(None, irregular, of, irregular=True))
    return sorted(ended, key=lambda t: -t.count)


def tones_of_runs(frequency_hz: ArrayLike, irregular: ArrayLike) -> list[Tone]:
    """Return the tones that runs ended in, as a campaign stores them.

    Parameters
    ----------
    frequency_hz : (n,) array_like, nan at rest
    irregular : (n,) array_like, 1 for irregular motion, whose strongest line is no tone; 0 or nan otherwise
    """
    found, none = np.asarray(frequency_hz, dtype=float), np.asarray(irregular, dtype=float) == 1
    return tones((None if np.isnan(f) else float(f) for f in found[~none]), int(none.sum()))


def _mean(group: list[float | None]) -> float | None:
    return None if group[0] is None else float(np.mean([f for f in group if f is not None]))


def _tone(frequency: float | None, count: int, of: int, *, irregular: bool = False) -> Tone:
    interval = binomtest(count, of).proportion_ci(CONFIDENCE, method="exact")
    return Tone(frequency, count, of, float(interval.low), float(interval.high), irregular)
