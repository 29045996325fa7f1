"""Sound of the rail: velocity at the contact in, power by line and pressure at a receiver out.

Every piece of rail radiates like an oscillating cylinder as wide as the rail, and the vibration dies away to both sides
of the contact with the decay rates of the analytical track: a line of independent point sources. After the engineering
method of Thompson and Jones (J. Sound Vib. 231 (2000) 519-536); what the sleepers radiate is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import h1vp, sici

from fmus.modal.data import read_modal_data
from fmus.rail.component import DATA, SHIPPED
from fmus.rail.track import decay_rates
from fmus.rail.track_data import TRACKS, Track, read_track

from ..signals.spectra import narrow_band
from .radiation import Radiation
from .wheelset import SAME_FREQUENCY, block

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

Real = NDArray[np.float64]

DIRECTIONS = ("lat", "ver")
"""Directions in which the rail radiates, in the order of `decay_rates`."""

OF_DEFAULT_TRACK = ("accurate", "paper")
"""Methods by which shipped rails are modal equivalents of the default track, whose decay rates they have."""


@dataclass(frozen=True)
class RailRadiation:
    """How a rail radiates.

    Attributes
    ----------
    track : whose decay rates and section
    air : density, sound speed, distance to the receiver, directivity and ground
    """

    track: Track
    air: Radiation

    @property
    def widths(self) -> tuple[float, float]:
        """Width across the motion [m]: the rail's height for lateral, its foot's width for vertical motion."""
        section = self.track.section
        return section.head_height + section.foot_depth, section.foot_width


def cylinder_ratio(frequency_hz: ArrayLike, width: float, sound_speed: float) -> Real:
    """Return the radiation ratio of a long cylinder that oscillates across its axis.

    Notes
    -----
    2/(pi k a |H1'(k a)|^2), H1 the Hankel function of the first order, a half the width: pi (k a)^3/2, a line dipole,
    at low frequencies, and 1 at high ones. The power per length is rho c pi a sigma v^2.

    >>> [float(s.round(3)) for s in cylinder_ratio([100.0, 1000.0, 5000.0], 0.15, 343.0)]
    [0.004, 0.912, 1.002]
    """
    ka = np.pi * np.asarray(frequency_hz, dtype=float) * width / sound_speed
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = 2 / (np.pi * ka * np.abs(h1vp(1, ka)) ** 2)
    return np.where(ka > 0, ratio, 0.0)


def line_factor(decay: ArrayLike, distance: float) -> Real:
    """Return what the decay along the line makes of the pressure of all its power in one point, 0 to 1 [-].

    Notes
    -----
    beta times the integral of exp(-2 beta |x|) d^2/(d^2 + x^2) over the whole line; with z = 2 beta d it is
    z (Ci(z) sin z + (pi/2 - Si(z)) cos z): 1 for a source that dies away at once, pi beta d for one that never does.
    """
    z = 2 * np.asarray(decay, dtype=float) * distance
    sine, cosine = sici(z)
    with np.errstate(divide="ignore", invalid="ignore"):
        near = z * (cosine * np.sin(z) + (np.pi / 2 - sine) * np.cos(z))
        far = 1 - 2 / z**2 + 24 / z**4  # where the difference above is all rounding
    return np.where(z > 100, far, np.where(z > 0, near, 0.0))


def rail_power(squares: Real, frequency_hz: Real, how: RailRadiation) -> Real:
    """Return the power that the whole rail radiates by line and direction, (2, m) [W].

    Parameters
    ----------
    squares : (2, m) mean squares of the lateral and vertical velocity at the contact by line [m2/s2]
    frequency_hz : (m,) lines [Hz]

    Notes
    -----
    Per length rho c pi (width/2) sigma v^2, over the rail times 1/beta.
    """
    beta = _decay(frequency_hz, how.track)
    sigma = [cylinder_ratio(frequency_hz, width, how.air.sound_speed) * np.pi * width / 2 for width in how.widths]
    return np.asarray(how.air.density * how.air.sound_speed * np.stack(sigma) * squares / beta)


def rail_pressure(power: Real, frequency_hz: Real, how: RailRadiation) -> Real:
    """Return the mean-square pressure at the receiver by line, (m,) [Pa2], of power by direction, (2, m)."""
    factor = line_factor(_decay(frequency_hz, how.track), how.air.distance)
    return np.asarray(how.air.pressure_per_power * (power * factor).sum(axis=0))


def _decay(frequency_hz: Real, track: Track) -> Real:
    """Return the decay rates, (2, m), those of the first positive frequency at 0 Hz."""
    f = np.maximum(frequency_hz, frequency_hz[frequency_hz > 0].min())
    return decay_rates(2 * np.pi * f, track).T


@dataclass(frozen=True)
class RailSpectra:
    """The rail's motion in the results of a run, and the track that it is of.

    Attributes
    ----------
    velocity : lateral and vertical mean squares by line, each with the coordinate frequency
    track : None where the rail does not move
    """

    velocity: tuple[xr.DataArray, xr.DataArray]
    track: Track | None


def rail_of(data: xr.Dataset, resolution_hz: float) -> RailSpectra | str:
    """Return the rail's motion, or the reason why its sound is not known.

    Parameters
    ----------
    data : results, or a part of them
    resolution_hz : distance of the lines [Hz]
    """
    names = [f"rail.v_{direction}" for direction in DIRECTIONS]
    missing = [name for name in names if name not in data]
    if missing:
        return f"the results have no {missing[0]}"
    lateral, vertical = (narrow_band(data[name], resolution_hz) for name in names)
    if not any(np.abs(data[name].to_numpy()).max() > 0 for name in names):
        return RailSpectra((lateral, vertical), None)
    frequency = block(data, "rail", "frequency")
    for name in (name for name, rail in SHIPPED.items() if rail.method in OF_DEFAULT_TRACK):
        own = read_modal_data(DATA / f"{name}.toml").modes.omega / (2 * np.pi)
        if own.size == frequency.size and np.allclose(own, frequency, rtol=SAME_FREQUENCY):
            return RailSpectra((lateral, vertical), read_track(TRACKS / "default.toml"))
    return "the decay rates of its rail are not known; those of the default track belong to its modal equivalents only"
