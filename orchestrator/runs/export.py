"""An assembled system and its settings in, an .ssp out that runs the same in any host: flat, complete, SSP 1.0.

What the system's files leave to be worked out is worked out: nesting, precedence of bindings, mappings, units, values
of system connectors, interface mobilities. What is left is what most tools read: components with one parameter set
each, connections with at most a linear transformation.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from fmus.packaging.archive import write_files
from fmus.packaging.ssp.namespaces import tag
from fmus.packaging.ssp.xml import (
    Exponents,
    add_experiment,
    add_openmodelica_step,
    add_stage,
    add_units,
    parameter_set,
    to_bytes,
)

from ..coupling.assembly import Assembly
from ..coupling.bonds import Link
from ..coupling.contact_mobility import contact_mobility
from ..coupling.master import Settings
from ..fmi.instance import Fmu, Value
from ..probing.mobility import with_step
from ..system.values import own_unit
from ..units import BASE_UNITS, Unit, find_unit, unit_name

_TYPES = ("Real", "Integer", "Boolean", "String")
"""Types of variables that become connectors."""


def export_system(assembly: Assembly, settings: Settings, target: Path) -> None:
    """Write an .ssp that reproduces a run: the same FMUs, values, connections, step, algorithm and times.

    Inputs and parameters of the system itself have become values of its components; its outputs remain. The same
    system gives the same bytes.

    Parameters
    ----------
    assembly : the system, with replacements and parameters applied
    settings : how it would be run
    target : file to write

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    values = {name: v for name, v in _values(assembly, settings.step).items() if v}
    sources, sets = _fmu_places(assembly.fmus), _places({name: name for name in values}, "ssv")
    files = {source: assembly.fmus[name].path.read_bytes() for name, source in sources.items()}
    files |= {sets[name]: to_bytes(_parameters(assembly.fmus[name], values[name])) for name in values}
    files["SystemStructure.ssd"] = to_bytes(_description(assembly, settings, sources, sets))
    write_files(files, target)


def _values(assembly: Assembly, step: float) -> dict[str, dict[str, Value]]:
    """Return what a run sets before it initialises the components, by component and variable."""
    values = {
        name: {**fmu.structure, **with_step(fmu, assembly.parameters[name], step)}
        for name, fmu in assembly.fmus.items()
    }
    if assembly.contact is not None:
        values[assembly.contact].update(contact_mobility(assembly, step))
        values[assembly.contact].update(assembly.integration())
    return values


def _fmu_places(fmus: Mapping[str, Fmu]) -> dict[str, str]:
    """Return the place of each component's FMU in the archive; components with the same FMU share it."""
    stems: dict[str, str] = {}
    for fmu in fmus.values():
        stems.setdefault(fmu.checksum, fmu.path.stem)
    places = _places(stems, "fmu")
    return {name: places[fmu.checksum] for name, fmu in fmus.items()}


def _places(stems: Mapping[str, str], suffix: str) -> dict[str, str]:
    """Return places in the archive: plain names that differ in more than upper and lower case."""
    places: dict[str, str] = {}
    for key, stem in stems.items():
        plain, number = re.sub(r"[^A-Za-z0-9_.-]", "_", stem), 1
        place = f"resources/{plain}.{suffix}"
        while place.lower() in (taken.lower() for taken in places.values()):
            number += 1
            place = f"resources/{plain}-{number}.{suffix}"
        places[key] = place
    return places


def _description(
    assembly: Assembly, settings: Settings, sources: Mapping[str, str], sets: Mapping[str, str]
) -> Element:
    """Return the system structure description, with the places of FMUs and parameter sets by component."""
    system = assembly.system
    root = Element(
        tag("ssd", "SystemStructureDescription"), version="1.0", name=system.name,
        generationTool=f"curvesqueal {version('curvesqueal')}",
    )  # fmt: skip
    top = SubElement(root, tag("ssd", "System"), name=system.name)
    units: dict[str, Exponents] = {}
    _add_outputs(top, assembly.outputs, units)
    elements = SubElement(top, tag("ssd", "Elements"))
    for name, fmu in assembly.fmus.items():
        component = SubElement(
            elements, tag("ssd", "Component"), name=name, source=sources[name], type="application/x-fmu-sharedlibrary",
            implementation="CoSimulation",
        )  # fmt: skip
        _add_connectors(component, fmu, units)
        if name in sets:
            bindings = SubElement(component, tag("ssd", "ParameterBindings"))
            SubElement(bindings, tag("ssd", "ParameterBinding"), source=sets[name])
        element = system.elements[name]
        if element.stage is not None or element.step is not None:
            add_stage(component, element.stage, element.step)
    links = (*assembly.links, *assembly.outputs)
    if links:
        wires = SubElement(top, tag("ssd", "Connections"))
        for link in links:
            _add_connection(wires, link)
    add_openmodelica_step(top, settings.step)
    add_units(root, "ssd", units)
    add_experiment(root, system.start, system.start + settings.duration, settings.step, settings.algorithm)
    return root


