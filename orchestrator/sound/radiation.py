"""Sound of the wheel by an engineering method: modal velocities and radiating areas in, power and pressure out.

After Thompson and Jones (J. Sound Vib. 253 (2002) 401-419): each mode radiates rho c (sigma_a A_a + sigma_r A_r) q'^2,
with radiation ratios by number of nodal diameters for axial and radial motion. Modes add by power. The coefficients
are not in the paper, so they are varied from `QUIET` to `LOUD` and the result comes with a band.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fmus.modal.parameters import modal_velocities
from fmus.wheel.wheelset import Wheelset

from ..errors import InputError
from ..signals.spectra import narrow_band

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

Real = NDArray[np.float64]

_KAPPA = (1.90, 1.015, -0.0189)
"""Coefficients of the reduced frequency k r at which the axial motion of n nodal diameters begins to radiate."""


@dataclass(frozen=True)
class Radiation:
    """How a wheel radiates and where it is heard.

    Attributes
    ----------
    radius, tyre_width : of the wheel [m]
    density, sound_speed : of the air [kg/m3, m/s]
    distance : from the wheel to the receiver [m]
    axial_factor, radial_factor : on the frequencies at which axial and radial motion begin to radiate [-]
    radial_share : factor on the power of the radial motion [-]
    directivity_db : level at the receiver above that of a source that radiates alike in all directions [dB]
    ground_db : what a reflecting ground adds [dB]
    """

    radius: float = 0.42
    tyre_width: float = 0.135
    density: float = 1.2
    sound_speed: float = 343.0
    distance: float = 7.5
    axial_factor: float = 1.0
    radial_factor: float = 1.0
    radial_share: float = 1.0
    directivity_db: float = 0.0
    ground_db: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        for name in ("radius", "tyre_width", "density", "sound_speed", "distance", "axial_factor", "radial_factor"):
            if not 0 < getattr(self, name) < np.inf:
                raise InputError(f"{name} = {getattr(self, name):g}: must be > 0")

    @property
    def pressure_per_power(self) -> float:
        """Mean-square pressure at the receiver per radiated power [Pa2/W]."""
        spread = self.density * self.sound_speed / (4 * np.pi * self.distance**2)
        return float(spread * 10 ** ((self.directivity_db + self.ground_db) / 10))


QUIET: dict[str, float] = {"axial_factor": 1.15, "radial_factor": 2.0, "radial_share": 0.0}
LOUD: dict[str, float] = {
    "axial_factor": 0.85, "radial_factor": 0.5, "radial_share": 2.0, "directivity_db": 4.8, "ground_db": 3.0,
}  # fmt: skip
"""What makes the lower and the upper end of the band of a level, which is monotone in each: coefficients known from
memory of the method or not at all; at the upper end also a receiver on the axis of a dipole and a hard ground."""


def axial_ratio(frequency_hz: ArrayLike, nodal_diameters: int, radiation: Radiation) -> Real:
    """Return the radiation ratio of axial motion.

    Notes
    -----
    1/(1 + (f_c/f)^(2n+4)) with f_c = c kappa(n)/(2 pi r): the slope is that of a multipole of order n + 1.

    >>> float(axial_ratio(1102.0, 3, Radiation()).round(3)), float(axial_ratio(418.34, 2, Radiation()).round(2))
    (0.997, 0.19)
    """
    n = nodal_diameters
    kappa = (_KAPPA[0] + _KAPPA[1] * n + _KAPPA[2] * n * n) * radiation.axial_factor
    corner = radiation.sound_speed * kappa / (2 * np.pi * radiation.radius)
    return _high_pass(frequency_hz, corner, 2 * n + 4)


def radial_ratio(frequency_hz: ArrayLike, nodal_diameters: int, radiation: Radiation) -> Real:
    """Return the radiation ratio of radial motion: of a narrow band of the tyre's width with n waves around it."""
    n = nodal_diameters
    width = radiation.radial_factor * radiation.sound_speed / (2 * np.pi * radiation.tyre_width)
    around = radiation.radial_factor * n * radiation.sound_speed / (2 * np.pi * radiation.radius)
    return _high_pass(frequency_hz, width, 2) * _high_pass(frequency_hz, around, 2 * n)


