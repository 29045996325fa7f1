"""The contract and the table of cases in, SSP 1.0 files out: one SSD per case and the parameter sets (SSV). No FMUs.

The files keep to what tools read alike: the prefixes ssd, ssc, ssv, a flat system, one external parameter set per
component named `initialValues`, the step size in the annotations that tools look for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from xml.etree.ElementTree import Element, SubElement

from ...cases import Case
from ...component import Component, Instance, Variable
from ...interface import CHANGE, STEP_SIZE, UNITS, connections, mobility_ports
from .namespaces import tag
from .xml import add_experiment, add_openmodelica_step, add_units, parameter_set, to_bytes

_GEOMETRY = {"wheel": ("10", "60", "40", "80"), "rail": ("10", "10", "40", "30"), "contact": ("70", "35", "100", "55")}


def system_mobility(structures: list[Component], step_size: float) -> dict[str, float]:
    """Return the contact's mobility parameters: the sum of what the structures publish for a step size."""
    total = {port.name: 0.0 for port in mobility_ports("mobility")}
    for structure in structures:
        instance = Instance(structure, {STEP_SIZE: step_size})
        instance.initialise()
        for name, value in instance.calculated.items():
            total[f"mobility{name.removeprefix('y')}"] += value
    return total


def contact_values(components: Mapping[str, Component], case: Case) -> dict[str, float]:
    """Return the parameters of the contact that a case sets, with the interface mobility of its wheel and rail."""
    return {**case.contact, **system_mobility([components[case.wheel], components[case.rail]], case.step_size)}


def contacts(components: Mapping[str, Component], cases: Sequence[Case]) -> dict[str, Component]:
    """Return one contact per case with the values of the case as start values, by FMU file name without suffix.

    Many hosts ignore parameter sets; a contact that needs them would then stand still. The first one is `contact`.
    """
    return {
        contact_name(case, cases): components["contact"].with_starts(contact_values(components, case)) for case in cases
    }


def contact_name(case: Case, cases: Sequence[Case]) -> str:
    """Return the FMU file name, without suffix, of the contact of a case."""
    return "contact" if case.name == cases[0].name else f"contact-{case.name}"


def ssp_files(components: Mapping[str, Component], cases: tuple[Case, ...]) -> dict[str, bytes]:
    """Return every text file of the archive by its name: the SSDs and the SSVs.

    Parameters
    ----------
    components : by FMU file name without suffix: contact, and every wheel and rail that a case names
    cases : the first one becomes SystemStructure.ssd
    """
    files = {}
    for number, case in enumerate(cases):
        parts = {"wheel": components[case.wheel], "rail": components[case.rail], "contact": components["contact"]}
        values = {
            "wheel": {STEP_SIZE: case.step_size},
            "rail": {STEP_SIZE: case.step_size},
            "contact": contact_values(components, case),
        }
        fmus = {"wheel": case.wheel, "rail": case.rail, "contact": contact_name(case, cases)}
        for name, component in parts.items():
            files[f"resources/{name}-{case.name}.ssv"] = to_bytes(_parameter_set(component, values[name]))
        ssd = "SystemStructure.ssd" if number == 0 else f"{case.name}.ssd"
        files[ssd] = to_bytes(_description(case, parts, fmus))
    return files


def _description(case: Case, parts: Mapping[str, Component], fmus: Mapping[str, str]) -> Element:
    """Return the SystemStructureDescription of a case; `fmus` are FMU file names, without suffix, by part."""
    root = Element(tag("ssd", "SystemStructureDescription"), version="1.0", name=case.name)
    system = SubElement(root, tag("ssd", "System"), name="curvesqueal", description=case.title)
    elements = SubElement(system, tag("ssd", "Elements"))
    for name, component in parts.items():
        elements.append(_component(name, f"resources/{fmus[name]}.fmu", f"resources/{name}-{case.name}.ssv", component))
    wires = SubElement(system, tag("ssd", "Connections"))
    for c in connections():
        SubElement(
            wires,
            tag("ssd", "Connection"),
            startElement=c.start_element,
            startConnector=c.start_connector,
            endElement=c.end_element,
            endConnector=c.end_connector,
        )
    add_openmodelica_step(system, case.step_size)
    add_units(root, "ssd", _definitions(v for component in parts.values() for v in _connected(component)))
    add_experiment(root, 0.0, case.stop_time, case.step_size, "staggered")
    return root


def _connected(component: Component) -> list[Variable]:
    """Return the variables of a component that become connectors: outputs, and inputs that are connected.

    Some hosts write to every connector, zero or worse: FMPy's runner gives one without a wire what another wire has.
    """
    return [v for v in component.variables if v.causality in ("input", "output") and not v.name.endswith(CHANGE)]


def _component(name: str, source: str, parameters: str, component: Component) -> Element:
    """Return the Component element: connectors, geometry, parameter set."""
    element = Element(
        tag("ssd", "Component"), name=name, source=source, type="application/x-fmu-sharedlibrary",
        implementation="CoSimulation",
    )  # fmt: skip
    connectors = SubElement(element, tag("ssd", "Connectors"))
    for variable in _connected(component):
        connector = SubElement(connectors, tag("ssd", "Connector"), name=variable.name, kind=variable.causality)
        SubElement(connector, tag("ssc", "Real"), unit=variable.unit)
    x1, y1, x2, y2 = _GEOMETRY[name]
    SubElement(element, tag("ssd", "ElementGeometry"), x1=x1, y1=y1, x2=x2, y2=y2)
    bindings = SubElement(element, tag("ssd", "ParameterBindings"))
    SubElement(bindings, tag("ssd", "ParameterBinding"), source=parameters)
    return element


def _parameter_set(component: Component, values: Mapping[str, float]) -> Element:
    """Return an SSV with some parameters of a component."""
    declared = {v.name: v for v in component.of("parameter")}
    root = parameter_set((name, declared[name].check(value), declared[name].unit) for name, value in values.items())
    add_units(root, "ssv", _definitions(declared[name] for name in values))
    return root


def _definitions(variables: Iterable[Variable]) -> dict[str, dict[str, float]]:
    """Return the units of some variables in base units."""
    return {v.unit: dict(UNITS[v.unit] or {}) for v in variables}
