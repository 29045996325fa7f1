"""A system and its FMUs in, checked parameters, links and stages out. No instances, no calls.

Everything that can be wrong with a system before the first call is found here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from fmus.interface import DIRECTIONS, PAIRS, STRUCTURES

from .algorithms import Coupling
from .errors import InputError
from .fmu import Fmu, Value, Variable, open_fmu
from .system import Element, Parameter, System, Wire
from .units import conversion

CONNECTABLE = {
    *((kind, kind) for kind in ("Real", "Integer", "Boolean", "Enumeration")),
    ("Integer", "Real"), ("Enumeration", "Integer"), ("Integer", "Enumeration"),
}  # fmt: skip
"""Types of an output and of the input that it may feed."""


@dataclass(frozen=True)
class Link:
    """A checked connection of two variables: end = gain * start + offset in the units of the FMUs."""

    wire: Wire
    gain: float
    offset: float


@dataclass(frozen=True)
class Bond:
    """A pair of a force on a structure and the velocity it works on, in one direction.

    Attributes
    ----------
    direction : lon, lat, ver or spin
    force : the link that brings the force to the structure
    velocity : the link that brings the structure's velocity to the contact
    """

    direction: str
    force: Link
    velocity: Link


@dataclass(frozen=True)
class Assembly:
    """A system that is ready to be instantiated.

    Attributes
    ----------
    system : what was asked for
    fmus : by component name
    parameters : values in the FMUs' units, by component and variable name
    links : connections, one per connected input
    bonds : power bonds of the wheel/rail contract that the system has
    contact : component that takes interface mobilities, None if there is none
    """

    system: System
    fmus: Mapping[str, Fmu]
    parameters: Mapping[str, dict[str, Value]]
    links: tuple[Link, ...]
    bonds: tuple[Bond, ...]
    contact: str | None

    def coupling(self, told: Mapping[str, int] | None = None) -> Coupling:
        """Return what the master algorithms need to know of the order of stepping.

        Parameters
        ----------
        told : stages that an annotation of the system gives, by component
        """
        feeds: dict[str, set[str]] = {name: set() for name in self.fmus}
        for link in self.links:
            feeds[link.wire.end_element].add(link.wire.start_element)
        return Coupling(
            feeds={name: frozenset(sources) for name, sources in feeds.items()},
            feedthrough={name: fmu.has_feedthrough() for name, fmu in self.fmus.items()},
            told=told or {},
        )


def open_fmus(system: System) -> dict[str, Fmu]:
    """Return the FMUs of a system by component."""
    return {name: open_fmu(element.source) for name, element in system.elements.items()}


def assemble(system: System, fmus: Mapping[str, Fmu] | None = None) -> Assembly:
    """Check everything in a system against its FMUs.

    Parameters
    ----------
    fmus : the FMUs of the system, if they are open already

    Raises
    ------
    InputError
        For an unknown variable, a connection that cannot be, units that do not match, an input that nothing feeds, or
        a parameter that cannot be set.
    """
    if not system.elements:
        raise InputError(f"{system.path}: the system has no components")
    fmus = open_fmus(system) if fmus is None else fmus
    links = tuple(_link(wire, system, fmus) for wire in system.wires)
    _check_inputs(links, fmus)
    parameters = {name: _parameters(element, fmus[name]) for name, element in system.elements.items()}
    wanted = {f"mobility_{row}_{column}" for row, column in PAIRS}
    contact = next((name for name, fmu in fmus.items() if wanted <= fmu.variables.keys()), None)
    return Assembly(system, fmus, parameters, links, tuple(_bonds(links, contact)), contact)


def _known(name: str, fmu: Fmu, where: str) -> None:
    """Raise InputError unless the FMU has a variable of this name."""
    if name not in fmu.variables:
        if name in fmu.arrays:
            elements = fmu.arrays[name]
            raise InputError(f"{where}: {name} is an array; name an element, {elements[0]} to {elements[-1]}")
        close = get_close_matches(name, fmu.variables, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise InputError(f"{where}: {fmu.path.name} has no variable {name!r}{hint}")


def _link(wire: Wire, system: System, fmus: Mapping[str, Fmu]) -> Link:
    """Check one connection and find its conversion."""
    where = f"connection {wire}"
    ends = ((wire.start_element, wire.start_connector), (wire.end_element, wire.end_connector))
    for element, connector in ends:
        _known(connector, fmus[element], where)
    start = fmus[wire.start_element].variables[wire.start_connector]
    end = fmus[wire.end_element].variables[wire.end_connector]
    if start.causality not in ("output", "calculatedParameter", "parameter"):
        raise InputError(f"{where}: {wire.start_element}.{wire.start_connector} is no output but {start.causality}")
    if end.causality != "input":
        raise InputError(f"{where}: {wire.end_element}.{wire.end_connector} is no input but {end.causality}")
    if (start.type, end.type) not in CONNECTABLE:
        raise InputError(f"{where}: {start.type} cannot be connected to {end.type}")
    units = [_unit(system.elements[element], fmus[element], connector, where) for element, connector in ends]
    factor, shift = conversion(units[0], units[1], where)
    return Link(wire, wire.factor * factor, wire.factor * shift + wire.offset)


def _unit(element: Element, fmu: Fmu, connector: str, where: str) -> str | None:
    """Return the unit of a connector; what SSD and FMU say must agree."""
    own, told = fmu.unit(connector), element.units.get(connector)
    if own is not None and told is not None and own != told:
        factor, offset = conversion(told, own, f"{where}: {element.name}.{connector}, SSD against FMU")
        if (factor, offset) != (1.0, 0.0):
            raise InputError(f"{where}: {element.name}.{connector} is in {own} in the FMU and in {told} in the SSD")
    return own or told


def _check_inputs(links: tuple[Link, ...], fmus: Mapping[str, Fmu]) -> None:
    """Raise InputError for an input that nothing, or more than one output, feeds."""
    fed: set[tuple[str, str]] = set()
    for link in links:
        key = (link.wire.end_element, link.wire.end_connector)
        if key in fed:
            raise InputError(f"input {key[0]}.{key[1]} is fed by two connections")
        fed.add(key)
    for name, fmu in fmus.items():
        for variable in fmu.names("input"):
            if fmu.variables[variable].type == "Real" and (name, variable) not in fed:
                raise InputError(f"input {name}.{variable} of {fmu.path.name} is connected to nothing")


def _parameters(element: Element, fmu: Fmu) -> dict[str, Value]:
    """Return the parameter values of a component, checked and in the FMU's units."""
    values: dict[str, Value] = {}
    for name, parameter in _by_element(element, fmu):
        where = f"parameter {element.name}.{name}"
        _known(name, fmu, where)
        variable = fmu.variables[name]
        if variable.causality not in ("parameter", "input"):
            raise InputError(f"{where}: is no parameter but {variable.causality}")
        value = _convert(parameter, variable.type, fmu.unit(name), where)
        if variable.type in ("Real", "Integer"):
            _check_range(float(value), variable, f"{where} = {value:g}")
        values[name] = value
    return values


