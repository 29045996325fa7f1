"""The sound of a run as a file to listen to: modal velocities in, calibrated pressure and WAV out.

The pressure is the sum of the modal velocities, each passed through a filter without delay whose squared gain is that
of the radiation model, and scaled as a whole so that its level is that of the model, in which modes add by power.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from fractions import Fraction
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft, rfftfreq
from scipy.signal import resample_poly

from fmus.modal.parameters import modal_velocities
from fmus.wheel.wheelset import Wheelset

from ..errors import InputError
from ..signals.spectra import regular, sample_interval_of, total
from .levels import REFERENCE_PRESSURE
from .radiation import Radiation, modal_spectra, power_per_velocity, sound_power
from .wheelset import wheelset_of

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

Real = NDArray[np.float64]

RATE_HZ = 48_000
"""Sampling rate of the sound."""

FADE_S = 0.02
"""Length of the fades at both ends [s]: shorter is heard as a click."""

HEADROOM = 1.05
"""Full scale over the largest pressure."""

_SHORTEST_S = 0.1

_STOP_BAND = 10.0
"""Shape of the resampling filter's window: images of the tones stay 100 dB below them."""


@dataclass(frozen=True)
class Pressure:
    """Sound pressure at the receiver.

    Attributes
    ----------
    samples : (n,) [Pa] at `RATE_HZ`
    level_db : of the second half, not weighted [dB]
    distance : from the wheel to the receiver [m]
    wheelset : whose radiating areas were taken
    """

    samples: Real
    level_db: float
    distance: float
    wheelset: str


def pressure_of(data: xr.Dataset, wheel: str | None = None, radiation: Radiation | None = None) -> Pressure:
    """Return the pressure at the receiver over a whole run.

    Raises
    ------
    InputError
        If the results hold no modal velocities, belong to an unknown wheel, are shorter than 0.1 s, were recorded at
        too low a rate for the wheel's modes, or do not vibrate.
    """
    wheelset, how = wheelset_of(data, wheel), radiation or Radiation()
    data = regular(data)
    names = modal_velocities("wheel", data.data_vars)
    interval = sample_interval_of(data[names[0]])
    _require(data, wheelset, interval)
    sum_of_modes = _filtered_sum(data, names, wheelset, how, interval)
    half = sum_of_modes[sum_of_modes.size // 2 :]
    mean_square = _model_mean_square(data, wheelset, how, interval)
    if not mean_square > 0:
        raise InputError(f"{_name(data)}: the wheel does not vibrate, so there is nothing to hear")
    scaled = sum_of_modes * np.sqrt(mean_square / np.square(half).mean())
    ratio = Fraction(RATE_HZ * interval).limit_denominator(2000)
    samples = resample_poly(scaled, ratio.numerator, ratio.denominator, window=("kaiser", _STOP_BAND))
    return Pressure(
        samples=np.asarray(samples) * _fades(samples.size),
        level_db=float(10 * np.log10(mean_square / REFERENCE_PRESSURE**2)),
        distance=how.distance,
        wheelset=wheelset.title,
    )


def _require(data: xr.Dataset, wheelset: Wheelset, interval: float) -> None:
    """Raise InputError for results from which no sound can be made."""
    duration = data.sizes["time"] * interval
    if duration < _SHORTEST_S:
        raise InputError(f"{_name(data)}: lasts {duration:.4g} s; a sound needs at least {_SHORTEST_S:g} s")
    highest = float(wheelset.modes.omega.max()) / (2 * np.pi)
    if interval * highest > 0.5:
        needed = int(0.5 / (highest * float(data.attrs.get("step_s", interval))))
        raise InputError(
            f"{_name(data)}: recorded at {1 / interval:.0f} Hz, too slow for modes up to {highest:.0f} Hz; "
            f"run again with record-every {max(needed, 1)} or less"
        )


def _name(data: xr.Dataset) -> str:
    return str(data.encoding.get("source", "the results"))


def _model_mean_square(data: xr.Dataset, wheelset: Wheelset, how: Radiation, interval: float) -> float:
    """Return the mean-square pressure of the second half by the radiation model [Pa2]."""
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    spectra = modal_spectra(half, max(2.0, 1.01 / (half.sizes["time"] * interval)))
    return total(sound_power(spectra, wheelset, how)) * how.pressure_per_power


def _filtered_sum(data: xr.Dataset, names: list[str], wheelset: Wheelset, how: Radiation, interval: float) -> Real:
    """Return the sum of the modal velocities, each filtered by the square root of what it radiates [Pa]."""
    count = data.sizes["time"]
    length = next_fast_len(count + round(0.1 / interval), real=True)  # room for the filters' tails
    frequency = rfftfreq(length, interval)
    spectrum = np.zeros(frequency.size, complex)
    for i, name in enumerate(names):
        gain = np.sqrt(power_per_velocity(frequency, wheelset, i, how))
        spectrum += gain * rfft(data[name].to_numpy().astype(float), length)
    pressure: Real = irfft(spectrum, length)[:count] * np.sqrt(how.pressure_per_power)
    return pressure


def _fades(count: int) -> Real:
    """Return factors that rise from zero over the first `FADE_S` and fall to zero over the last."""
    length = round(FADE_S * RATE_HZ)
    rise = np.sin(0.5 * np.pi * np.arange(length) / length) ** 2
    return np.concatenate([rise, np.ones(count - 2 * length), rise[::-1]])


@dataclass(frozen=True)
class Calibration:
    """What turns the samples of a sound file into pressure, and what they are.

    Attributes
    ----------
    full_scale_pa : pressure of a sample of 1.0 [Pa]
    level_db : of the second half, not weighted [dB re 20 uPa]
    """

    full_scale_pa: float
    level_db: float
    rate_hz: int
    duration_s: float
    fade_s: float
    distance_m: float
    wheelset: str
    source: str


def write_wav(pressure: Pressure, path: Path, source: str) -> Calibration:
    """Write a pressure as WAV (24 bit, mono), its calibration into the header's INFO chunk and into a JSON file beside.

    Parameters
    ----------
    source : what the sound was made from
    """
    import soundfile  # noqa: PLC0415 - loads a library

    full_scale = HEADROOM * float(np.abs(pressure.samples).max())
    calibration = Calibration(
        full_scale_pa=full_scale,
        level_db=pressure.level_db,
        rate_hz=RATE_HZ,
        duration_s=pressure.samples.size / RATE_HZ,
        fade_s=FADE_S,
        distance_m=pressure.distance,
        wheelset=pressure.wheelset,
        source=source,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    with soundfile.SoundFile(path, "w", RATE_HZ, 1, "PCM_24") as file:
        file.title = f"Sound pressure at {pressure.distance:g} m, {source}"
        file.software = "curvesqueal"
        file.comment = f"full scale = {full_scale:.6g} Pa; level = {pressure.level_db:.2f} dB re 20 uPa (second half)"
        file.write(pressure.samples / full_scale)
    path.with_suffix(".json").write_text(json.dumps(asdict(calibration), indent=1) + "\n", encoding="utf-8")
    return calibration


def compressed(pressure: Pressure, seconds: float) -> bytes:
    """Return the first `seconds` of a pressure as MP3, as loud as it goes: to listen to, not to measure."""
    import soundfile  # noqa: PLC0415

    samples = pressure.samples[: round(seconds * RATE_HZ)]
    buffer = BytesIO()
    soundfile.write(buffer, samples / (HEADROOM * np.abs(samples).max()), RATE_HZ, format="MP3")
    return buffer.getvalue()
