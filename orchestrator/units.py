"""Conversion between units of measurement: by the definitions that the files give, else by the library pint."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from .errors import InputError

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
"""Base units that SSP and FMI express every unit in."""

_PINT_NAMES = dict(
    zip(
        ("kilogram", "meter", "second", "ampere", "kelvin", "mole", "candela", "radian"),
        BASE_UNITS,
        strict=True,
    )
)


@dataclass(frozen=True)
class Unit:
    """A unit that a file defines: value in base units = factor * value + offset.

    Attributes
    ----------
    name : as the files write it
    dimension : base units with their exponents, without zeros, sorted
    factor, offset : to the base units
    """

    name: str
    dimension: tuple[tuple[str, float], ...]
    factor: float = 1.0
    offset: float = 0.0

    @classmethod
    def of(cls, name: str, exponents: Mapping[str, float], factor: float = 1.0, offset: float = 0.0) -> Unit:
        """Return a unit from exponents of base units."""
        return cls(name, tuple(sorted((k, float(v)) for k, v in exponents.items() if v)), factor, offset)


def conversion(given: Unit | str | None, wanted: Unit | str | None, where: str) -> tuple[float, float]:
    """Return factor and offset that turn a value in unit `given` into one in unit `wanted`.

    Equal names, or a unit that is not told, need no conversion. A plane angle counts as a number, but an angular
    velocity (rad/s) is no frequency (1/s).

    Raises
    ------
    InputError
        If the units do not match; `where` begins the message.
    """
    if not given or not wanted or unit_name(given) == unit_name(wanted):
        return 1.0, 0.0
    names = f"{unit_name(given)} to {unit_name(wanted)}"
    try:
        source, target = (u if isinstance(u, Unit) else _known_unit(u) for u in (given, wanted))
    except ValueError as error:
        raise InputError(f"{where}: cannot convert {names}: {error}") from None
    if source.dimension != target.dimension and not _are_numbers(source, target):
        raise InputError(f"{where}: the units do not match: {source.name} cannot become {target.name}")
    return source.factor / target.factor, (source.offset - target.offset) / target.factor


def unit_name(unit: Unit | str) -> str:
    """Return the name of a unit."""
    return unit.name if isinstance(unit, Unit) else unit


def find_unit(name: str) -> Unit | None:
    """Return the definition of a unit that pint knows by this name, None if it knows none."""
    try:
        return _known_unit(name)
    except ValueError:
        return None


def _are_numbers(*units: Unit) -> bool:
    return all(set(dict(unit.dimension)) <= {"rad"} for unit in units)


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # noqa: PLC0415 - slow to import, and most systems need no conversion

    return UnitRegistry()


@cache
def _known_unit(name: str) -> Unit:
    """Return the definition of a unit by its name; `N.m` and `m/s2` are read as FMI writes them.

    Raises
    ------
    ValueError
        If there is no such unit, or it is not linear in the base units.
    """
    text = "1" if name == "-" else re.sub(r"(?<=[A-Za-z])(-?\d+)", r"**\1", name.replace(".", "*"))
    try:
        unit = _registry().Unit(text)
        quantities = [_registry().Quantity(x, unit).to_base_units() for x in (0.0, 1.0, 2.0)]
    except Exception as error:  # pint parses by Python's tokeniser and lets pass whatever that raises
        raise ValueError(str(error) or f"{name!r} is no unit") from None
    zero, one, two = (float(quantity.magnitude) for quantity in quantities)
    if abs(two - 2 * one + zero) > 1e-9 * abs(two - zero):
        raise ValueError(f"{name} is no linear unit")
    exponents = {_PINT_NAMES.get(base, base): float(power) for base, power in quantities[0].unit_items()}
    return Unit.of(name, exponents, one - zero, zero)
