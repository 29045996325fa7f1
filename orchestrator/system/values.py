"""Parameter and start values of a component, checked against its FMU and in the FMU's units."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches

import numpy as np

from ..errors import InputError
from ..fmi.instance import Fmu, Value, Variable
from ..units import BASE_UNITS, Unit, conversion, unit_name
from .model import Element, Hop, Parameter

_SETTABLE = ("exact", "approx")
"""Values of `initial` with which FMI lets a start value be set."""


@dataclass(frozen=True)
class Values:
    """Values to set before a component is initialised.

    Attributes
    ----------
    values : in the FMU's units, by variable name
    notices : what was passed over, as the standard wants it
    """

    values: dict[str, Value]
    notices: tuple[str, ...]


def known(name: str, fmu: Fmu, where: str) -> None:
    """Raise InputError unless the FMU has a variable of this name."""
    if name not in fmu.variables:
        raise InputError(f"{where}: {_unknown(name, fmu)}")


def _unknown(name: str, fmu: Fmu) -> str:
    array = elements_of(name, fmu)
    if array:
        return f"{name} is an array; name an element, {array[0]} to {array[-1]}"
    same = [v for v in fmu.variables if v.lower() == name.lower()]
    close = same or get_close_matches(name, fmu.variables, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{fmu.path.name} has no variable {name!r}{hint}"


def elements_of(name: str, fmu: Fmu) -> list[str]:
    """Return the names of an array's elements, row by row; none for another variable."""
    arrays: dict[str, list[str]] = getattr(fmu, "arrays", {})
    return arrays.get(name, [])


def resized(element: Element, fmu: Fmu) -> Fmu:
    """Return the FMU of a component with the sizes that its structural parameters are given."""
    sizes: dict[str, int] = {}
    for name, parameter in element.parameters.items():
        variable = fmu.variables.get(name)
        if variable is not None and variable.causality == "structuralParameter":
            where = f"parameter {element.name}.{name}" + (f" ({parameter.origin})" if parameter.origin else "")
            value = _convert(parameter, variable.type, None, {}, where)
            _check_range(float(value), (variable.min or "1", variable.max), None, f"{where} = {value}")
            sizes[name] = int(value)
    return fmu.resized(sizes) if sizes else fmu


def component_values(element: Element, fmu: Fmu) -> Values:
    """Return the values of a component.

    A value of a file's parameter set for a variable that the FMU does not have is passed over with a notice, because
    SSP lets components share parameter sets; one that the user gives is an error.

    Raises
    ------
    InputError
        For a value that cannot be set.
    """
    values: dict[str, Value] = {}
    holders: dict[tuple[str, int, int], str] = {}
    notices = []
    declared = {variable.name: variable for variable in fmu.description.modelVariables}
    for name, parameter in _by_element(element, fmu):
        if name not in fmu.variables and parameter.origin is not None:
            if element.replaced:
                continue  # it was for the FMU that stood here
            notices.append(f"{parameter.origin}: not applied to {element.name}: {_unknown(name, fmu)}")
            continue
        where = f"parameter {element.name}.{name}"
        where += f" ({parameter.origin})" if parameter.origin else ""
        known(name, fmu, where)
        variable, told = fmu.variables[name], declared.get(name)
        if variable.causality == "structuralParameter":
            continue  # `resized` has it
        settable = told is not None and told.initial in _SETTABLE and told.variability != "constant"
        if variable.causality not in ("parameter", "input") and not settable:
            raise InputError(f"{where}: is no parameter but {variable.causality}")
        items = {item.name: int(item.value) for item in getattr(getattr(told, "declaredType", None), "items", ())}
        value = _convert(parameter, variable.type, variable_unit(element, fmu, name, where), items, where)
        if isinstance(value, int | float):
            unit = fmu.unit(name)
            _check_range(float(value), (variable.min, variable.max), unit, f"{where} = {value:g}")
            _check_type(value, variable, where)
        other = holders.setdefault(variable.place, name)
        if other != name and values[other] != value:
            raise InputError(
                f"{where} = {value}: is one variable with {other} (value reference {variable.valueReference}), "
                f"which is given {values[other]}"
            )
        values[name] = value
    return Values(values, tuple(notices))


def _by_element(element: Element, fmu: Fmu) -> Iterator[tuple[str, Parameter]]:
    """Yield the values of a component, arrays by element, row by row: numbers in a text or an array-like.

    Raises
    ------
    InputError
        If an array is given another number of values than it has elements.
    """
    for name, parameter in element.parameters.items():
        value, names = parameter.value, elements_of(name, fmu)
        if not names:
            yield name, parameter
            continue
        parts = value.split() if isinstance(value, str) else np.ravel(value).tolist()
        if len(parts) != len(names):
            raise InputError(f"parameter {element.name}.{name}: wants {len(names)} values, got {len(parts)}")
        for each, part in zip(names, parts, strict=True):
            yield each, replace(parameter, value=part)


