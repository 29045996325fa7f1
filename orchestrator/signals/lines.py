"""Whether a vibration is made of lines: tones and sums of tones, or irregular motion. A signal in, a share out.

A tone with its harmonics, and several tones at once, have discrete spectra. Irregular motion has none, but still a
strongest line, which is no tone.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

LINES = 8
"""Lines that are counted."""

REGULAR = 0.9
"""Share of the mean square in the strongest `LINES` lines from which on a motion is one of lines.

Tones and pairs of tones of the cases have 0.997 and more, the irregular motion of Case 4 0.74 and less in 0.25 s, 0.42
in 1 s.
"""

WINDOW = 1.0
SHORTEST = 0.25
"""Time that is looked at, the last of the signal, and the shortest from which anything is said [s]."""

_NEIGHBOURS = 2  # on either side: the main lobe of a Hann window
_SETTLED = 0.5


def line_share(signal: ArrayLike, interval: float) -> float | None:
    """Return the share of the mean square that the strongest lines hold; None if nothing can be said.

    That is so for less than `SHORTEST`, at rest, and while the level changes by more than a factor of two.

    Parameters
    ----------
    signal : (n,) array_like; the last `WINDOW` seconds are taken
    interval : time between samples [s]

    Examples
    --------
    Two tones are lines, noise is not:

    >>> t = np.arange(10000) / 10000
    >>> round(line_share(np.sin(2 * np.pi * 272 * t) + np.sin(2 * np.pi * 147.3 * t), 1e-4), 3)
    1.0
    >>> line_share(np.random.default_rng(0).standard_normal(10000), 1e-4) < 0.1
    True
    """
    x = np.asarray(signal, dtype=float)[-max(1, round(WINDOW / interval)) :]
    x = x - x.mean()
    if x.size * interval < SHORTEST * (1 - 1e-9) or not x.any():
        return None
    quarters = [float(np.square(part).mean()) for part in np.array_split(x, 4)]
    if min(quarters) < _SETTLED**2 * max(quarters):
        return None
    power = np.abs(np.fft.rfft(x * np.hanning(x.size + 1)[:-1])) ** 2
    whole, held = float(power.sum()), 0.0
    for _ in range(LINES):
        k = int(power.argmax())
        line = slice(max(k - _NEIGHBOURS, 0), k + _NEIGHBOURS + 1)
        held += float(power[line].sum())
        power[line] = 0.0
    return held / whole


def is_irregular(signal: ArrayLike, interval: float) -> bool | None:
    """Return whether a vibration has no line spectrum, so that its strongest line is no tone; None as `line_share`."""
    share = line_share(signal, interval)
    return None if share is None else share < REGULAR
