"""The normal contact: Hertz's half-space solution for design, and the spring law of the running contact.

The design functions take steel on steel, both bodies of the same material.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from scipy.optimize import brentq
from scipy.special import ellipe, ellipkm1

from ..errors import DataError


@dataclass(frozen=True)
class Ellipse:
    """A Hertzian contact.

    Attributes
    ----------
    semi_axis_major, semi_axis_minor : semi-axes [m]
    pressure : largest pressure [Pa]
    approach : approach of distant points [m]
    stiffness : dN/d(approach) at this load [N/m]
    curvature_along, curvature_across : of the gap along the major and the minor axis, z = A x^2 + B y^2 [1/m]
    """

    semi_axis_major: float
    semi_axis_minor: float
    pressure: float
    approach: float
    stiffness: float
    curvature_along: float
    curvature_across: float


def ellipse(major: float, minor: float, load: float, young: float, poisson: float) -> Ellipse:
    """Return the Hertzian contact with given semi-axes [m] under `load` [N].

    Raises
    ------
    DataError
        Unless major > minor > 0 and load > 0.

    Notes
    -----
    K. L. Johnson, Contact Mechanics (1985), ch. 4; E* = E / (2 (1 - nu^2)) for two equal bodies.

    >>> round(ellipse(0.010, 0.005, 60e3, 210e9, 0.3).stiffness / 1e9, 2)
    1.68
    """
    if not major > minor > 0 or not load > 0:
        raise DataError(f"ellipse {major:g} x {minor:g} m under {load:g} N: must be major > minor > 0 and load > 0")
    ratio2 = (minor / major) ** 2
    m = 1.0 - ratio2
    k, e = float(ellipkm1(ratio2)), float(ellipe(m))
    modulus = young / (2 * (1 - poisson**2))
    pressure = 3 * load / (2 * math.pi * major * minor)
    approach = pressure * minor * k / modulus
    scale = pressure * minor / (modulus * major**2 * m)
    return Ellipse(
        semi_axis_major=major,
        semi_axis_minor=minor,
        pressure=pressure,
        approach=approach,
        stiffness=1.5 * load / approach,
        curvature_along=scale * (k - e),
        curvature_across=scale * (e / ratio2 - k),
    )


def ellipse_of_radii(larger: float, smaller: float, load: float, young: float, poisson: float) -> Ellipse:
    """Return the Hertzian contact of two crossed cylinders of the given radii [m], larger > smaller.

    >>> round(ellipse_of_radii(0.42, 0.30, 60e3, 210e9, 0.3).stiffness / 1e9, 2)
    1.2
    """
    if not larger > smaller > 0:
        raise DataError(f"radii {larger:g} and {smaller:g} m: must be larger > smaller > 0")
    wanted = larger / smaller

    def curvature_ratio(aspect: float) -> float:
        unit = ellipse(1.0, aspect, 1.0, young, poisson)
        return unit.curvature_across / unit.curvature_along - wanted

    aspect = float(brentq(curvature_ratio, 1e-3, 1 - 1e-9, xtol=1e-14))
    unit = ellipse(1.0, aspect, 1.0, young, poisson)
    # curvatures scale with load / length^3
    length = (load * unit.curvature_along * 2 * larger) ** (1 / 3)
    return ellipse(length, aspect * length, load, young, poisson)
