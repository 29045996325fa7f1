"""Two profiles in, the table of their contact over the wheelset's shift out.

Rigid profiles touch at points that jump as the wheelset shifts. Here the gap has a soft minimum,
H = -eps ln integral exp(-gap / eps), whose derivative is the mean of the gap's slope with the weight exp(-gap / eps):
radius, angle and place are means with that weight, so that they go smoothly and forces stay consistent with the height
of the wheelset.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from ..creep.hertz import ellipse_of_radii
from ..errors import DataError
from .contact_table import ContactTable
from .profiles import SPACING, Profile

Real = NDArray[np.float64]

SOFTNESS = 0.02
"""eps [mm]: about the compression of the contact."""

LARGEST_SHIFT = 8.6
SHIFT_SPACING = 0.1
"""Extent and spacing of the table [mm]."""

GAUGE_DEPTH = 14.0
"""How far below the top of the rail the gauge is measured [mm]."""

PATCH_LOAD = 60e3
"""Normal force that the table's patches are given for [N]."""

YOUNG, POISSON = 210e9, 0.3
"""Of steel."""

_MOST_ITERATIONS = 50
_ROLL_TOLERANCE = 1e-13
"""Of the roll [rad]: 1e-10 mm at the wheel."""

_REACH = 40.0
"""Gap in units of eps beyond the smallest one, from which on a point has no weight that a double could show."""


@dataclass(frozen=True)
class Track:
    """How a rail lies.

    Attributes
    ----------
    inclination : slope of the rail's axis towards the middle of the track, such as 1/40 [-]
    gauge : [mm]
    tape_distance : distance of the tape circles of the wheelset [mm]
    wheel_radius : on the tape circle [mm]
    """

    inclination: float = 1 / 40
    gauge: float = 1435.0
    tape_distance: float = 1500.0
    wheel_radius: float = 420.0


def lay(rail: Profile, track: Track) -> tuple[Profile, float]:
    """Return the rail as it lies, lateral coordinates from the middle of the track, and where its crown is [mm].

    Raises
    ------
    DataError
        If the rail has no side 14 mm below its top.
    """
    c, s = np.cos(np.arctan(track.inclination)), np.sin(np.arctan(track.inclination))
    lateral = c * rail.lateral - s * rail.height
    height = c * rail.height + s * rail.lateral
    top = int(height.argmax())  # leaning over, a flank may hang back: what it hides touches nothing
    outermost = np.append(np.minimum.accumulate(lateral[top:0:-1])[::-1], lateral[top])
    seen = np.append(lateral[:top] < outermost[:-1] - 1e-9, True)
    seen = np.append(seen, lateral[top + 1 :] > np.maximum.accumulate(lateral[top:])[:-1] + 1e-9)
    hidden = not seen[0]
    lateral, height = lateral[seen], height[seen]
    side = height >= height.max() - GAUGE_DEPTH
    if side[0] and not hidden:
        raise DataError(f"{rail.title}: must reach {GAUGE_DEPTH:g} mm below its top on the gauge side, for the gauge")
    shift = track.gauge / 2 - lateral[side].min()
    laid = Profile(f"{rail.title} at {track.inclination:.4g}", rail.source, lateral + shift, height - height.max())
    return laid, float(shift)


@dataclass(frozen=True)
class _Touch:
    """The soft contact of one side: H; means of lateral coordinate, radius change, angle, curvature of the gap."""

    soft: float
    lateral: float
    radius: float
    angle: float
    curvature: float


