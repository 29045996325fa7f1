"""Cross-section of a wheelset: dimensions from TOML in, checked `Section` out. No meshing, no physics, no plotting.

Half a wheelset is described, from mid-axle (z = 0) outwards: a rim under a running profile, a web, a hub, and the axle
that the hub sits on. All parts are bodies of revolution about the z axis; r is the distance from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...data_file import read_settings
from ...errors import DataError

Real = NDArray[np.float64]
Profile = tuple[tuple[float, float], ...]

_SAMPLES = np.linspace(0.0, 1.0, 201)


@dataclass(frozen=True)
class Material:
    """An isotropic elastic material.

    Attributes
    ----------
    young_modulus : E [Pa], > 0
    poisson_ratio : nu [-], -1 < nu < 0.5
    density : rho [kg/m3], > 0
    """

    young_modulus: float
    poisson_ratio: float
    density: float

    def __post_init__(self) -> None:
        """Check the ranges."""
        for name in ("young_modulus", "density"):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0):
                raise DataError(f"material: {name} = {value:g}; must be finite and > 0")
        if not -1 < self.poisson_ratio < 0.5:
            raise DataError(f"material: poisson_ratio = {self.poisson_ratio:g}; must be between -1 and 0.5")


@dataclass(frozen=True)
class Web:
    """The web between hub and rim; t runs from 0 at the rim to 1 at the hub.

    Attributes
    ----------
    rim_position, hub_position : z of the centre line at both ends [m]
    bulge : amplitude of the half sine added to the centre line [m], positive to the field side
    rim_thickness, hub_thickness : axial thickness at both ends without fillets [m]
    extra_thickness : what is added at mid-web [m]
    fillet_growth, fillet_length : relative growth of the thickness at either end, and the t in which it fades by e
    """

    rim_position: float
    hub_position: float
    bulge: float
    rim_thickness: float
    hub_thickness: float
    extra_thickness: float
    fillet_growth: float
    fillet_length: float

    def centre(self, t: ArrayLike) -> Real:
        """Return z of the centre line: a smooth step from rim to hub and a half sine [m]."""
        t = np.asarray(t, dtype=float)
        step = t * t * (3 - 2 * t)
        return np.asarray(
            self.rim_position + (self.hub_position - self.rim_position) * step + self.bulge * np.sin(np.pi * t)
        )

    def thickness(self, t: ArrayLike) -> Real:
        """Return the axial thickness [m]."""
        t = np.asarray(t, dtype=float)
        plain = (
            self.rim_thickness + (self.hub_thickness - self.rim_thickness) * t + 4 * self.extra_thickness * t * (1 - t)
        )
        fillets = np.exp(-t / self.fillet_length) + np.exp(-(1 - t) / self.fillet_length)
        return np.asarray(plain * (1 + self.fillet_growth * fillets))

    def sides(self, t: ArrayLike) -> tuple[Real, Real]:
        """Return z of the gauge-side and the field-side face [m]."""
        return self.centre(t) - self.thickness(t) / 2, self.centre(t) + self.thickness(t) / 2


@dataclass(frozen=True)
class Section:
    """Half a wheelset.

    Attributes
    ----------
    title : what it is
    material : of wheel and axle
    contact_position, contact_radius : z and r of the nominal contact point [m], a point of the running profile
    profile : (z, r) of the running profile with flange, from the flange back to the field side [m]
    rim_inner_radius : [m]
    web : between rim and hub
    hub_faces : z of the hub's faces [m]
    hub_radius : outer radius of the hub [m]; its inner one is the axle's
    axle : (z, r) of the axle's surface from mid-axle (z = 0) to its end [m]

    Raises
    ------
    DataError
        For a value out of range, or parts that overlap or miss each other so that the outline intersects itself.
    """

    title: str
    material: Material
    contact_position: float
    contact_radius: float
    profile: Profile
    rim_inner_radius: float
    web: Web
    hub_faces: tuple[float, float]
    hub_radius: float
    axle: Profile

    def __post_init__(self) -> None:
        """Check each line of the outline, then how the parts meet."""
        numbers = [self.contact_position, self.contact_radius, self.rim_inner_radius, self.hub_radius, *self.hub_faces]
        numbers += [x for point in (*self.profile, *self.axle) for x in point]
        numbers += [getattr(self.web, name) for name in Web.__dataclass_fields__]
        if not np.isfinite(numbers).all():
            raise DataError("section: a dimension is not finite")
        _check_line("running profile", self.profile)
        _check_line("axle", self.axle)
        self._check_radii()
        self._check_web()
        self._check_contact()

    def profile_radius(self, z: ArrayLike) -> Real:
        """Return r of the running profile [m]."""
        return _follow(self.profile, z)

    def axle_radius(self, z: ArrayLike) -> Real:
        """Return r of the axle's surface [m]."""
        return _follow(self.axle, z)

    def web_parameter(self, r: ArrayLike) -> Real:
        """Return t of the web at radius r: 0 at the rim, 1 at the hub."""
        return np.asarray((self.rim_inner_radius - np.asarray(r)) / (self.rim_inner_radius - self.hub_radius))

    def outline(self) -> list[Real]:
        """Return the closed outlines of wheel and axle as (k, 2) arrays of (z, r) [m]."""
        left, right = self.web.sides(_SAMPLES)
        r = self.rim_inner_radius + (self.hub_radius - self.rim_inner_radius) * _SAMPLES
        a, b = self.profile[0][0], self.profile[-1][0]
        c, d = self.hub_faces
        seat = float(self.axle_radius(c))
        wheel = np.vstack([
            self.profile, (b, self.rim_inner_radius), np.column_stack([right, r]), (d, self.hub_radius), (d, seat),
            (c, seat), (c, self.hub_radius), np.column_stack([left, r])[::-1], (a, self.rim_inner_radius),
            self.profile[:1],
        ])  # fmt: skip
        return [wheel, np.vstack([self.axle, (self.axle[-1][0], 0.0), (0.0, 0.0), self.axle[:1]])]

    def _check_radii(self) -> None:
        """Check that the parts follow each other outwards and the hub sits on a cylinder."""
        inner, outer = self.hub_faces
        if not 0 < inner < outer < self.axle[-1][0]:
            raise DataError(
                f"section: hub faces at {inner:g} and {outer:g} m; must rise between mid-axle and the axle's end, "
                f"{self.axle[-1][0]:g} m"
            )
        seat = self.axle_radius([inner, outer, *(z for z, _ in self.axle if inner < z < outer)])
        if np.ptp(seat) > 1e-9:
            raise DataError("section: the axle's radius changes under the hub; the seat must be a cylinder")
        radii = [float(seat[0]), self.hub_radius, self.rim_inner_radius, min(r for _, r in self.profile)]
        if not all(a < b for a, b in pairwise(radii)):
            raise DataError(
                "section: the outline intersects itself: radii of seat, hub, rim inside and running profile are "
                f"{', '.join(f'{r:g}' for r in radii)} m; must increase"
            )

    def _check_web(self) -> None:
        """Check that the web has a thickness and ends within rim and hub."""
        if self.web.fillet_length <= 0:
            raise DataError(f"section: fillet_length = {self.web.fillet_length:g}; must be > 0")
        if self.web.thickness(_SAMPLES).min() <= 0:
            raise DataError("section: the outline intersects itself: the faces of the web cross")
        rim = (self.profile[0][0], self.profile[-1][0])
        for part, t, (low, high) in (("rim", 0.0, rim), ("hub", 1.0, self.hub_faces)):
            left, right = (float(side) for side in self.web.sides(t))
            if not low < left < right < high:
                raise DataError(
                    f"section: the outline intersects itself: the web meets the {part} from z = {left:.4f} to "
                    f"{right:.4f} m; must be between {low:g} and {high:g} m"
                )

    def _check_contact(self) -> None:
        """Check that the contact point is on the running profile."""
        z, r = self.contact_position, self.contact_radius
        if not self.profile[0][0] < z < self.profile[-1][0] or abs(float(self.profile_radius(z)) - r) > 1e-6:
            raise DataError(f"section: the contact point z = {z:g}, r = {r:g} m is not on the running profile")


