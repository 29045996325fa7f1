"""A system and its FMUs in, checked parameters, links and stages out. No instances, no calls.

Everything that can be wrong with a system before the first call is found here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from fmus.interface import CHANGE, DIRECTIONS, DISPLACEMENT_DIRECTIONS, PAIRS

from ..errors import InputError
from ..fmi.instance import Fmu, Value, open_fmu
from ..fmi.types import plain_type
from ..system.model import Element, System, Wire
from ..system.tables import lookup
from ..system.values import component_values, elements_of, known, resized, through, variable_unit
from .bonds import Bond, Link, _bonds, integrated_sides
from .dependencies import Coupling, Node
from .rates import period
from .swaps import without_rigid

CONNECTABLE = {
    *((kind, kind) for kind in ("Real", "Integer", "Boolean", "Enumeration")),
    ("Integer", "Real"), ("Enumeration", "Integer"), ("Integer", "Enumeration"), ("String", "String"),
}  # fmt: skip
"""Types of an output and of the input that it may feed."""


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
    notices : what a user should know before a run, one sentence each
    outputs : outputs of the system itself, each with its conversion from a component's
    integrated : wheel, rail or both: sides that give no displacements, so that the contact integrates their velocities
    """

    system: System
    fmus: Mapping[str, Fmu]
    parameters: Mapping[str, dict[str, Value]]
    links: tuple[Link, ...]
    bonds: tuple[Bond, ...]
    contact: str | None
    notices: tuple[str, ...] = ()
    outputs: tuple[Link, ...] = ()
    integrated: tuple[str, ...] = ()

    def integration(self) -> dict[str, Value]:
        """Return the parameters that make the contact integrate the velocities of a side."""
        return {f"integrate_{side}": True for side in self.integrated}

    @cached_property
    def coupling(self) -> Coupling:
        """What the master algorithms need to know."""
        feeds: dict[str, set[str]] = {name: set() for name in self.fmus}
        sources: dict[str, dict[str, set[tuple[str, str]]]] = {name: {} for name in self.fmus}
        for link in self.links:
            wire = link.wire
            feeds[wire.end_element].add(wire.start_element)
            array = self.fmus[wire.end_element].variables[wire.end_connector].array
            start = self.fmus[wire.start_element].variables[wire.start_connector].array
            sources[wire.end_element].setdefault(array, set()).add((wire.start_element, start))
        nodes: dict[tuple[str, str], Node] = {}
        groups: dict[Node, frozenset[str] | None] = {}
        for name, fmu in self.fmus.items():
            numbers: dict[frozenset[str] | None, int] = {}
            for output, inputs in fmu.dependencies().items():
                node = (name, numbers.setdefault(inputs, len(numbers)))
                nodes[name, output] = node
                groups[node] = inputs
        needs = {}
        for node, inputs in groups.items():
            fed = sources[node[0]]
            outputs = [o for i in (fed if inputs is None else inputs & fed.keys()) for o in fed[i]]
            needs[node] = frozenset(nodes[o] for o in outputs if o in nodes)
        return Coupling(
            feeds={name: frozenset(found) for name, found in feeds.items()},
            needs=needs,
            silent=frozenset(node for node, inputs in groups.items() if inputs is None and needs[node]),
            told=self.system.stages,
            repeatable=frozenset(name for name, fmu in self.fmus.items() if fmu.can_roll_back),
        )

    def periods(self, step: float) -> dict[str, int]:
        """Return how many communication steps [s] one step of each component takes."""
        return {name: period(name, self.system.elements[name].step, step) for name in self.fmus}


def open_fmus(system: System) -> dict[str, Fmu]:
    """Return the FMUs of a system by component."""
    files = {source: open_fmu(source) for source in dict.fromkeys(e.source for e in system.elements.values())}
    return {name: files[element.source] for name, element in system.elements.items()}


