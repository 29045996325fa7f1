"""What a run says: dominant frequency, levels, growth. Arrays or a results dataset in, numbers out. No files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fmus.interface import DIRECTIONS

from .axes import NORMAL, PLANE, lateral_and_normal
from .spectra import regular

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..results.samples import Samples

Real = NDArray[np.float64]

GROWTH_WINDOW = 0.01
"""Length of the windows in which the growth of a level is measured [s]."""


@dataclass(frozen=True)
class Summary:
    """The numbers of a run.

    Attributes
    ----------
    dominant_frequency_hz : of the wheel's lateral velocity in the second half of the run; None if it is at rest
    growth_rate : of the wheel's lateral velocity while it grows [1/s]; None if it does not
    wheel_velocity_rms, rail_velocity_rms : by direction, second half of the run [m/s, rad/s]
    wheel_contact_rms, rail_contact_rms : lateral in the contact plane and along the contact normal (plane, normal), the
        same [m/s]; empty where the contact angle is not known
    contact_lost : part of the second half without normal force [-]; None without a contact
    energy_dissipated : by the creep forces in the whole run, the steady sliding included [J]; None without a contact
    """

    dominant_frequency_hz: float | None
    growth_rate: float | None
    wheel_velocity_rms: dict[str, float]
    rail_velocity_rms: dict[str, float]
    wheel_contact_rms: dict[str, float]
    rail_contact_rms: dict[str, float]
    contact_lost: float | None
    energy_dissipated: float | None


def spectrum(signal: ArrayLike, interval: float) -> tuple[Real, Real]:
    """Return frequencies [Hz] and the one-sided amplitude spectrum of a signal (Hann window).

    Parameters
    ----------
    signal : (n,) array_like
    interval : time between samples [s]

    Examples
    --------
    A sine in a bin has its amplitude:

    >>> t = np.arange(1000) / 1000
    >>> f, a = spectrum(3 * np.sin(2 * np.pi * 50 * t), 1 / 1000)
    >>> float(f[a.argmax()]), round(float(a.max()), 6)
    (50.0, 3.0)
    """
    x = np.asarray(signal, dtype=float)
    window = np.hanning(x.size + 1)[:-1]
    amplitude = 2 * np.abs(np.fft.rfft((x - x.mean()) * window)) / window.sum()
    return np.asarray(np.fft.rfftfreq(x.size, interval)), np.asarray(amplitude)


def dominant_frequency(signal: ArrayLike, interval: float) -> float | None:
    """Return the frequency [Hz] of the largest line of a signal, interpolated between bins; None if there is none."""
    frequency, amplitude = spectrum(signal, interval)
    k = int(amplitude.argmax())
    if amplitude[k] == 0.0 or amplitude.size < 3:
        return None
    if not 0 < k < amplitude.size - 1:
        return float(frequency[k])
    # the lines of a Hann-windowed sine follow a known shape: ratio of the two largest gives the position between them
    side = 1 if amplitude[k + 1] > amplitude[k - 1] else -1
    ratio = amplitude[k + side] / amplitude[k]
    return float(frequency[k] + side * (2 * ratio - 1) / (1 + ratio) * frequency[1])


def growth_rate(signal: ArrayLike, interval: float) -> float | None:
    """Return the exponential growth rate [1/s] of a signal's level before it saturates; None if it does not grow.

    The level is the rms in windows of 10 ms. The fit runs from the last minimum before saturation, or three times that
    level, to a fifth of the largest level.
    """
    x = np.asarray(signal, dtype=float)
    length = max(1, round(GROWTH_WINDOW / interval))
    count = x.size // length
    if count < 5:
        return None
    level = np.sqrt((x[: count * length].reshape(count, length) ** 2).mean(axis=1))
    end = int(np.argmax(level > 0.2 * level.max()))
    if end < 5:
        return None
    begin = int(level[:end].argmin())
    grown = np.flatnonzero(level[begin:end] > 3 * level[begin])
    begin += int(grown[0]) if grown.size and end - begin - grown[0] >= 5 else 0
    if end - begin < 5 or level[begin] <= 0:
        return None
    time = np.arange(begin, end) * length * interval
    rate = float(np.polyfit(time, np.log(level[begin:end]), 1)[0])
    return rate if rate > 0 else None


def summarise(data: xr.Dataset | Samples) -> Summary:
    """Return the numbers of a run of the wheel/rail system."""
    whole, data = data, regular(data)
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    interval = sample_interval(data)
    lateral = "wheel.v_lat"
    frequency = growth = None
    if lateral in data and half.sizes["time"] > 2:
        frequency = dominant_frequency(half[lateral], interval)
        growth = growth_rate(data[lateral], interval)
    lost = dissipated = None
    if "contact.normal_force" in half:
        lost = float((np.asarray(half["contact.normal_force"]) <= 0).mean())
    if "contact.power_dissipated" in data:
        power, time = (np.asarray(whole[name], dtype=float) for name in ("contact.power_dissipated", "time"))
        dissipated = float(power[1:] @ np.diff(time))
    track = (velocity_rms(half, "wheel"), velocity_rms(half, "rail"))
    return Summary(frequency, growth, *track, contact_rms(half, "wheel"), contact_rms(half, "rail"), lost, dissipated)


def velocity_rms(data: xr.Dataset | Samples, component: str) -> dict[str, float]:
    """Return the rms velocity of a structure by direction."""
    return {
        d: float(np.sqrt(np.mean(np.square(np.asarray(data[f"{component}.v_{d}"], dtype=float)))))
        for d in DIRECTIONS
        if f"{component}.v_{d}" in data
    }


def contact_rms(data: xr.Dataset | Samples, component: str) -> dict[str, float]:
    """Return the rms velocity of a structure in the contact plane and along the normal; empty where not known."""
    motion = lateral_and_normal(data, component)
    return {d: float(np.sqrt(np.mean(np.square(motion[d])))) for d in (PLANE, NORMAL) if d in motion}


def sample_interval(data: xr.Dataset | Samples) -> float:
    """Return the time between rows, decimation times step as the file tells them [s]."""
    return float(data.attrs["step_s"]) * int(data.attrs["record_every"])