def _follow(line: Profile, z: ArrayLike) -> Real:
    """Return r of a line of (z, r) at the given z."""
    return np.asarray(np.interp(np.asarray(z, dtype=float), *np.transpose(line)))


def _check_line(name: str, line: Profile) -> None:
    """Check that a line of (z, r) goes outwards and stays off the axis."""
    if len(line) < 2 or any(b[0] <= a[0] for a, b in pairwise(line)):
        raise DataError(f"section: the outline intersects itself: z of the {name} must increase from point to point")
    if min(r for _, r in line) <= 0:
        raise DataError(f"section: the outline intersects itself: r of the {name} must be > 0")
    if name == "axle" and line[0][0] != 0:
        raise DataError(f"section: the axle starts at z = {line[0][0]:g} m; must start at mid-axle, 0 m")


def read_section(path: Path) -> Section:
    """Return the cross-section that a TOML file such as `data/generic840-section.toml` describes.

    Raises
    ------
    DataError
        For a missing dimension, one that is no number, or a geometry that `Section` refuses.
    """
    try:
        return _section(read_settings(path))
    except KeyError as error:
        raise DataError(f"{path.name}: {error.args[0]!r} is missing") from None
    except (TypeError, AttributeError) as error:
        raise DataError(f"{path.name}: {error}; every dimension must be a number") from None
    except ValueError as error:
        raise DataError(f"{path.name}: {error}") from None


def _section(data: dict[str, Any]) -> Section:
    """Return the cross-section of the tables of a TOML file."""
    web = data["web"]
    return Section(
        title=data["title"],
        material=Material(
            data["material"]["young_modulus_pa"],
            data["material"]["poisson_ratio"],
            data["material"]["density_kg_m3"],
        ),
        contact_position=data["contact"]["position_m"],
        contact_radius=data["contact"]["radius_m"],
        profile=_points(data["rim"]["profile_m"]),
        rim_inner_radius=data["rim"]["inner_radius_m"],
        web=Web(
            rim_position=web["rim_position_m"],
            hub_position=web["hub_position_m"],
            bulge=web["bulge_m"],
            rim_thickness=web["rim_thickness_m"],
            hub_thickness=web["hub_thickness_m"],
            extra_thickness=web["extra_thickness_m"],
            fillet_growth=web["fillet_growth"],
            fillet_length=web["fillet_length"],
        ),
        hub_faces=_pair(data["hub"]["faces_m"]),
        hub_radius=data["hub"]["radius_m"],
        axle=_points(data["axle"]["profile_m"]),
    )


def _points(pairs: list[list[float]]) -> Profile:
    """Return a list of pairs as tuples of floats."""
    return tuple(_pair(pair) for pair in pairs)


def _pair(values: list[float]) -> tuple[float, float]:
    """Return two numbers."""
    if len(values) != 2:
        raise DataError(f"{values} must be a pair of numbers")
    return float(values[0]), float(values[1])
