"""How loud a run is: results in, levels of wheel and rail at a receiver out, apart and together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fmus.rail.track_data import TRACKS, read_track
from fmus.wheel.wheelset import Wheelset

from ..signals.spectra import a_weighted, level, third_octaves, total
from .radiation import LOUD, QUIET, Radiation, dissipated_power, modal_spectra, sound_power, sound_pressure
from .rail import RailRadiation, rail_of, rail_power, rail_pressure
from .wheelset import wheelset_of

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

REFERENCE_PRESSURE = 2e-5
"""Reference of sound pressure levels [Pa]."""

REFERENCE_POWER = 1e-12
"""Reference of sound power levels [W]."""

LOWEST_BAND_HZ = 100.0
"""Lowest one-third-octave band of a result [Hz]; nothing of a wheel radiates below."""


@dataclass(frozen=True)
class RailSound:
    """The sound of the rail at the receiver.

    Attributes
    ----------
    level_dba : A-weighted level [dB(A)]; minus infinity for a rail that does not move
    power_db : sound power level [dB re 1 pW]
    """

    level_dba: float
    power_db: float


@dataclass(frozen=True)
class Sound:
    """The sound of a run at the receiver; of the wheel unless it says otherwise, as the paper has it.

    Attributes
    ----------
    narrow : (frequency,) mean-square pressure by line [Pa2]
    bands : (band,) level in one-third-octave bands, not weighted [dB]
    level_dba : A-weighted level [dB(A)]; minus infinity for silence
    low_dba, high_dba : the same between which the doubtful coefficients put it
    power_db : sound power level [dB re 1 pW]
    radiated_share : radiated power over all that the wheel's damping takes [-]; None for a wheel at rest
    wheelset : whose radiating areas were taken
    rail : the rail's sound, or the reason why it is not known
    total_dba : of wheel and rail together [dB(A)]; None where the rail's is not known
    """

    narrow: xr.DataArray
    bands: xr.DataArray
    level_dba: float
    low_dba: float
    high_dba: float
    power_db: float
    radiated_share: float | None
    wheelset: str
    rail: RailSound | str
    total_dba: float | None

    @property
    def rail_dba(self) -> float | None:
        """A-weighted level of the rail [dB(A)]; None where it is not known, or the rail does not move."""
        return None if isinstance(self.rail, str) or np.isinf(self.rail.level_dba) else self.rail.level_dba


def sound_of(
    data: xr.Dataset,
    wheel: str | Wheelset | None = None,
    radiation: Radiation | None = None,
    resolution_hz: float = 2.0,
) -> Sound:
    """Return the sound of the second half of a run.

    Raises
    ------
    InputError
        If the results hold no modal velocities, are too short for the resolution, or belong to an unknown wheel.
    """
    wheelset, nominal = wheelset_of(data, wheel), radiation or Radiation()
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    spectra = modal_spectra(half, resolution_hz)

    def pressure(how: Radiation) -> xr.DataArray:
        return sound_pressure(sound_power(spectra, wheelset, how), how)

    narrow = pressure(nominal)
    power = total(narrow) / nominal.pressure_per_power
    dissipated = dissipated_power(spectra, wheelset)
    rail, of_rail = _rail(half, nominal, resolution_hz)
    return Sound(
        narrow=narrow,
        bands=level(third_octaves(narrow, LOWEST_BAND_HZ), REFERENCE_PRESSURE),
        level_dba=_dba(narrow),
        low_dba=_dba(pressure(replace(nominal, **QUIET))),
        high_dba=_dba(pressure(replace(nominal, **LOUD))),
        power_db=_power_db(power),
        radiated_share=power / dissipated if dissipated > 0 else None,
        wheelset=wheelset.title,
        rail=rail,
        total_dba=None if of_rail is None else _dba(narrow + of_rail.to_numpy()),
    )


def _rail(half: xr.Dataset, air: Radiation, resolution_hz: float) -> tuple[RailSound | str, xr.DataArray | None]:
    """Return the rail's sound and its pressure by line, or the reason why they are not known."""
    found = rail_of(half, resolution_hz)
    if isinstance(found, str):
        return found, None
    lines = found.velocity[0]
    frequency, squares = np.asarray(lines["frequency"]), np.stack([np.asarray(v) for v in found.velocity])
    how = RailRadiation(found.track or read_track(TRACKS / "default.toml"), air)
    power = rail_power(squares, frequency, how)
    pressure = lines.copy(data=rail_pressure(power, frequency, how)).rename("sound_pressure")
    pressure = pressure.assign_attrs(units="Pa^2", long_name="mean-square sound pressure of the rail by line")
    return RailSound(_dba(pressure), _power_db(float(power.sum()))), pressure


def _power_db(power: float) -> float:
    with np.errstate(divide="ignore"):
        return float(10 * np.log10(power / REFERENCE_POWER))


def _dba(pressure: xr.DataArray) -> float:
    """Return the A-weighted level of a spectrum of pressure [dB(A)]."""
    return float(level(a_weighted(pressure).sum(), REFERENCE_PRESSURE))
