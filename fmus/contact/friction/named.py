"""Friction laws by name, with their sources, and laws from points: parameter values of the contact out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...errors import DataError
from ..friction_parameters import (
    ABSCISSA,
    FALLING,
    ORDINATE,
    POLACH,
    TABLE_OF_CREEPAGE,
    TABLE_OF_VELOCITY,
    TABLE_POINTS,
    TWO_DECAYS,
)


@dataclass(frozen=True)
class NamedLaw:
    """A friction law that has a name.

    Attributes
    ----------
    values : parameters of the contact that make it; without `mu0` it takes that of the contact
    source : where it is from
    """

    values: Mapping[str, float]
    source: str


NAMED = {
    "paper": NamedLaw(
        {"friction_law": FALLING, "falling_ratio": 0.1, "saturation_coefficient": 0.005},
        "eq. (11) and table 1 of the paper; falls with the creepage",
    ),
    "constant": NamedLaw({"friction_law": FALLING, "falling_ratio": 0.0}, "Coulomb"),
    "de-beer": NamedLaw(
        {
            "friction_law": TWO_DECAYS, "decay_ratio_a": 0.5, "decay_velocity_a": 0.138, "decay_ratio_b": 0.5,
            "decay_velocity_b": 6.9,
        },
        "Kraft's law, as used by de Beer, Janssens and Kooijman, Journal of Sound and Vibration 267 (2003) 497-507",
    ),
    "polach-dry": NamedLaw(
        {"friction_law": POLACH, "mu0": 0.55, "polach_ratio": 0.4, "polach_decay": 0.6},
        "Polach, Wear 258 (2005) 992-1000, dry",
    ),
    "polach-wet": NamedLaw(
        {"friction_law": POLACH, "mu0": 0.3, "polach_ratio": 0.4, "polach_decay": 0.2},
        "Polach, Wear 258 (2005) 992-1000, wet",
    ),
    "friction-modifier": NamedLaw(
        {
            "friction_law": TWO_DECAYS, "mu0": 0.2, "decay_ratio_a": -0.75, "decay_velocity_a": 0.1,
            "decay_ratio_b": 0.0,
        },
        "rises from 0.2 to 0.35, as Eadie, Kalousek and Chiddick, Wear 253 (2002) 185-192, describe modifiers of high "
        "positive friction; its numbers are chosen here, not measured",
    ),
}  # fmt: skip
"""Friction laws by name."""


def friction_table(abscissa: ArrayLike, friction: ArrayLike, over: str = "creepage") -> dict[str, float]:
    """Return the parameter values of a contact whose friction is a table.

    Parameters
    ----------
    abscissa : (n,) magnitudes of the creepage [-] or sliding velocities [m/s], rising, 2 to `TABLE_POINTS`
    friction : (n,) friction coefficients [-], above 0
    over : 'creepage' or 'velocity'

    Raises
    ------
    DataError
        If the points make no table; the number of the point, from 1, is in the sentence.

    Examples
    --------
    >>> values = friction_table([0.0, 0.05], [0.3, 0.25])
    >>> values["friction_law"], values["friction_abscissa_002"], values["friction_ordinate_001"]
    (3, 0.05, 0.3)
    """
    x, y = np.asarray(abscissa, dtype=float), np.asarray(friction, dtype=float)
    laws = {"creepage": TABLE_OF_CREEPAGE, "velocity": TABLE_OF_VELOCITY}
    if over not in laws:
        raise DataError(f"friction over {over!r}: must be over {' or '.join(laws)}")
    if x.shape != y.shape or x.ndim != 1:
        raise DataError(f"friction table: {over} is {x.shape}, friction {y.shape}; must be equally many")
    if not 2 <= x.size <= TABLE_POINTS:
        raise DataError(f"friction table: must have 2 to {TABLE_POINTS} points; has {x.size}")
    check_points(x, y, over, [f"friction table, point {i + 1}" for i in range(x.size)])
    points = {f"{ABSCISSA}_{i:03d}": float(value) for i, value in enumerate(x, start=1)}
    points |= {f"{ORDINATE}_{i:03d}": float(value) for i, value in enumerate(y, start=1)}
    return {"friction_law": laws[over], "friction_points": x.size, **points}


def check_points(x: ArrayLike, y: ArrayLike, over: str, places: list[str]) -> None:
    """Raise DataError at the first point that no table can have; `places` says where each point stands."""
    before = -np.inf
    for place, a, b in zip(places, np.asarray(x), np.asarray(y), strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            raise DataError(f"{place}: {over} and friction must be finite numbers; got {a:g}, {b:g}")
        if a < 0.0:
            raise DataError(f"{place}: {over} must be 0 or more, a magnitude; got {a:g}")
        if a <= before:
            raise DataError(f"{place}: {over} must rise from point to point; got {a:g} after {before:g}")
        if not 0.0 < b <= 2.0:
            raise DataError(
                f"{place}: friction must be above 0 and at most 2; got {b:g} (a traction curve begins with 0 for the "
                "creep that the contact adds itself: leave out the points before its peak)"
            )
        before = a
