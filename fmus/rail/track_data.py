"""What a track is made of: track data files (TOML) in, checked `Track` out. No mechanics.

In a file every number is a table `{ value = 60.0, unit = "kg/m", source = "..." }`; the unit must be the one of the
attribute, and the source a text, so that no number comes without saying where from.
"""

from __future__ import annotations

import math
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from typing import Any

from ..data_file import read_settings, sourced_number, title_of
from ..errors import DataError

TRACKS = Path(__file__).parent / "data" / "tracks"

LARGEST_RAIL_LOSS = 0.5
LARGEST_SUPPORT_LOSS = 2.0
"""Loss factors beyond these are no material's: steel has 0.02 with all its joints, pads 0.1 to 0.5, ballast 1 to 2."""

LATERAL_MODELS = ("torsion", "bending")

_MAY_BE_ZERO = frozenset({"warping_constant", "pad_loss_factor", "ballast_loss_factor"})


def _quantity(unit: str, **more: Any) -> Any:
    """Return a dataclass field that knows its unit."""
    return field(metadata={"unit": unit}, **more)


@dataclass(frozen=True)
class Section:
    """A rail's cross-section and material, symmetric about its vertical axis.

    Attributes
    ----------
    bending_stiffness_ver, bending_stiffness_lat : E I of vertical and lateral bending [N.m2]
    shear_coefficient_ver, shear_coefficient_lat : Timoshenko's kappa [-]
    torsion_constant : J of St Venant [m4]
    polar_moment : second polar moment of area about the centroid [m4]
    warping_constant : [m6]
    head_height, foot_depth : from the centroid up to the contact and down to the pad [m]
    foot_width : width on the pad [m]
    loss_factor : hysteretic, of all elastic moduli [-]; > 0, so that no wave goes on for ever
    """

    mass_per_length: float = _quantity("kg/m")
    young_modulus: float = _quantity("Pa")
    shear_modulus: float = _quantity("Pa")
    area: float = _quantity("m2")
    bending_stiffness_ver: float = _quantity("N.m2")
    bending_stiffness_lat: float = _quantity("N.m2")
    shear_coefficient_ver: float = _quantity("1")
    shear_coefficient_lat: float = _quantity("1")
    torsion_constant: float = _quantity("m4")
    polar_moment: float = _quantity("m4")
    warping_constant: float = _quantity("m6")
    head_height: float = _quantity("m")
    foot_depth: float = _quantity("m")
    foot_width: float = _quantity("m")
    loss_factor: float = _quantity("1")

    def __post_init__(self) -> None:
        """Check the ranges."""
        _check_positive(self, "rail")
        _check_loss(self.loss_factor, "rail: loss_factor", LARGEST_RAIL_LOSS)

    @property
    def density(self) -> float:
        """Mass per volume [kg/m3]."""
        return self.mass_per_length / self.area


@dataclass(frozen=True)
class Support:
    """The support of one rail at one sleeper in one direction; without ballast the pad stands on rigid ground.

    Attributes
    ----------
    pad_stiffness, pad_loss_factor : [N/m], [-]
    ballast_stiffness, ballast_loss_factor : [N/m], [-]; stiffness None where there is neither sleeper nor ballast
    """

    pad_stiffness: float = _quantity("N/m")
    pad_loss_factor: float = _quantity("1")
    ballast_stiffness: float | None = _quantity("N/m", default=None)
    ballast_loss_factor: float = _quantity("1", default=0.0)

    def __post_init__(self) -> None:
        """Check the ranges."""
        _check_positive(self, "support")
        _check_loss(self.pad_loss_factor, "support: pad_loss_factor", LARGEST_SUPPORT_LOSS)
        _check_loss(self.ballast_loss_factor, "support: ballast_loss_factor", LARGEST_SUPPORT_LOSS)


