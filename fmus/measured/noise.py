"""How noisy measured functions are and where they are good: receptances in, noise, band and averages out.

The noise is seen in the data alone: what the fourth difference over neighbouring lines leaves is not a smooth
function. A coherence says more, where there is one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from .function import Complex, Real

LARGEST_NOISE = 0.2
"""Standard deviation of a value over the value itself up to which data are good: 1.7 dB, 11 degrees."""

_FOURTH_DIFFERENCE = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / np.sqrt(70.0)
"""Passes white noise with its own standard deviation and leaves nothing of a cubic."""

_WINDOW = 25
"""Lines over which the noise is taken as constant."""


class Averaged(NamedTuple):
    """A function averaged over narrow bands.

    Attributes
    ----------
    frequency_hz : (k,) centres of the lines in each band [Hz]
    values : (k,) their means, complex
    noise : (k,) standard deviation of each mean over its value [-]
    """

    frequency_hz: Real
    values: Complex
    noise: Real


def relative_noise(values: Complex, coherence: Real | None = None) -> Real:
    """Return the standard deviation of each value over its magnitude.

    Parameters
    ----------
    values : (m,) complex
        On lines next to each other.
    coherence : (m,), optional
        From one value to the next the larger of both estimates counts: that of the coherence is of one average.

    Notes
    -----
    The squared magnitude of complex noise is exponentially distributed, its median ln 2 of its mean. By a median over 25
    lines a few resonances narrower than the lines do not count as noise.

    A coherence gamma^2 leaves sqrt((1 - gamma^2)/(2 gamma^2)) in one average of a spectrum.
    """
    size = np.maximum(np.abs(values), np.finfo(float).tiny)
    seen = np.zeros(values.size)
    if values.size >= 5:
        rough = np.abs(sliding_window_view(values, 5) @ _FOURTH_DIFFERENCE) ** 2
        rough = np.concatenate([rough[:1]] * 2 + [rough] + [rough[-1:]] * 2)
        smooth = median_filter(size, min(_WINDOW, values.size) | 1, mode="nearest")
        seen = np.sqrt(median_filter(rough, min(_WINDOW, values.size) | 1, mode="nearest") / np.log(2.0)) / smooth
    if coherence is None:
        return seen
    square = np.clip(coherence, 1e-6, 1.0)
    return np.maximum(seen, np.sqrt((1 - square) / (2 * square)))


def good_band(frequency_hz: Real, noise: Real, largest: float = LARGEST_NOISE) -> NDArray[np.bool_]:
    """Return which lines lie in the widest band, in octaves, without noise above `largest`.

    Notes
    -----
    Gaps of fewer lines than the window of the noise do not end a band: an antiresonance is a dip in the signal.
    """
    good = median_filter((noise <= largest).astype(np.uint8), _WINDOW, mode="nearest").astype(bool)
    inside = np.zeros(good.size, dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    if edges.size:
        spans = edges.reshape(-1, 2)
        widths = [np.log(frequency_hz[end - 1] / frequency_hz[start]) for start, end in spans]
        start, end = spans[int(np.argmax(widths))]
        inside[start:end] = True
    return inside


def averaged(frequency_hz: Real, values: Complex, noise: Real, per_octave: int = 48) -> Averaged:
    """Return means over bands of 1/48 octave, weighted by the noise; lines wider apart stay as they are."""
    band = np.floor(np.log2(frequency_hz / frequency_hz[0]) * per_octave + 1e-9).astype(int)
    weight = 1.0 / np.maximum(noise, 1e-6) ** 2
    starts = np.flatnonzero(np.diff(band, prepend=-1))

    def total(x: NDArray[np.complex128] | Real) -> NDArray[np.complex128]:
        return np.asarray(np.add.reduceat(x, starts), dtype=complex)

    sums = total(weight).real
    return Averaged(
        total(weight * frequency_hz).real / sums, total(weight * values) / sums, 1.0 / np.sqrt(sums)
    )