def _by_element(element: Element, fmu: Fmu) -> Iterator[tuple[str, Parameter]]:
    """Yield the parameters of a component, arrays by element; an array's value is a list or numbers in a text."""
    for name, parameter in element.parameters.items():
        if name not in fmu.arrays:
            yield name, parameter
            continue
        values = parameter.value
        parts = values.split() if isinstance(values, str) else list(np.ravel(values))
        names = fmu.arrays[name]
        if len(parts) != len(names):
            raise InputError(f"parameter {element.name}.{name}: wants {len(names)} values, got {len(parts)}")
        for each, part in zip(names, parts, strict=True):
            yield each, Parameter(part, parameter.unit)


def _check_range(value: float, variable: Variable, where: str) -> None:
    """Raise InputError if a value is not finite or outside the range that the FMU declares."""
    low = -math.inf if variable.min is None else float(variable.min)
    high = math.inf if variable.max is None else float(variable.max)
    if not math.isfinite(value) or not low <= value <= high:
        unit = f" {variable.unit}" if variable.unit not in (None, "1") else ""
        raise InputError(f"{where}: must be in the range {low:g} to {high:g}{unit}")


def _convert(parameter: Parameter, kind: str, unit: str | None, where: str) -> Value:
    """Return a value as the type of the variable wants it."""
    value = parameter.value
    if kind == "String":
        return str(value)
    if kind == "Boolean":
        words = {"true": True, "1": True, "false": False, "0": False}
        found = words.get(str(value).lower())
        if found is None:
            raise InputError(f"{where} = {value}: must be true or false")
        return found
    try:
        number = float(value)
    except ValueError:
        raise InputError(f"{where} = {value}: must be a number") from None
    if kind in ("Integer", "Enumeration"):
        if number != int(number):
            raise InputError(f"{where} = {value}: must be a whole number")
        return int(number)
    factor, offset = conversion(parameter.unit, unit, where)
    return factor * number + offset


def _bonds(links: tuple[Link, ...], contact: str | None) -> list[Bond]:
    """Return the power bonds between structures and the contact, by the contract's names at the contact."""
    if contact is None:
        return []
    out = {link.wire.start_connector: link for link in links if link.wire.start_element == contact}
    into = {link.wire.end_connector: link for link in links if link.wire.end_element == contact}
    return [
        Bond(d, out[f"{s}_f_{d}"], into[f"{s}_v_{d}"])
        for s in STRUCTURES
        for d in DIRECTIONS
        if f"{s}_f_{d}" in out and f"{s}_v_{d}" in into
    ]
