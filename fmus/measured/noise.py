"""How noisy measured functions are and where they are good: receptances in, noise, band and averages out.

The noise is seen in the data alone: what the fourth difference over neighbouring lines leaves is no smooth function. A
coherence, where there is one, weighs lines against each other.
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

LEAST_COHERENCE = 0.5
"""Coherence down to which data are good: half of the motion is due to the force."""

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


def relative_noise(values: Complex) -> Real:
    """Return the standard deviation of each value over its magnitude.

    Parameters
    ----------
    values : (m,) complex
        On lines next to each other.

    Notes
    -----
    The squared magnitude of complex noise is exponentially distributed, its median ln 2 of its mean. By a median over
    25 lines a few resonances narrower than the lines do not count as noise.
    """
    if values.size < 5:
        return np.zeros(values.size)
    size = np.maximum(np.abs(values), np.finfo(float).tiny)
    window = min(_WINDOW, values.size) | 1
    rough = np.abs(sliding_window_view(values, 5) @ _FOURTH_DIFFERENCE) ** 2
    rough = np.concatenate([rough[:1]] * 2 + [rough] + [rough[-1:]] * 2)
    squared = median_filter(rough, window, mode="nearest") / np.log(2.0)
    return np.asarray(np.sqrt(squared) / median_filter(size, window, mode="nearest"))


def good_band(frequency_hz: Real, noise: Real, coherence: Real | None = None) -> NDArray[np.bool_]:
    """Return which lines lie in the widest band, in octaves, with noise and coherence within the limits.

    Notes
    -----
    Gaps of fewer lines than the window of the noise do not end a band: an antiresonance is a dip in the signal.
    """
    fine = noise <= LARGEST_NOISE if coherence is None else (noise <= LARGEST_NOISE) & (coherence >= LEAST_COHERENCE)
    good = median_filter(fine.astype(np.uint8), _WINDOW, mode="nearest").astype(bool)
    inside = np.zeros(good.size, dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    if edges.size:
        spans = edges.reshape(-1, 2)
        widths = [np.log(frequency_hz[end - 1] / frequency_hz[start]) for start, end in spans]
        start, end = spans[int(np.argmax(widths))]
        inside[start:end] = True
    return inside


def averaged(
    frequency_hz: Real, values: Complex, noise: Real, coherence: Real | None = None, per_octave: int = 48
) -> Averaged:
    """Return means over bands of 1/48 octave; lines wider apart stay as they are.

    Notes
    -----
    Lines weigh by one over the square of their noise and, with a coherence gamma^2, by gamma^2/(1 - gamma^2), to which
    the variance of a frequency response is inverse.
    """
    band = np.floor(np.log2(frequency_hz / frequency_hz[0]) * per_octave + 1e-9).astype(int)
    spread = np.maximum(noise, 1e-6)
    weight = spread**-2.0
    if coherence is not None:
        square = np.clip(coherence, 1e-3, 0.999)
        weight = weight * square / (1 - square)
    starts = np.flatnonzero(np.diff(band, prepend=-1))
    sums = np.add.reduceat(weight, starts)
    return Averaged(
        np.add.reduceat(weight * frequency_hz, starts) / sums,
        np.asarray(np.add.reduceat(weight * values, starts) / sums, dtype=complex),
        np.sqrt(np.add.reduceat((weight * spread) ** 2, starts)) / sums,
    )