def _add_connectors(component: Element, fmu: Fmu, units: dict[str, Exponents]) -> None:
    """Add the inputs and outputs of an FMU as connectors."""
    ports = [v for v in fmu.variables.values() if v.causality in ("input", "output") and v.type in _TYPES]
    if not ports:
        return
    holder = SubElement(component, tag("ssd", "Connectors"))
    for variable in ports:
        connector = SubElement(holder, tag("ssd", "Connector"), name=variable.name, kind=variable.causality)
        unit = own_unit(fmu, variable.name) if variable.type == "Real" else None
        SubElement(connector, tag("ssc", variable.type), _defined(unit, units))


def _add_outputs(system: Element, outputs: Iterable[Link], units: dict[str, Exponents]) -> None:
    """Add the outputs of the system as connectors."""
    links = list(outputs)
    if not links:
        return
    holder = SubElement(system, tag("ssd", "Connectors"))
    for link in links:
        connector = SubElement(holder, tag("ssd", "Connector"), name=link.wire.end_connector, kind="output")
        SubElement(connector, tag("ssc", "Real"), _defined(link.wire.hops[-1].unit, units))


def _add_connection(wires: Element, link: Link) -> None:
    """Add a connection; its whole change of value is written as a transformation, in place of a change of units."""
    wire = link.wire
    ends = {
        "startElement": wire.start_element, "startConnector": wire.start_connector,
        "endElement": wire.end_element, "endConnector": wire.end_connector,
    }  # fmt: skip
    plain = (link.gain, link.offset) == (1.0, 0.0) and all(hop.convert for hop in wire.hops)
    how = {} if plain else {"suppressUnitConversion": "true"}
    connection = SubElement(wires, tag("ssd", "Connection"), {key: v for key, v in ends.items() if v} | how)
    if link.lookup is not None:
        table = SubElement(connection, tag("ssc", str(link.lookup.table)))
        for source, target in link.lookup.table.texts():
            SubElement(table, tag("ssc", "MapEntry"), source=source, target=target)
    elif (link.gain, link.offset) != (1.0, 0.0) or any(hop.declared for hop in wire.hops):
        SubElement(
            connection, tag("ssc", "LinearTransformation"), factor=repr(link.gain), offset=repr(link.offset)
        )  # fmt: skip


def _parameters(fmu: Fmu, values: Mapping[str, Value]) -> Element:
    """Return the parameter set of a component."""
    units: dict[str, Exponents] = {}
    rows = [(name, value, _defined(own_unit(fmu, name), units).get("unit")) for name, value in values.items()]
    root = parameter_set(rows)
    add_units(root, "ssv", units)
    return root


def _defined(unit: Unit | str | None, units: dict[str, Exponents]) -> dict[str, str]:
    """Return the unit attribute for a unit, and add its definition; nothing for a unit that cannot be defined.

    Values and transformations are in the FMUs' own units, so nothing changes where a unit is left out.
    """
    if not unit:
        return {}
    name = unit_name(unit)
    definition = unit if isinstance(unit, Unit) else find_unit(unit)
    if definition is None or any(base not in BASE_UNITS or power % 1 for base, power in definition.dimension):
        return {}
    shift = {
        key: v for key, v in (("factor", definition.factor), ("offset", definition.offset)) if v != (key == "factor")
    }
    units.setdefault(name, {**{base: int(power) for base, power in definition.dimension}, **shift})
    return {"unit": name}
