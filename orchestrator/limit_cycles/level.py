"""The sound of a cycle: lines of the wheel's modal velocities in, an A-weighted level out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.modal.modes import Modes
from fmus.wheel.wheelset import Wheelset

from ..signals.spectra import a_weighted, level
from ..sound.levels import REFERENCE_PRESSURE
from ..sound.radiation import sound_power, sound_pressure
from ..sound.wheelset import fitting_wheelset
from ..stability.poles import Structure
from .measures import Motion

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True)
class Radiator:
    """A wheel whose radiating areas are known.

    Attributes
    ----------
    wheelset : modes in the order of the motion's modal displacements
    """

    wheelset: Wheelset

    @classmethod
    def of(cls, wheel: Structure) -> Radiator | None:
        """Return the radiator that a wheel is; None if no shipped wheel has its modes, or it shows none."""
        if not isinstance(wheel, Modes):
            return None
        found = fitting_wheelset(wheel.omega / (2 * np.pi), wheel.shape[:, 1])
        return None if found is None else cls(found)

    def level_dba(self, motion: Motion) -> float:
        """Return the level of a cycle at 7.5 m [dB(A)]."""
        return self.level_of_lines(motion.omega * np.arange(1, len(motion.forces)), motion.wheel_modal[1:])

    def level_of_lines(self, omega: Real, displacement: Complex) -> float:
        """Return the level at 7.5 m [dB(A)] of lines at angular frequencies.

        Parameters
        ----------
        omega : (m,) [rad/s]
        displacement : (m, n) modal displacements, half of their amplitudes [kg^1/2 m]
        """
        import xarray as xr  # noqa: PLC0415 - takes a second to import

        rising = np.argsort(omega)
        velocity = omega[rising, None] * displacement[rising]
        squares = xr.DataArray(
            2 * np.abs(velocity.T) ** 2,
            dims=("mode", "frequency"),
            coords={"frequency": omega[rising] / (2 * np.pi)},
            attrs={"units": "kg.m2/s2"},
        )
        pressure = sound_pressure(sound_power(squares, self.wheelset))
        return float(level(a_weighted(pressure).sum(), REFERENCE_PRESSURE))
