"""Conversion between units of measurement, by the library pint."""

from __future__ import annotations

from functools import cache
from typing import Any

from .errors import InputError


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # noqa: PLC0415 - slow to import, and most systems need no conversion

    return UnitRegistry()


def conversion(given: str | None, wanted: str | None, where: str) -> tuple[float, float]:
    """Return factor and offset that turn a value in unit `given` into one in unit `wanted`.

    Equal names, or a unit that is not told, need no conversion.

    Raises
    ------
    InputError
        If the units do not match; `where` begins the message.
    """
    if given is None or wanted is None or given == wanted:
        return 1.0, 0.0
    from pint import DimensionalityError, UndefinedUnitError  # noqa: PLC0415

    try:
        source, target = (_registry().Unit(name.replace(".", "*")) for name in (given, wanted))
        zero = _registry().Quantity(0.0, source).to(target).magnitude
        one = _registry().Quantity(1.0, source).to(target).magnitude
    except DimensionalityError:
        raise InputError(f"{where}: the units do not match: {given} cannot become {wanted}") from None
    except (UndefinedUnitError, ValueError, TypeError, AssertionError) as error:
        raise InputError(f"{where}: cannot convert {given} to {wanted}: {error}") from None
    return one - zero, zero