@dataclass(frozen=True)
class Track:
    """A rail on periodic supports.

    Attributes
    ----------
    lon, lat, ver : the support in each direction
    spacing : distance of the sleepers [m]
    sleeper_mass : of the half sleeper under one rail [kg]; 0 without sleepers
    contact_offset : lateral position of the contact on the rail's head, positive to the gauge side [m]
    lateral_model : 'torsion' for bending with torsion, 'bending' for the Timoshenko beam alone
    """

    title: str
    section: Section
    lon: Support
    lat: Support
    ver: Support
    spacing: float = _quantity("m")
    sleeper_mass: float = _quantity("kg", default=0.0)
    contact_offset: float = _quantity("m", default=0.0)
    lateral_model: str = "torsion"

    def __post_init__(self) -> None:
        """Check the ranges."""
        layered = [s.ballast_stiffness is not None for s in (self.lon, self.lat, self.ver)]
        if any(layered) != all(layered) or any(layered) != (self.sleeper_mass > 0):
            raise DataError(
                f"{self.title}: sleeper_mass = {self.sleeper_mass:g} kg and ballast in {sum(layered)} of 3 directions; "
                "must be a mass > 0 and ballast in all of them, or neither"
            )
        if not 0 < self.spacing < math.inf:
            raise DataError(f"{self.title}: spacing = {self.spacing:g} m; must be > 0")
        if not abs(self.contact_offset) <= 0.05:
            raise DataError(
                f"{self.title}: contact_offset = {self.contact_offset:g} m; must be on the head, within 0.05"
            )
        if self.lateral_model not in LATERAL_MODELS:
            raise DataError(f"{self.title}: lateral_model = {self.lateral_model!r}; must be one of {LATERAL_MODELS}")


def read_track(path: Path) -> Track:
    """Return the track that a file such as `data/tracks/default.toml` describes.

    Raises
    ------
    DataError
        One sentence with file, quantity, what was wanted and what came.
    """
    settings = read_settings(path)
    try:
        return _track(settings)
    except ValueError as error:
        raise DataError(f"{path.name}: {error}") from None


def _track(settings: dict[str, Any]) -> Track:
    """Return the track of a file's settings."""
    title, lateral_model = title_of(settings), settings.pop("lateral_model", "torsion")
    section = Section(**_numbers(settings.pop("rail", {}), Section, "rail"))
    support = settings.pop("support", {})
    if not isinstance(support, dict):
        raise DataError(f"support must be a table; got {support!r}")
    lon, lat, ver = (_support(support.pop(d, {}), d) for d in ("lon", "lat", "ver"))
    own = _numbers({**support, **settings}, Track, "support")
    return Track(title, section, lon, lat, ver, lateral_model=lateral_model, **own)


def _support(table: Any, direction: str) -> Support:
    """Return the support in one direction; messages name it."""
    numbers = _numbers(table, Support, f"support.{direction}")
    try:
        return Support(**numbers)
    except ValueError as error:
        raise DataError(f"{direction} {error}") from None


def _numbers(table: Any, of: type, where: str) -> dict[str, float]:
    """Return the numbers of a table, one for each field of `of` that has a unit."""
    if not isinstance(table, dict):
        raise DataError(f"{where} must be a table; got {table!r}")
    known: dict[str, Field[Any]] = {f.name: f for f in fields(of) if "unit" in f.metadata}
    unknown = sorted(set(table) - set(known))
    if unknown:
        raise DataError(f"{where}.{unknown[0]} is unknown; must be one of {', '.join(known)}")
    missing = [name for name, f in known.items() if f.default is MISSING and name not in table]
    if missing:
        raise DataError(f"{where}.{missing[0]} is missing")
    return {
        name: sourced_number(entry, known[name].metadata["unit"], f"{where}.{name}") for name, entry in table.items()
    }


def _check_positive(data: Section | Support, what: str) -> None:
    """Raise for a quantity that is not positive, or where it may be zero, negative."""
    for f in fields(data):
        value = getattr(data, f.name)
        if value is None:
            continue
        allowed = value >= 0 if f.name in _MAY_BE_ZERO else value > 0
        if not (allowed and math.isfinite(value)):
            bound = ">= 0" if f.name in _MAY_BE_ZERO else "> 0"
            raise DataError(f"{what}: {f.name} = {value:g} {f.metadata['unit']}; must be {bound}")


def _check_loss(value: float, what: str, largest: float) -> None:
    """Raise for a loss factor that no material has."""
    if value > largest:
        raise DataError(f"{what} = {value:g}; must be at most {largest:g}")