def assemble(system: System, fmus: Mapping[str, Fmu] | None = None) -> Assembly:
    """Check everything in a system against its FMUs.

    An input that nothing feeds keeps its start value, as SSP and FMI have it; a notice says so unless the system or the
    user gives the value.

    Parameters
    ----------
    fmus : the FMUs of the system, if they are open already

    Raises
    ------
    InputError
        For an unknown variable, a connection that cannot be, units that do not match, or a parameter that cannot be
        set.
    """
    if not system.elements:
        raise InputError(f"{system.path}: the system has no components")
    fmus = open_fmus(system) if fmus is None else fmus
    fmus = {name: resized(element, fmus[name]) for name, element in system.elements.items()}
    for name, element in system.elements.items():
        _check_connectors(element, fmus[name])
    wires, rigid = without_rigid(system, fmus)
    links = tuple(_link(wire, system, fmus) for whole in wires for wire in _by_element(whole, fmus))
    _check_inputs(links, fmus)
    _check_tables(links, fmus)
    values = {name: component_values(element, fmus[name]) for name, element in system.elements.items()}
    parameters = {name: v.values for name, v in values.items()}
    passed_over = (notice for v in values.values() for notice in v.notices)
    wanted = {f"mobility_{row}_{column}" for row, column in PAIRS}
    contact = next((name for name, fmu in fmus.items() if wanted <= fmu.variables.keys()), None)
    integrated = () if contact is None else integrated_sides(links, contact, fmus[contact], parameters[contact].keys())
    faults = {f for fmu in fmus.values() for f in fmu.faults}
    left = {(w.end_element, w.end_connector) for w in set(system.wires) - set(wires)}
    told = [end for end in left if end[1] in fmus[end[0]].variables]
    notices = (*system.notices, *sorted(faults), *rigid, *passed_over)
    notices += tuple(_held_inputs(links, fmus, parameters, [*_passed_over(contact, integrated), *told]))
    notices += tuple(f"{s} gives no displacements; the contact integrates its velocities" for s in integrated)
    outputs = tuple(_output(wire, system, fmus) for wire in system.outputs)
    return Assembly(
        system, fmus, parameters, links, tuple(_bonds(links, contact)), contact, notices, outputs, integrated
    )


def _check_connectors(element: Element, fmu: Fmu) -> None:
    """Raise InputError if the SSD says of a connector what is not true of the FMU's variable."""
    for name, connector in element.connectors.items():
        if name not in fmu.variables:
            continue  # another FMU may stand here; a connection to it is refused
        variable = fmu.variables[name]
        if connector.kind not in (variable.causality, "inout", "unspecified"):
            said = f"is {connector.kind} in the SSD and {variable.causality} in the FMU"
            if element.replaced and name in {f"{kind}_{d}" for kind in "fv" for d in DIRECTIONS}:
                said += "; a structure must take forces and give velocities"
            raise InputError(f"connector {element.name}.{name}: {said}")
        told, own = (plain_type(str(t)) for t in (connector.type, variable.type))
        if connector.type is not None and told != own:
            raise InputError(
                f"connector {element.name}.{name}: is {connector.type} in the SSD and {variable.type} in the FMU"
            )


def _by_element(wire: Wire, fmus: Mapping[str, Fmu]) -> Iterable[Wire]:
    """Return the connections of the elements of two arrays of one shape, or the connection itself."""
    start = elements_of(wire.start_connector, fmus[wire.start_element])
    end = elements_of(wire.end_connector, fmus[wire.end_element])
    if not start or not end:
        return [wire]
    if [n.removeprefix(wire.start_connector) for n in start] != [n.removeprefix(wire.end_connector) for n in end]:
        raise InputError(f"connection {wire}: {start[0]} to {start[-1]} on {end[0]} to {end[-1]}; shapes must agree")
    pairs = zip(start, end, strict=True)
    return [replace(wire, start_connector=s, end_connector=e) for s, e in pairs]


def _link(wire: Wire, system: System, fmus: Mapping[str, Fmu]) -> Link:
    """Check one connection and find its conversion."""
    where = f"connection {wire}"
    ends = ((wire.start_element, wire.start_connector), (wire.end_element, wire.end_connector))
    for element, connector in ends:
        known(connector, fmus[element], where)
    start = fmus[wire.start_element].variables[wire.start_connector]
    end = fmus[wire.end_element].variables[wire.end_connector]
    if start.causality != "output":
        raise InputError(f"{where}: {wire.start_element}.{wire.start_connector} is no output but {start.causality}")
    if end.causality != "input":
        raise InputError(f"{where}: {wire.end_element}.{wire.end_connector} is no input but {end.causality}")
    if (start.type, end.type) == ("Boolean", "Real") and not any(hop.declared for hop in wire.hops):
        raise InputError(
            f"{where}: Boolean becomes Real only as a LinearTransformation at the connection says; "
            'factor="1" makes it 0 or 1'
        )
    if (start.type, end.type) not in {*CONNECTABLE, ("Boolean", "Real")}:
        raise InputError(f"{where}: {start.type} cannot be connected to {end.type}")
    units = [variable_unit(system.elements[element], fmus[element], connector, where) for element, connector in ends]
    sides = (fmus[wire.start_element], start), (fmus[wire.end_element], end)
    return Link(wire, *through(wire.hops, units[0], units[1], where), lookup(wire.hops, *sides, where))