class _Gap:
    """The gap of one side, as a function of shift towards the flange and roll."""

    def __init__(self, wheel: Profile, rail: Profile, track: Track) -> None:
        self.middle = track.tape_distance / 2
        self.q = np.arange(rail.lateral[0], rail.lateral[-1], SPACING)
        curve = CubicSpline(rail.lateral, rail.height)
        self.rail, self.rail_curvature = curve(self.q), curve(self.q, 2) / (1 + curve(self.q, 1) ** 2) ** 1.5
        self.s, self.height = wheel.lateral, wheel.height
        self.curve = CubicSpline(wheel.lateral, wheel.height)

    def touch(self, shift: float, roll: float) -> _Touch:
        """Return the soft contact; `roll` lifts the field side."""
        s = self.q - shift - self.middle
        gap = roll * self.q - np.interp(s, self.s, self.height, np.nan, np.nan) - self.rail
        near = np.flatnonzero(gap - np.nanmin(gap) < _REACH * SOFTNESS)
        q, at = self.q[near], s[near]
        height = self.curve(at)
        gap = roll * q - height - self.rail[near]
        lowest = gap.min()
        w = np.exp(-(gap - lowest) / SOFTNESS)
        total = w.sum()
        w /= total
        angle = np.arctan(roll - self.curve(at, 1))
        curvature = -self.curve(at, 2) * np.cos(angle) ** 3 - self.rail_curvature[near]
        return _Touch(
            float(lowest - SOFTNESS * np.log(total * SPACING)), float(w @ q), float(w @ height),
            float(w @ angle), float(w @ curvature),
        )  # fmt: skip

    def both(self, shift: float, roll: float) -> tuple[float, _Touch, _Touch]:
        """Return the roll with which both sides touch at a shift to the left, from a guess, and both contacts.

        Newton's method: the derivative of H by the roll is the mean lateral coordinate.
        """
        for _ in range(_MOST_ITERATIONS):
            left, right = self.touch(shift, roll), self.touch(-shift, -roll)
            change = (right.soft - left.soft) / (left.lateral + right.lateral)
            if abs(change) < _ROLL_TOLERANCE:
                return roll, left, right
            roll += change
        raise DataError(f"wheel and rail do not touch on both sides at a shift of {shift:g} mm")


def contact_table(wheel: Profile, rail: Profile, track: Track | None = None) -> ContactTable:
    """Return the table of contact of a wheel on a rail."""
    track = track or Track()
    laid, crown = lay(rail, track)
    gap = _Gap(wheel, laid, track)
    count = round(LARGEST_SHIFT / SHIFT_SPACING)
    shifts = np.arange(-count, count + 1) * SHIFT_SPACING
    roll, touches = 0.0, {}
    for k in range(count + 1):
        roll, touches[k], touches[-k] = gap.both(k * SHIFT_SPACING, roll)
    found = [touches[k] for k in range(-count, count + 1)]
    angle = np.array([t.angle for t in found])
    lateral = np.array([t.lateral for t in found])
    radius = np.array([t.radius for t in found])
    curvature = np.array([t.curvature for t in found])
    along = (track.wheel_radius + radius) / np.cos(angle)
    patches = np.array([_patch(1e-3 * a, 1e-3 / k) for a, k, d in zip(along, curvature, angle, strict=True)])
    return ContactTable(
        title=f"{wheel.title} on {laid.title}",
        shift=np.asarray(1e-3 * shifts, dtype=np.float64), radius_change=1e-3 * radius, contact_angle=angle,
        wheel_position=1e-3 * (lateral - shifts - track.tape_distance / 2), rail_position=1e-3 * (lateral - crown),
        semi_axis_lon=patches[:, 0], semi_axis_lat=patches[:, 1], hertz_stiffness=patches[:, 2],
        patch_load=PATCH_LOAD,
    )  # fmt: skip


def _patch(along: float, across: float) -> tuple[float, float, float]:
    """Return semi-axes, rolling direction first, and stiffness of Hertz's patch at `PATCH_LOAD` for two radii [m]."""
    larger, smaller = max(along, across), min(along, across)
    hertz = ellipse_of_radii(max(larger, smaller * (1 + 1e-9)), smaller, PATCH_LOAD, YOUNG, POISSON)
    axes = (hertz.semi_axis_major, hertz.semi_axis_minor)
    return (*(axes if along >= across else axes[::-1]), hertz.stiffness)
