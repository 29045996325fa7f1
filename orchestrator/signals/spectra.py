"""Spectra and levels of any signal: labelled arrays with units in and out. No files, no knowledge of wheels.

A narrow-band spectrum is the mean square in each line, so that its sum over the lines is the mean square of the signal.
Third-octave bands are those of IEC 61260-1 (base 10), the A-weighting is that of IEC 61672-1.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeVar, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..results.samples import Samples

Real = NDArray[np.float64]

NOMINAL_HZ = (
    10.0, 12.5, 16.0, 20.0, 25.0, 31.5, 40.0, 50.0, 63.0, 80.0, 100.0, 125.0, 160.0, 200.0, 250.0, 315.0, 400.0,
    500.0, 630.0, 800.0, 1000.0, 1250.0, 1600.0, 2000.0, 2500.0, 3150.0, 4000.0, 5000.0, 6300.0, 8000.0, 10000.0,
    12500.0, 16000.0, 20000.0,
)  # fmt: skip
"""Nominal midband frequencies of the one-third-octave bands [Hz]."""

_FIRST_BAND = -20
"""Number of the 10 Hz band, counted from the one at 1 kHz."""

_OCTAVE = 10**0.3
"""Ratio of one octave in IEC 61260-1."""

_POLES_HZ = (20.598997, 107.65265, 737.86223, 12194.217)
"""Corner frequencies of the A-weighting, IEC 61672-1 annex E: the first and last are double poles."""

_LINES_PER_BAND = 3
"""A band narrower than this many lines says nothing of its own."""


Rows = TypeVar("Rows", bound="xr.Dataset | xr.DataArray | Samples")


def regular(data: Rows) -> Rows:
    """Return the rows that are equally far apart: all but a last one that is there only as the end of the run."""
    time = np.asarray(data["time"]) if "time" in data.sizes else np.zeros(0)
    if time.size > 2 and time[-1] - time[-2] < (1 - 1e-3) * (time[1] - time[0]):
        return cast("Rows", data.isel(time=slice(None, -1)))
    return data


def sample_interval_of(signal: xr.DataArray) -> float:
    """Return the time between samples [s].

    Raises
    ------
    InputError
        If the signal has no time axis, fewer than three samples, or samples at unequal distances.
    """
    name = signal.name or "the signal"
    if signal.dims != ("time",):
        raise InputError(f"{name}: must have one dimension called time, has {signal.dims}")
    if signal.sizes["time"] < 3:
        raise InputError(f"{name}: has {signal.sizes['time']} samples; a spectrum needs at least 3")
    steps = np.diff(np.asarray(signal["time"], dtype=float))
    mean = float(steps.mean())
    if not (mean > 0 and np.allclose(steps, mean, rtol=1e-3, atol=0)):
        raise InputError(
            f"{name}: its samples are {steps.min():g} to {steps.max():g} s apart; a spectrum needs equal steps"
        )
    return mean


def narrow_band(signal: xr.DataArray, resolution_hz: float = 1.0) -> xr.DataArray:
    """Return the narrow-band spectrum of a signal: mean square by line (Hann window, half overlapping, averaged).

    Parameters
    ----------
    signal : (time,) with unit `u`, or (..., time) for several
    resolution_hz : distance of the lines [Hz]; the signal must last at least 1/resolution

    Returns
    -------
    (frequency,) in u^2, or (..., frequency); the sum over all lines is the mean square of the signal about its mean

    Raises
    ------
    InputError
        If the signal is too short for the resolution; the message says what is needed.

    Examples
    --------
    A sine of amplitude 3 has a mean square of 4.5:

    >>> import xarray as xr
    >>> t = np.arange(4000) / 2000
    >>> v = xr.DataArray(3 * np.sin(2 * np.pi * 50 * t), coords={"time": t}, name="v", attrs={"units": "m/s"})
    >>> lines = narrow_band(v)
    >>> round(float(lines.sum()), 6), lines.attrs["units"], float(lines.idxmax())
    (4.5, '(m/s)^2', 50.0)
    """
    import xarray as xr  # noqa: PLC0415
    from scipy.signal import welch  # noqa: PLC0415

    signal = regular(signal)
    interval = sample_interval_of(signal.isel({name: 0 for name in signal.dims if name != "time"}))
    count = _samples(signal, interval, resolution_hz)
    signal = signal.transpose(..., "time")
    frequency, density = welch(np.asarray(signal, dtype=float), 1 / interval, window="hann", nperseg=count)
    spacing = 1 / (count * interval)
    return xr.DataArray(
        density * spacing,
        dims=(*signal.dims[:-1], "frequency"),
        coords={"frequency": ("frequency", frequency, {"units": "Hz"})},
        name=signal.name,
        attrs={
            "units": f"({signal.attrs.get('units', '1')})^2",
            "long_name": f"mean square by line of {signal.attrs.get('long_name', signal.name or 'the signal')}",
            "resolution_hz": spacing,
        },
    )


def _samples(signal: xr.DataArray, interval: float, resolution_hz: float) -> int:
    """Return the number of samples that a resolution takes."""
    if not resolution_hz > 0:
        raise InputError(f"resolution = {resolution_hz:g} Hz: must be > 0")
    count = round(1 / (resolution_hz * interval))
    duration = signal.sizes["time"] * interval
    if count > signal.sizes["time"]:
        raise InputError(
            f"{signal.name or 'the signal'}: lasts {duration:.4g} s, too short for lines {resolution_hz:g} Hz apart; "
            f"that needs {1 / resolution_hz:.4g} s, or ask for {math.ceil(1e3 / duration) / 1e3:g} Hz or more"
        )
    if count < 8:
        raise InputError(
            f"resolution = {resolution_hz:g} Hz: too coarse for samples {interval:g} s apart; "
            f"must be at most {1 / (8 * interval):.4g} Hz"
        )
    return count


def level(power: xr.DataArray, reference: float) -> xr.DataArray:
    """Return 10 lg(power / reference^2) [dB]; minus infinity where the power is zero.

    Parameters
    ----------
    power : mean squares in the unit of the reference, squared
    reference : such as 2e-5 for a pressure in Pa
    """
    import xarray as xr  # noqa: PLC0415

    with np.errstate(divide="ignore"):
        result: xr.DataArray = xr.zeros_like(power, dtype=float) + 10 * np.log10(np.asarray(power) / reference**2)
    return result.assign_attrs(units="dB", long_name=f"level, dB re {reference:g}", reference=reference)


def total(power: xr.DataArray) -> float:
    """Return the sum of a spectrum: the mean square of its signal."""
    return float(power.sum())


def a_weighting(frequency_hz: ArrayLike) -> Real:
    """Return the A-weighting [dB] of IEC 61672-1 at any frequency.

    >>> a_weighting([100, 1000, 10000]).round(1).tolist()
    [-19.1, 0.0, -2.5]
    """
    squared = np.square(np.asarray(frequency_hz, dtype=float))
    with np.errstate(divide="ignore"):
        weighting: Real = 20 * np.log10(_a_response(squared) / _a_response(np.array(1e6)))
    return weighting


def _a_response(squared: Real) -> Real:
    """Return the response of the A-weighting before it is normalised at 1 kHz."""
    f1, f2, f3, f4 = (pole * pole for pole in _POLES_HZ)
    response: Real = f4 * squared**2 / ((squared + f1) * np.sqrt((squared + f2) * (squared + f3)) * (squared + f4))
    return response


def a_weighted(power: xr.DataArray) -> xr.DataArray:
    """Return a narrow-band spectrum with the A-weighting on every line."""
    return (power * 10 ** (a_weighting(power["frequency"]) / 10)).assign_attrs(power.attrs)


def band_edges() -> tuple[Real, Real, Real]:
    """Return exact midband, lower and upper edge frequencies of the bands of `NOMINAL_HZ` [Hz].

    >>> middle, low, high = band_edges()
    >>> middle[20].item(), round(low[20].item(), 2), round(high[20].item(), 2)
    (1000.0, 891.25, 1122.02)
    """
    number = _FIRST_BAND + np.arange(len(NOMINAL_HZ))
    middle: Real = 1000 * _OCTAVE ** (number / 3)
    half = _OCTAVE ** (1 / 6)
    return middle, middle / half, middle * half


def third_octaves(power: xr.DataArray, lowest_hz: float = 50.0) -> xr.DataArray:
    """Return the mean square in one-third-octave bands of a narrow-band spectrum.

    A line is as wide as the distance of the lines and is shared among the bands that it lies in, so that nothing is
    lost or counted twice between the lowest and the highest band.

    Parameters
    ----------
    power : (frequency,) with lines at equal distances
    lowest_hz : nominal midband frequency of the lowest band [Hz]

    Returns
    -------
    (band,) with the nominal midband frequencies [Hz]; bands above the last line are left out

    Raises
    ------
    InputError
        If the lines are too far apart for the lowest band.
    """
    import xarray as xr  # noqa: PLC0415

    frequency = np.asarray(power["frequency"], dtype=float)
    spacing = float(frequency[1] - frequency[0])
    _, low, high = band_edges()
    used = (np.array(NOMINAL_HZ) >= lowest_hz * 0.99) & (high <= frequency[-1] + spacing / 2)
    width = float((high - low)[used].min(initial=np.inf))
    if width < _LINES_PER_BAND * spacing:
        raise InputError(
            f"lowest third-octave band {lowest_hz:g} Hz: is {width:.3g} Hz wide, the lines are {spacing:.3g} Hz apart; "
            f"they must be at most {width / _LINES_PER_BAND:.3g} Hz apart (a signal of {_LINES_PER_BAND / width:.3g} s)"
        )
    below = np.concatenate([[0.0], np.cumsum(np.asarray(power, dtype=float))])
    edges = np.append(frequency - spacing / 2, frequency[-1] + spacing / 2)
    sums = np.interp(high[used], edges, below) - np.interp(low[used], edges, below)
    return xr.DataArray(
        sums,
        coords={
            "band": ("band", np.array(NOMINAL_HZ)[used], {"units": "Hz", "long_name": "nominal midband frequency"})
        },
        name=power.name,
        attrs={**power.attrs, "long_name": "mean square by one-third-octave band"},
    )