def variable_unit(element: Element, fmu: Fmu, name: str, where: str) -> Unit | str | None:
    """Return the unit of a variable, an element of an array too; what SSD and FMU say must agree."""
    connector = element.connectors.get(name) or element.connectors.get(name.partition("[")[0])
    own, told = own_unit(fmu, name), connector.unit if connector is not None else None
    if own and told and not element.replaced:
        factor, offset = conversion(told, own, f"{where}: {element.name}.{name}, SSD against FMU")
        if (factor, offset) != (1.0, 0.0):
            raise InputError(
                f"{where}: {element.name}.{name} is in {unit_name(own)} in the FMU and in {unit_name(told)} in the SSD"
            )
    return own or told


def own_unit(fmu: Fmu, name: str) -> Unit | str | None:
    """Return the unit that an FMU gives a variable, with the FMU's definition if it has one."""
    told = fmu.unit(name)
    for unit in fmu.description.unitDefinitions:
        if unit.name == told and unit.baseUnit is not None:
            base = unit.baseUnit
            exponents = {key: int(getattr(base, key)) for key in BASE_UNITS}
            return Unit.of(unit.name, exponents, float(base.factor), float(base.offset))
    return told


def through(hops: Iterable[Hop], start: Unit | str | None, end: Unit | str | None, where: str) -> tuple[float, float]:
    """Return gain and offset of a way: result = gain * value + offset.

    Parameters
    ----------
    hops : the way
    start, end : units at its ends
    where : begins the message if units do not match
    """
    gain, offset, unit = 1.0, 0.0, start
    steps = list(hops)
    for place, hop in enumerate(steps, 1):
        target = end if place == len(steps) else hop.unit
        factor, shift = conversion(unit, target, where) if hop.convert else (1.0, 0.0)
        gain, offset = hop.factor * (factor * gain), hop.factor * (factor * offset + shift) + hop.offset
        unit = target or unit
    return gain, offset


def _check_range(value: float, limits: tuple[str | None, str | None], unit: str | None, where: str) -> None:
    """Raise InputError if a value is not finite or outside the range that the FMU declares."""
    low = -math.inf if limits[0] is None else float(limits[0])
    high = math.inf if limits[1] is None else float(limits[1])
    if not math.isfinite(value) or not low <= value <= high:
        told = f" {unit}" if unit not in (None, "1") else ""
        raise InputError(f"{where}: must be in the range {low:g} to {high:g}{told}")


def _check_type(value: float, variable: Variable, where: str) -> None:
    """Raise InputError if a whole number does not fit into the FMU's type."""
    bits = {"Integer": "Int32", "Enumeration": "Int64"}.get(variable.fmi_type, variable.fmi_type)
    if "Int" not in bits:
        return
    limits = np.iinfo(bits.lower())
    if not limits.min <= value <= limits.max:
        raise InputError(f"{where} = {value}: must be in the range {limits.min} to {limits.max} of {variable.fmi_type}")


def _convert(parameter: Parameter, kind: str, unit: Unit | str | None, items: dict[str, int], where: str) -> Value:
    """Return a value as the type of the variable wants it, after its way.

    Parameters
    ----------
    parameter : the value as given
    kind, unit : type and unit of the variable
    items : of an enumeration, by name
    where : begins messages
    """
    value = parameter.value
    table = next((hop.table for hop in parameter.hops if hop.table is not None), None)
    if table is not None:
        raise InputError(f"{where}: {table} of a connection that brings a start value; not supported")
    if kind in ("Real", "Float64", "Float32"):
        gain, offset = through(parameter.hops, parameter.unit, unit, where)
        return gain * _number(value, where) + offset
    if any((hop.factor, hop.offset) != (1.0, 0.0) for hop in parameter.hops):
        raise InputError(f"{where}: a LinearTransformation of a value of type {kind}")
    if kind == "String":
        return str(value)
    if kind == "Boolean":
        words = {"true": True, "1": True, "false": False, "0": False}
        found = words.get(str(value).lower())
        if found is None:
            raise InputError(f"{where} = {value}: must be true or false")
        return found
    if kind == "Enumeration" and value in items:
        return items[str(value)]
    if kind == "Enumeration" and isinstance(value, str) and not value.lstrip("+-").isdecimal():
        raise InputError(f"{where} = {value}: must be one of {', '.join(items)}")
    number = _number(value, where)
    if not number.is_integer():
        raise InputError(f"{where} = {value}: must be a whole number")
    text = str(value).strip()
    return int(text) if text.lstrip("+-").isdecimal() else int(number)


def _number(value: Value, where: str) -> float:
    try:
        if not isinstance(value, bool):
            return float(value)
    except ValueError:
        pass
    raise InputError(f"{where} = {value}: must be a number")
