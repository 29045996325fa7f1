"""Mapping transformations of connections: values by values, as SSP has them, and by the numbers of two FMUs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..errors import InputError
from ..fmi.file import Fmu, Variable
from ..fmi.instance import Value
from .model import Hop, MapTable

_FITTING = {"Boolean": ("Boolean",), "Integer": ("Integer", "Enumeration"), "Enumeration": ("Enumeration",)}
"""Types of the variables that a table of a kind is made for."""


@dataclass(frozen=True)
class Lookup:
    """What a connection does in place of a factor and an offset.

    Attributes
    ----------
    table : the whole way's, as the file has it
    numbers : the same as the FMUs count: 0 and 1, whole numbers, values of items; in pairs of output and input
    """

    table: MapTable
    numbers: tuple[tuple[int, int], ...]


def items_of(fmu: Fmu, variable: Variable) -> dict[str, int]:
    """Return the items of an enumeration with their values; none for another variable."""
    told = next((v for v in fmu.description.modelVariables if v.name == variable.array), None)
    return {item.name: int(item.value) for item in getattr(getattr(told, "declaredType", None), "items", ())}


def lookup(hops: Iterable[Hop], start: tuple[Fmu, Variable], end: tuple[Fmu, Variable], where: str) -> Lookup | None:
    """Return the table of a way from an output to an input; None if there is none on it.

    Raises
    ------
    InputError
        If the way has tables of two kinds or a linear transformation besides, if the variables are of types that the
        table is not made for, or if they do not have or hold its values.
    """
    steps = list(hops)
    tables = [hop.table for hop in steps if hop.table is not None]
    if not tables:
        return None
    whole = tables[0]
    if any(hop.declared for hop in steps) or any(table.kind != whole.kind for table in tables):
        raise InputError(f"{where}: {whole} and a transformation of another kind on one way; not supported")
    for table in tables[1:]:
        whole = whole.then(table)
    for _, variable in (start, end):
        if variable.type not in _FITTING[whole.kind]:
            raise InputError(f"{where}: {whole} is for {whole.kind}; {variable.name} is {variable.type}")
    pairs = [(_number(s, *start, where), _number(t, *end, where)) for s, t in whole.entries]
    return Lookup(whole, tuple(pairs))


def _number(value: Value, fmu: Fmu, variable: Variable, where: str) -> int:
    """Return a value of a table as the FMU counts it."""
    if isinstance(value, str):
        items = items_of(fmu, variable)
        if value not in items:
            raise InputError(f"{where}: MapEntry: {variable.name} has no item {value!r}; it has {', '.join(items)}")
        return items[value]
    number = int(value)
    bits = {"Integer": "Int32", "Enumeration": "Int64", "Boolean": "Int8"}.get(variable.fmi_type, variable.fmi_type)
    limits = np.iinfo(bits.lower())
    if not limits.min <= number <= limits.max:
        raise InputError(
            f"{where}: MapEntry: {number} is not in the range {limits.min} to {limits.max} of {variable.name}"
        )
    return number


def told(number: int, fmu: Fmu, variable: Variable) -> str:
    """Return a value of a variable in the words of the tables."""
    if variable.type == "Boolean":
        return str(bool(number)).lower()
    names = {value: name for name, value in items_of(fmu, variable).items()}
    return f"{number} ({names[number]})" if number in names else str(number)
