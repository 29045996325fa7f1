"""The sound of a cycle: lines of the wheel's modal velocities in, an A-weighted level out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fmus.modal.modes import Modes
from fmus.wheel.wheelset import Wheelset

from ..signals.spectra import a_weighted, level
from ..sound.levels import REFERENCE_PRESSURE
from ..sound.radiation import sound_power, sound_pressure
from ..sound.wheelset import fitting_wheelset
from ..stability.poles import Structure
from .measures import Motion


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
        """Return the level at 7.5 m [dB(A)]."""
        import xarray as xr  # noqa: PLC0415 - takes a second to import

        k = np.arange(1, len(motion.forces))
        velocity = 1j * k[:, None] * motion.omega * motion.wheel_modal[1:]
        squares = xr.DataArray(
            2 * np.abs(velocity.T) ** 2,
            dims=("mode", "frequency"),
            coords={"frequency": k * motion.omega / (2 * np.pi)},
            attrs={"units": "kg.m2/s2"},
        )
        pressure = sound_pressure(sound_power(squares, self.wheelset))
        return float(level(a_weighted(pressure).sum(), REFERENCE_PRESSURE))
