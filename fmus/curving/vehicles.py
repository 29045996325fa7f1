"""Vehicles as data: a TOML file in, the parameters of the vehicle component out.

Each number is a table `[name]` with `value`, `unit` and `source`; the source is "assumed" where none is known.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..data_file import read_settings, sourced_number, title_of
from ..errors import DataError
from .parameters import VEHICLE

VEHICLES = Path(__file__).parent / "data" / "vehicles"


@dataclass(frozen=True)
class Vehicle:
    """A two-axle bogie.

    Attributes
    ----------
    title : which one
    parameters : by the names of the component's parameters, SI units
    sources : where each number comes from
    """

    title: str
    parameters: Mapping[str, float]
    sources: Mapping[str, str]


def vehicle_names() -> list[str]:
    """Return the names of the vehicles that are shipped."""
    return sorted(path.stem for path in VEHICLES.glob("*.toml"))


def read_vehicle(path: Path) -> Vehicle:
    """Return the vehicle of a file such as `data/vehicles/reference.toml`.

    Raises
    ------
    DataError
        One sentence with file, quantity, what was wanted and what came.
    """
    settings = read_settings(path)
    try:
        return _vehicle(settings)
    except ValueError as error:
        raise DataError(f"{path.name}: {error}") from None


def _vehicle(settings: dict[str, Any]) -> Vehicle:
    """Return the vehicle of a file's settings."""
    title = title_of(settings)
    wanted = {v.name: v for v in VEHICLE}
    for problem, names in (("is unknown", set(settings) - set(wanted)), ("is missing", set(wanted) - set(settings))):
        if names:
            raise DataError(f"{min(names)!r} {problem}; wanted are {', '.join(wanted)}")
    values = {name: sourced_number(settings[name], wanted[name].unit, name) for name in wanted}
    for name, value in values.items():
        wanted[name].check(value)
    return Vehicle(title, values, {name: settings[name]["source"] for name in wanted})