def _output(wire: Wire, system: System, fmus: Mapping[str, Fmu]) -> Link:
    """Check an output of the system and find its conversion."""
    where, name = f"connection {wire}", wire.start_element
    known(wire.start_connector, fmus[name], where)
    table = next((hop.table for hop in wire.hops if hop.table is not None), None)
    if table is not None:
        raise InputError(f"{where}: {table} to an output of the system; not supported")
    unit = variable_unit(system.elements[name], fmus[name], wire.start_connector, where)
    return Link(wire, *through(wire.hops, unit, wire.hops[-1].unit, where))


def _check_inputs(links: Iterable[Link], fmus: Mapping[str, Fmu]) -> None:
    """Raise InputError for an input that more than one output feeds, be it under two names."""
    fed: dict[tuple[str, str, int, int], Link] = {}
    for link in links:
        element, name = link.wire.end_element, link.wire.end_connector
        variable = fmus[element].variables[name]
        other = fed.setdefault((element, *variable.place), link)
        if other is link:
            continue
        if other.wire.end_connector == name:
            raise InputError(f"input {element}.{name} is fed by two connections")
        same, other_one = (
            (x.wire.start_element, x.wire.start_connector, x.gain, x.offset, x.lookup) for x in (link, other)
        )
        if same != other_one:
            raise InputError(
                f"inputs {element}.{other.wire.end_connector} and {element}.{name} are one variable (value reference "
                f"{variable.valueReference}), and two connections feed it: {other.wire} and {link.wire}"
            )


def _check_tables(links: Iterable[Link], fmus: Mapping[str, Fmu]) -> None:
    """Raise InputError for an array that tables feed in part: a call sets the whole of it."""
    by_table: dict[tuple[str, str], set[str]] = {}
    for link in links:
        if link.lookup is not None:
            element, name = link.wire.end_element, link.wire.end_connector
            by_table.setdefault((element, fmus[element].variables[name].array), set()).add(name)
    for (element, array), found in by_table.items():
        bare = [name for name in elements_of(array, fmus[element]) if name not in found]
        if bare:
            raise InputError(f"input {element}.{array}: mapping tables feed a part of it, not {bare[0]}; must be all")


def _passed_over(contact: str | None, integrated: Iterable[str]) -> set[tuple[str, str]]:
    """Return the displacement inputs of the contact that it does without."""
    return {(str(contact), f"{s}_u_{d}") for s in integrated for d in DISPLACEMENT_DIRECTIONS}


def _held_inputs(
    links: Iterable[Link],
    fmus: Mapping[str, Fmu],
    parameters: Mapping[str, Mapping[str, Value]],
    known: Collection[tuple[str, str]],
) -> Iterable[str]:
    """Yield a notice for each input that neither a connection nor a value reaches, nor another notice."""
    fed: dict[str, set[tuple[str, int, int]]] = {name: set() for name in fmus}
    for name, variable in known:
        fed[name].add(fmus[name].variables[variable].place)
    for link in links:
        fed[link.wire.end_element].add(fmus[link.wire.end_element].variables[link.wire.end_connector].place)
    for name, fmu in fmus.items():
        neutral = {v for v in fmu.names("input") if v.endswith(CHANGE) and v.removesuffix(CHANGE) in fmu.variables}
        reached = fed[name] | {fmu.variables[v].place for v in (*neutral, *parameters[name])}
        for variable in fmu.names("input"):
            if fmu.variables[variable].place not in reached:
                start = fmu.variables[variable].start
                yield f"input {name}.{variable} of {fmu.path.name} is connected to nothing; it stays at {start}"
