"""What a squealing run does: growth against the poles, limit cycle, harmonics, stick. Data in, facts out; no files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..stability.poles import Poles
from .axes import lateral_and_normal
from .lines import is_irregular
from .spectra import regular
from .summary import dominant_frequency, sample_interval, spectrum

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..results.samples import Samples

Real = NDArray[np.float64]

STEADY = 0.05
"""A vibration is steady if its levels in the quarters of the second half differ by less than this part: half a
decibel, which is not heard."""

SQUEAL_VELOCITY = 1e-3
"""Lateral velocity of the wheel, rms, below which a run does not squeal [m/s]: half a per cent of the sliding velocity
of the cases. A limit cycle reaches the sliding velocity; what a stable system has left of its start is far below."""

LINEAR_VELOCITY = 0.02
"""Lateral velocity up to which growth counts as linear [m/s]: a tenth of the sliding velocity."""

STICK = 0.95
"""A contact sticks, at least in part, while the creep force is below this part of the friction limit; in full slip
it is the limit."""

HARMONICS = 6
"""Multiples of a tone that are told: those of 1100 Hz up to the end of the band of the wheel's data."""

_WINDOW_S = 0.08
_SHORTEST_WINDOW_S = 0.02
"""Longest and shortest window by which growth is told from that of another tone [s]: 25 and 100 Hz apart, two lines."""

_SETTLED_S = 0.01
"""Time after which what the starting pulse forced has gone [s]: a hundred times its length."""


@dataclass(frozen=True)
class Growth:
    """Growth of one tone while the vibration is small, against the pole of the linear system.

    Attributes
    ----------
    frequency_hz, pole : of the pole [Hz, 1/s]
    seen : growth rate of the wheel's lateral velocity there [1/s]
    """

    frequency_hz: float
    pole: float
    seen: float


@dataclass(frozen=True)
class Harmonic:
    """Velocity amplitudes at a multiple of the dominant frequency [m/s].

    Attributes
    ----------
    number : 1 is the dominant tone
    wheel, rail : by direction: lat and ver, and plane and normal where the contact angle is known
    """

    number: int
    frequency_hz: float
    wheel: dict[str, float]
    rail: dict[str, float]


@dataclass(frozen=True)
class LimitCycle:
    """The second half of a run.

    Attributes
    ----------
    frequency_hz : dominant frequency of the wheel's lateral velocity; None at rest
    lateral_rms : of the wheel [m/s]
    unsteadiness : largest relative difference of the rms in its two halves from the whole
    rail_to_wheel : rms ratio by direction: lat and ver, and in contact axes plane and normal; absent where the wheel is
        at rest or there is no rail
    second_tone_db : level of the strongest line that is no harmonic, relative to the dominant tone [dB]
    harmonics : the dominant tone and its multiples
    stick, contact_lost : parts of the time [-]; None without a contact
    normal_force, friction_force : smallest and largest [N]; None without a contact
    irregular : whether the motion has no line spectrum, so that its dominant frequency is no tone; None if not known
    """

    frequency_hz: float | None
    lateral_rms: float
    unsteadiness: float
    rail_to_wheel: dict[str, float]
    second_tone_db: float
    harmonics: tuple[Harmonic, ...]
    stick: float | None
    contact_lost: float | None
    normal_force: tuple[float, float] | None
    friction_force: tuple[float, float] | None
    irregular: bool | None

    @property
    def squeals(self) -> bool:
        """Whether there is a vibration to speak of."""
        return self.lateral_rms > SQUEAL_VELOCITY

    @property
    def rail_above_wheel_hz(self) -> list[float]:
        """Harmonics at which the rail moves laterally more than the wheel [Hz]."""
        return [h.frequency_hz for h in self.harmonics if h.rail.get("lat", 0.0) > h.wheel.get("lat", 0.0)]

    @property
    def steady(self) -> bool:
        """Whether the level has stopped to change."""
        return self.squeals and self.unsteadiness < STEADY


def limit_cycle(data: xr.Dataset | Samples) -> LimitCycle:
    """Return what the second half of a run does.

    Parameters
    ----------
    data : results with at least wheel.v_lat
    """
    data = regular(data)
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    interval = sample_interval(data)
    lateral = _values(half, "wheel.v_lat")
    rms = _rms(lateral)
    frequency = dominant_frequency(lateral, interval)
    quarters = [_rms(part) for part in np.array_split(lateral, 2)]
    normal, friction, stick = _contact(half)
    return LimitCycle(
        frequency_hz=frequency,
        lateral_rms=rms,
        unsteadiness=max(abs(q / rms - 1) for q in quarters) if rms > 0 else 0.0,
        rail_to_wheel=_ratios(half),
        second_tone_db=_second_tone(lateral, interval, frequency),
        harmonics=_harmonics(half, interval, frequency),
        stick=stick,
        contact_lost=None if normal is None else float((normal <= 0).mean()),
        normal_force=None if normal is None else (float(normal.min()), float(normal.max())),
        friction_force=None if friction is None else (float(friction.min()), float(friction.max())),
        irregular=is_irregular(lateral, interval),
    )


