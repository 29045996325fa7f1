"""Parameter and start values of a component, checked against its FMU and in the FMU's units."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches

from fmpy.model_description import ScalarVariable

from .errors import InputError
from .fmu import Fmu, Value
from .system import Element, Hop, Parameter
from .units import BASE_UNITS, Unit, conversion, unit_name

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
    close = get_close_matches(name, fmu.variables, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    return f"{fmu.path.name} has no variable {name!r}{hint}"


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
    notices = []
    for name, parameter in element.parameters.items():
        if name not in fmu.variables and parameter.origin is not None:
            notices.append(f"{parameter.origin}: not applied to {element.name}: {_unknown(name, fmu)}")
            continue
        where = f"parameter {element.name}.{name}"
        where += f" ({parameter.origin})" if parameter.origin else ""
        known(name, fmu, where)
        variable = fmu.variables[name]
        if variable.causality not in ("parameter", "input", "structuralParameter") and (
            variable.initial not in _SETTABLE or variable.variability == "constant"
        ):
            raise InputError(f"{where}: is no parameter but {variable.causality}")
        values[name] = _convert(parameter, variable, variable_unit(element, fmu, name, where), where)
        if isinstance(values[name], int | float):
            _check_range(float(values[name]), variable, f"{where} = {values[name]:g}")
    return Values(values, tuple(notices))


def variable_unit(element: Element, fmu: Fmu, name: str, where: str) -> Unit | str | None:
    """Return the unit of a variable; what SSD and FMU say must agree."""
    own, told = own_unit(fmu, name), element.connectors[name].unit if name in element.connectors else None
    if own and told:
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


def _check_range(value: float, variable: ScalarVariable, where: str) -> None:
    """Raise InputError if a value is not finite or outside the range that the FMU declares."""
    low = -math.inf if variable.min is None else float(variable.min)
    high = math.inf if variable.max is None else float(variable.max)
    if not math.isfinite(value) or not low <= value <= high:
        unit = f" {variable.unit}" if variable.unit not in (None, "1") else ""
        raise InputError(f"{where}: must be in the range {low:g} to {high:g}{unit}")


def _convert(parameter: Parameter, variable: ScalarVariable, unit: Unit | str | None, where: str) -> Value:
    """Return a value as the type of the variable wants it, after its way."""
    value, kind = parameter.value, variable.type
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
    if kind == "Enumeration" and isinstance(value, str):
        items = {item.name: int(item.value) for item in getattr(variable.declaredType, "items", ())}
        if value in items:
            return items[value]
    number = _number(value, where)
    if not number.is_integer():
        raise InputError(f"{where} = {value}: must be a whole number")
    return int(number)


def _number(value: Value, where: str) -> float:
    try:
        return float(value)
    except ValueError:
        raise InputError(f"{where} = {value}: must be a number") from None
