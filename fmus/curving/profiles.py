"""Profiles of wheels and rails: the standards' formulas or a table in, height over the lateral coordinate out.

Lengths in mm, as the standards have them. A wheel's lateral coordinate is 0 on the tape circle, a rail's 0 at its
crown; both are positive to the field side. Heights: of a wheel, the increase of its radius; of a rail, upwards.
"""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import DataError

Real = NDArray[np.float64]

SPACING = 0.02
"""Spacing of the profiles made here [mm]."""


@dataclass(frozen=True)
class Profile:
    """A profile as points that follow each other from the gauge to the field side.

    Attributes
    ----------
    title : what it is
    source : where it comes from
    lateral, height : (n,) [mm]; the lateral coordinate increases
    """

    title: str
    source: str
    lateral: Real
    height: Real

    def __post_init__(self) -> None:
        """Check that there is one height for each lateral coordinate."""
        if self.lateral.ndim != 1 or self.lateral.shape != self.height.shape or self.lateral.size < 4:
            raise DataError(f"{self.title}: must be at least 4 points of a lateral coordinate and a height")
        if not (np.isfinite(self.lateral).all() and np.isfinite(self.height).all()):
            raise DataError(f"{self.title}: coordinates must be finite numbers")
        back = np.flatnonzero(np.diff(self.lateral) <= 0)
        if back.size:
            at = int(back[0]) + 2
            raise DataError(
                f"{self.title}: the profile folds: the lateral coordinate must increase from point to point; "
                f"point {at} is at {self.lateral[at - 1]:g} mm after {self.lateral[at - 2]:g} mm"
            )

    def at(self, lateral: Real) -> Real:
        """Return the heights; no number beyond the ends."""
        return np.asarray(np.interp(lateral, self.lateral, self.height, left=np.nan, right=np.nan))


_S1002_B = (
    0.0, -3.358537058e-2, 1.565681624e-3, -2.810427944e-5, 5.844240864e-8, -1.562379023e-8, 5.309217349e-15,
    -5.957839843e-12, 2.646656573e-13,
)  # fmt: skip
_S1002_C = (
    -4.320221063e3, -1.038384026e3, -1.065501873e2, -6.051367875, -2.054332446e-1, -4.169739389e-3, -4.687195829e-5,
    -2.252755540e-7,
)  # fmt: skip

S1002_JOINTS = (-38.426669, -35.0, -26.0, 32.15796)
"""Where the zones E, D, C, B, A meet [mm]."""

_S1002_ENDS = (-39.76, 60.0)


def s1002_zone(zone: str, s: Real) -> Real:
    """Return the height of one zone of S1002, A to E, at tape-circle coordinates [mm].

    Notes
    -----
    EN 13715: run-out A of slope 1:15, polynomials B and C, arc D of 13 mm, flank E of 70 degrees. Beyond the flank the
    flange's tip touches no rail and is left out.
    """
    s = np.asarray(s, dtype=float)
    if zone == "A":
        return np.asarray(1.364323640 - s / 15)
    if zone in "BC":
        return np.asarray(np.polynomial.polynomial.polyval(s, _S1002_B if zone == "B" else _S1002_C))
    if zone == "D":
        return np.asarray(16.446 - np.sqrt(13.0**2 - (s + 26.210665) ** 2))
    return np.asarray(-93.576667419 - 2.747477419 * s)


def s1002() -> Profile:
    """Return the wheel profile S1002."""
    s = _grid(*_S1002_ENDS)
    zones = np.searchsorted(S1002_JOINTS, s)
    height = np.empty(s.size)
    for k, zone in enumerate("EDCBA"):
        here = zones == k
        height[here] = s1002_zone(zone, s[here])
    return Profile("S1002", "EN 13715", s, height)


RAIL_ARCS = ((300.0, 10.228), (80.0, 26.0265), (13.0, math.inf))
"""Radii of the head of 60E1 and where each arc ends [mm]; the flank of 1:20 follows the last one."""

_FLANK_HEIGHT = 25.0
"""How far the flank of the head is followed below its crown [mm]."""


def rail_60e1() -> Profile:
    """Return the head of rail 60E1 (EN 13674-1), upright: arcs of 300, 80 and 13 mm, tangential, and flanks of 1:20."""
    x, z = _half_head()
    return Profile(
        "60E1", "EN 13674-1", np.concatenate([-x[:0:-1], x]), np.concatenate([z[:0:-1], z])
    )  # fmt: skip


def _half_head() -> tuple[Real, Real]:
    """Return the head from its crown to the side."""
    centre = np.array([0.0, -RAIL_ARCS[0][0]])
    before = 0.0  # angle of the normal from the vertical where the arc begins
    xs, zs = [np.zeros(1)], [np.zeros(1)]
    for i, (radius, end) in enumerate(RAIL_ARCS):
        last = math.atan(20.0) if end == math.inf else math.asin((end - centre[0]) / radius)
        angle = np.linspace(before, last, max(int(radius * (last - before) / SPACING), 2) + 1)[1:]
        xs.append(centre[0] + radius * np.sin(angle))
        zs.append(centre[1] + radius * np.cos(angle))
        before = last
        if i + 1 < len(RAIL_ARCS):
            centre = centre + (radius - RAIL_ARCS[i + 1][0]) * np.array([math.sin(last), math.cos(last)])
    x, z = np.concatenate(xs), np.concatenate(zs)
    down = np.arange(z[-1] - SPACING, -_FLANK_HEIGHT, -SPACING)
    return np.concatenate([x, x[-1] + (z[-1] - down) / 20]), np.concatenate([z, down])


def read_profile(path: Path) -> Profile:
    """Return the profile of a table: comma-separated `lateral_mm,height_mm`, after a line `# source: ...`.

    Raises
    ------
    DataError
        One sentence with file, line, what was wanted and what came.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise DataError(f"{path.name}: must be a text file in UTF-8") from None
    comments = [line.lstrip("# ").strip() for line in lines if line.startswith("#")]
    sources = [c.partition(":")[2].strip() for c in comments if c.lower().startswith("source:")]
    if not sources or not sources[0]:
        raise DataError(f"{path.name}: a line '# source: ...' must say where the profile comes from; got none")
    numbered = [(n, line) for n, line in enumerate(lines, start=1) if line.strip() and not line.startswith("#")]
    if not numbered or [c.strip() for c in numbered[0][1].split(",")] != ["lateral_mm", "height_mm"]:
        raise DataError(f"{path.name}: the first line must be lateral_mm,height_mm; got {numbered[:1]}")
    points = []
    for number, row in zip([n for n, _ in numbered[1:]], csv.reader(line for _, line in numbered[1:]), strict=True):
        try:
            lateral, height = (float(c) for c in row)
        except ValueError:
            raise DataError(f"{path.name}, line {number}: must be two numbers; got {','.join(row)!r}") from None
        points.append((lateral, height))
    table = np.array(points).reshape(-1, 2)
    return Profile(path.stem, sources[0], table[:, 0], table[:, 1])


def _grid(first: float, last: float) -> Real:
    """Return evenly spaced lateral coordinates."""
    return np.linspace(first, last, round((last - first) / SPACING) + 1)