def _values(data: xr.Dataset | Samples, name: str) -> Real:
    return np.asarray(data[name], dtype=float)


def _rms(values: Real) -> float:
    return float(np.sqrt(np.square(values).mean()))


def _ratios(half: xr.Dataset | Samples) -> dict[str, float]:
    """Return rms velocity of the rail over that of the wheel, by direction of track and contact."""
    wheel, rail = (lateral_and_normal(half, component) for component in ("wheel", "rail"))
    return {d: _rms(rail[d]) / size for d in rail if d in wheel and (size := _rms(wheel[d])) > 0}


def _second_tone(signal: Real, interval: float, frequency: float | None) -> float:
    """Return the level re the dominant tone of the strongest line away from its harmonics [dB]."""
    f, amplitude = spectrum(signal, interval)
    if frequency is None:
        return -np.inf
    other = np.abs(f - frequency * np.round(f / frequency)) > max(0.02 * frequency, 4 * f[1])
    other &= f > 20
    strongest = np.where(other, amplitude, 0.0).max()
    with np.errstate(divide="ignore"):
        return float(20 * np.log10(strongest / amplitude.max()))


def _harmonics(half: xr.Dataset | Samples, interval: float, frequency: float | None) -> tuple[Harmonic, ...]:
    """Return the amplitudes at the multiples of a frequency that the sampling holds."""
    if frequency is None:
        return ()
    found: dict[str, dict[str, list[float]]] = {"wheel": {}, "rail": {}}
    count = min(HARMONICS, int(0.5 / (interval * frequency)))
    for component, lines in found.items():
        for d, velocity in lateral_and_normal(half, component).items():
            f, amplitude = spectrum(velocity, interval)
            near = [np.abs(f - k * frequency) < max(3.0, 3 * f[1]) for k in range(1, count + 1)]
            lines[d] = [float(amplitude[n].max()) for n in near]
    return tuple(
        Harmonic(
            k + 1,
            (k + 1) * frequency,
            {d: line[k] for d, line in found["wheel"].items()},
            {d: line[k] for d, line in found["rail"].items()},
        )
        for k in range(count)
    )


def _contact(half: xr.Dataset | Samples) -> tuple[Real | None, Real | None, float | None]:
    """Return normal force, friction force and the part of the time in stick; None where they were not recorded."""
    names = ("normal_force", "tangential_force_lat", "friction_coefficient")
    if not all(f"contact.{name}" in half for name in names):
        return None, None, None
    normal, friction, coefficient = (_values(half, f"contact.{name}") for name in names)
    loaded = normal > 0
    stick = loaded & (np.abs(friction) < STICK * coefficient * normal)
    return normal, friction, float(stick.mean())


def growth_of(data: xr.Dataset, poles: Poles) -> tuple[Growth, ...]:
    """Return the growth of the wheel's lateral velocity at the fastest unstable poles while it is small.

    Those that grow at least a third as fast as the fastest; the others are hidden by them.

    Notes
    -----
    The velocity is shifted by the pole's frequency and averaged over a Hann window, which turns an exponential into
    itself and keeps out tones more than two over its length away; the logarithm of the modulus is fitted by a line from
    the end of the starting pulse to where the velocity passes `LINEAR_VELOCITY`. The window is half of that time, at
    most 80 ms; if it is shorter than 20 ms, there is no growth to measure.
    """
    from scipy.signal import fftconvolve  # noqa: PLC0415

    velocity, interval = _values(data, "wheel.v_lat"), sample_interval(data)
    large = np.flatnonzero(np.abs(velocity) > LINEAR_VELOCITY)
    begin, end = round(_SETTLED_S / interval), int(large[0]) if large.size else velocity.size
    length = min(_WINDOW_S, (end - begin) * interval / 2)
    unstable = poles.unstable().below(0.4 / interval)
    if length < _SHORTEST_WINDOW_S or unstable.growth_rate.size == 0:
        return ()
    small = velocity[begin:end]
    time, window = interval * np.arange(small.size), np.hanning(round(length / interval))
    found = []
    for f, rate in zip(unstable.frequency_hz, unstable.growth_rate, strict=True):
        if rate >= unstable.growth_rate.max() / 3:
            level = np.abs(fftconvolve(small * np.exp(-2j * np.pi * f * time), window, mode="valid"))
            seen = np.polyfit(interval * np.arange(level.size), np.log(np.maximum(level, 1e-30)), 1)[0]
            found.append(Growth(float(f), float(rate), float(seen)))
    return tuple(found)
