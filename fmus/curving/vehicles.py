"""Vehicles as data: a TOML file in, the parameters of the vehicle component out.

Each number is a table `[name]` with `value`, `unit` and `source`; the source is "assumed" where none is known.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

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
    try:
        settings = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{path.name}: not a TOML file: {error}") from None
    title = settings.pop("title", None)
    if not isinstance(title, str) or not title.strip():
        raise DataError(f"{path.name}: title must be a text; got {title!r}")
    wanted = {v.name: v for v in VEHICLE}
    for problem, names in (("is unknown", set(settings) - set(wanted)), ("is missing", set(wanted) - set(settings))):
        if names:
            raise DataError(f"{path.name}: {min(names)!r} {problem}; wanted are {', '.join(wanted)}")
    values = {name: _value(settings[name], name, wanted[name].unit, path.name) for name in wanted}
    for name, value in values.items():
        try:
            wanted[name].check(value)
        except ValueError as error:
            raise DataError(f"{path.name}: {error}") from None
    return Vehicle(title, values, {name: settings[name]["source"] for name in wanted})


def _value(entry: Any, name: str, unit: str, where: str) -> float:
    """Return the number of one table."""
    if not isinstance(entry, dict) or set(entry) != {"value", "unit", "source"}:
        raise DataError(f"{where}: [{name}] must have value, unit and source; got {entry!r}")
    value, source = entry["value"], entry["source"]
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise DataError(f"{where}: {name} must be a number; got {value!r}")
    if entry["unit"] != unit:
        raise DataError(f"{where}: {name} must be in {unit}; got {entry['unit']!r}")
    if not isinstance(source, str) or not source.strip():
        raise DataError(f"{where}: {name} must have a text as source ('assumed' if there is none); got {source!r}")
    return float(value)
