"""Motion in contact axes: results in, velocities in the contact plane and along the contact normal out. No files.

In track axes the vertical velocity of a wheel at (n,0) is small, because its normal motion and the part of its lateral
motion that the contact angle turns upwards nearly cancel; what the contact spring couples is the normal motion.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..results.samples import Samples

Real = NDArray[np.float64]

PLANE, NORMAL = "plane", "normal"
"""Lateral in the contact plane, and along the contact normal."""


def contact_angle(data: xr.Dataset | Samples) -> float | None:
    """Return the contact angle of a run [rad]; None where the results do not tell it."""
    values = json.loads(data.attrs.get("all_parameters", "{}")).get("contact") or {}
    angle = values.get("contact_angle")
    return float(angle) if isinstance(angle, float | int) else None


def lateral_and_normal(data: xr.Dataset | Samples, component: str) -> dict[str, Real]:
    """Return the velocities of a component in the cross-section that are known: lat, ver, plane, normal [m/s]."""
    known = {d: f"{component}.v_{d}" for d in ("lat", "ver")}
    found = {d: np.asarray(data[name], dtype=float) for d, name in known.items() if name in data}
    angle = contact_angle(data)
    if angle is not None and len(found) == len(known):
        c, s = np.cos(angle), np.sin(angle)
        found[PLANE] = c * found["lat"] - s * found["ver"]
        found[NORMAL] = s * found["lat"] + c * found["ver"]
    return found
