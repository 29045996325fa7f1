"""Contact geometry of a wheel on a rail, over the wheelset's shift: what the equilibrium needs of two profiles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import DataError
from .parameters import TABLE

Real = NDArray[np.float64]


@dataclass(frozen=True)
class ContactTable:
    """Contact of one wheel over the shift towards its flange, evenly spaced.

    Attributes
    ----------
    title : which wheel on which rail
    shift : (n,) [m], even, with as much on either side of 0
    radius_change : (n,) of the rolling radius [m]
    contact_angle : (n,) with the roll of the wheelset [rad]
    wheel_position, rail_position : (n,) of the contact from tape circle and crown, to the field side [m]
    semi_axis_lon, semi_axis_lat : (n,) of the patch at `patch_load` [m]
    hertz_stiffness : (n,) at `patch_load` [N/m]
    patch_load : [N]
    """

    title: str
    shift: Real
    radius_change: Real
    contact_angle: Real
    wheel_position: Real
    rail_position: Real
    semi_axis_lon: Real
    semi_axis_lat: Real
    hertz_stiffness: Real
    patch_load: float

    def __post_init__(self) -> None:
        """Check shapes and spacing."""
        n = self.shift.size
        for name, *_ in TABLE:
            column = getattr(self, name)
            if column.shape != (n,) or not np.isfinite(column).all():
                raise DataError(f"{self.title}: {name} must be {n} finite numbers, one per shift")
        if n < 3 or np.ptp(np.diff(self.shift)) > 1e-9 or abs(self.shift[0] + self.shift[-1]) > 1e-9:
            raise DataError(f"{self.title}: shifts must be even and as many on either side of 0; got {n}")

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the vehicle component that go with the table."""
        return {
            "table_start": float(self.shift[0]),
            "table_spacing": float(np.diff(self.shift).mean()),
            "patch_load": self.patch_load,
        }

    def equivalent_slope(self, amplitude: float) -> float:
        """Return the difference of the rolling radii at a shift, over twice the shift [-]."""
        flange = float(np.interp(amplitude, self.shift, self.radius_change))
        field = float(np.interp(-amplitude, self.shift, self.radius_change))
        return (flange - field) / (2 * amplitude)