def _high_pass(frequency_hz: ArrayLike, corner: float, order: int) -> Real:
    """Return 1/(1 + (corner/f)^order), 0 at f = 0; 1 where there is no corner."""
    f = np.asarray(frequency_hz, dtype=float)
    if corner == 0:
        return np.ones_like(f)
    power = (f / corner) ** order
    ratio: Real = power / (1 + power)
    return ratio


def power_per_velocity(frequency_hz: ArrayLike, wheelset: Wheelset, mode: int, radiation: Radiation) -> Real:
    """Return the radiated power of one mode per mean-square modal velocity [W/(kg m2/s2)].

    Notes
    -----
    No more than the damping of the mode takes, 2 zeta omega: sound is a part of what is dissipated. Without the bound a
    weakly damped mode, and the upper end of the band of a level, would radiate energy that nothing gave.
    """
    dissipated = 2 * wheelset.modes.zeta[mode] * wheelset.modes.omega[mode]
    factor: Real = np.minimum(_unbounded(frequency_hz, wheelset, mode, radiation), dissipated)
    return factor


def _unbounded(frequency_hz: ArrayLike, wheelset: Wheelset, mode: int, radiation: Radiation) -> Real:
    """Return rho c sigma A of a mode."""
    n = int(wheelset.nodal_diameters[mode])
    axial = axial_ratio(frequency_hz, n, radiation) * wheelset.area_axial[mode]
    radial = radiation.radial_share * radial_ratio(frequency_hz, n, radiation) * wheelset.area_radial[mode]
    factor: Real = radiation.density * radiation.sound_speed * (axial + radial)
    return factor


def radiation_damping(wheelset: Wheelset, radiation: Radiation | None = None) -> Real:
    """Return the damping ratio that every mode has by its own sound alone, (n,).

    Notes
    -----
    zeta_rad = rho c sigma A/(2 omega) at the natural frequency: what one wheel radiates over the energy of its mode.
    A lower bound of the damping ratio.
    """
    how, omega = radiation or Radiation(), wheelset.modes.omega
    power = [_unbounded(w / (2 * np.pi), wheelset, i, how) for i, w in enumerate(omega)]
    return np.asarray(power) / (2 * omega)


def modal_spectra(data: xr.Dataset, resolution_hz: float = 2.0) -> xr.DataArray:
    """Return the mean square of every modal velocity of the wheel by line, (mode, frequency) [kg m2/s2].

    Parameters
    ----------
    data : results, or a part of them, with the modal velocities of the wheel
    resolution_hz : distance of the lines [Hz]
    """
    import xarray as xr  # noqa: PLC0415

    names = modal_velocities("wheel", data.data_vars)
    values = np.stack([data[name].to_numpy() for name in names])
    velocity = xr.DataArray(values, {"time": data["time"]}, ("mode", "time"), "modal_velocity", data[names[0]].attrs)
    return narrow_band(velocity, resolution_hz)


def sound_power(spectra: xr.DataArray, wheelset: Wheelset, radiation: Radiation | None = None) -> xr.DataArray:
    """Return the power that the wheel radiates by line [W].

    Parameters
    ----------
    spectra : (mode, frequency) mean squares of the modal velocities
    wheelset : radiating areas of the same modes
    """
    how = radiation or Radiation()
    frequency = np.asarray(spectra["frequency"])
    lines = np.zeros(frequency.size)
    for i, squares in enumerate(np.asarray(spectra)):
        if squares.any():
            lines += power_per_velocity(frequency, wheelset, i, how) * squares
    power = spectra.isel(mode=0, drop=True).copy(data=lines).rename("sound_power")
    return power.assign_attrs(units="W", long_name="radiated sound power by line")


def dissipated_power(spectra: xr.DataArray, wheelset: Wheelset) -> float:
    """Return the power that the damping of the wheel takes [W], the radiated one included."""
    squares = np.asarray(spectra).sum(axis=1)
    return float(2 * (wheelset.modes.zeta * wheelset.modes.omega) @ squares)


def sound_pressure(power: xr.DataArray, radiation: Radiation | None = None) -> xr.DataArray:
    """Return the mean-square pressure at the receiver by line [Pa2] of a spectrum of radiated power [W]."""
    pressure = (power * (radiation or Radiation()).pressure_per_power).rename("sound_pressure")
    return pressure.assign_attrs({**power.attrs, "units": "Pa^2", "long_name": "mean-square sound pressure by line"})
