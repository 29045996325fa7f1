"""The contract and the table of cases in, SSP 1.0 files out: one SSD per case and the parameter sets (SSV). No FMUs.

The files keep to what tools read alike: the prefixes ssd, ssc, ssv, a flat system, one external parameter set per
component named `initialValues`, the step size in the annotations that tools look for.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

from ..component import Component, Instance, Variable
from ..interface import STEP_SIZE, STRUCTURES, UNITS, connections, mobility_ports

SSP_FOLDER = Path(__file__).parents[2] / "ssp"

_BASE = "http://ssp-standard.org/SSP1/"
NAMESPACES = {
    "ssd": _BASE + "SystemStructureDescription",
    "ssc": _BASE + "SystemStructureCommon",
    "ssv": _BASE + "SystemStructureParameterValues",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "curvesqueal": "urn:curvesqueal:ssp",
}

_GEOMETRY = {"wheel": ("10", "60", "40", "80"), "rail": ("10", "10", "40", "30"), "contact": ("70", "35", "100", "55")}


@dataclass(frozen=True)
class Case:
    """One of the paper's cases.

    Attributes
    ----------
    name : such as "case1"
    title : what it is, in words
    rail : FMU file in the rail's place, without suffix
    contact : parameters of the contact that the case sets
    step_size, stop_time : default experiment [s]
    """

    name: str
    title: str
    rail: str
    contact: Mapping[str, float]
    step_size: float
    stop_time: float


def read_cases(folder: Path = SSP_FOLDER) -> tuple[Case, ...]:
    """Return the cases that `cases.toml` lists."""
    data: dict[str, Any] = tomllib.loads((folder / "cases.toml").read_text(encoding="utf-8"))
    return tuple(
        Case(
            name=c["name"],
            title=c["title"],
            rail=c["rail"],
            contact={"falling_ratio": c["falling_ratio"], **data["disturbance"]},
            step_size=data["step"]["size_s"],
            stop_time=data["step"]["stop_time_s"],
        )
        for c in data["case"]
    )


def system_mobility(structures: list[Component], step_size: float) -> dict[str, float]:
    """Return the contact's mobility parameters: the sum of what the structures publish for a step size."""
    total = {port.name: 0.0 for port in mobility_ports("mobility")}
    for structure in structures:
        instance = Instance(structure, {STEP_SIZE: step_size})
        instance.initialise()
        for name, value in instance.calculated.items():
            total[f"mobility{name.removeprefix('y')}"] += value
    return total


def ssp_files(components: Mapping[str, Component], cases: tuple[Case, ...]) -> dict[str, bytes]:
    """Return every text file of the archive by its name: the SSDs and the SSVs.

    Parameters
    ----------
    components : by FMU file name without suffix: wheel, contact, and every rail that a case names
    cases : the first one becomes SystemStructure.ssd
    """
    for prefix, uri in NAMESPACES.items():
        register_namespace(prefix, uri)
    files = {}
    for number, case in enumerate(cases):
        parts = {"wheel": components["wheel"], "rail": components[case.rail], "contact": components["contact"]}
        mobility = system_mobility([parts[s] for s in STRUCTURES], case.step_size)
        values = {
            "wheel": {STEP_SIZE: case.step_size},
            "rail": {STEP_SIZE: case.step_size},
            "contact": {**case.contact, **mobility},
        }
        for name, component in parts.items():
            files[f"resources/{name}-{case.name}.ssv"] = _text(_parameter_set(component, values[name]))
        ssd = "SystemStructure.ssd" if number == 0 else f"{case.name}.ssd"
        files[ssd] = _text(_description(case, parts))
    return files


def _tag(prefix: str, name: str) -> str:
    return f"{{{NAMESPACES[prefix]}}}{name}"


def _text(root: Element) -> bytes:
    indent(root)
    body: bytes = tostring(root, "utf-8", xml_declaration=False)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + body + b"\n"


def _description(case: Case, parts: Mapping[str, Component]) -> Element:
    """Return the SystemStructureDescription of a case."""
    root = Element(_tag("ssd", "SystemStructureDescription"), version="1.0", name=case.name)
    system = SubElement(root, _tag("ssd", "System"), name="curvesqueal", description=case.title)
    elements = SubElement(system, _tag("ssd", "Elements"))
    for name, component in parts.items():
        fmu = case.rail if name == "rail" else name
        elements.append(_component(name, f"resources/{fmu}.fmu", f"resources/{name}-{case.name}.ssv", component))
    wires = SubElement(system, _tag("ssd", "Connections"))
    for c in connections():
        SubElement(
            wires,
            _tag("ssd", "Connection"),
            startElement=c.start_element,
            startConnector=c.start_connector,
            endElement=c.end_element,
            endConnector=c.end_connector,
        )
    _annotate(system, "org.openmodelica", _openmodelica(case))
    _units(root, "ssd", (v for component in parts.values() for v in _connected(component)))
    experiment = SubElement(root, _tag("ssd", "DefaultExperiment"), startTime="0.0", stopTime=repr(case.stop_time))
    algorithm = Element(_tag("osp", "Algorithm"))
    SubElement(algorithm, _tag("osp", "FixedStepAlgorithm"), baseStepSize=repr(case.step_size))
    master = Element(_tag("curvesqueal", "Master"), stepSize=repr(case.step_size), algorithm="staggered")
    _annotate(experiment, "com.opensimulationplatform", algorithm)
    _annotate(experiment, "curvesqueal", master)
    return root


def _openmodelica(case: Case) -> Element:
    """Return OMSimulator's way to say the step size."""
    annotations = Element(_tag("oms", "Annotations"))
    information = SubElement(annotations, _tag("oms", "SimulationInformation"))
    SubElement(information, _tag("oms", "FixedStepMaster"), description="oms-ma", stepSize=repr(case.step_size))
    return annotations


def _annotate(parent: Element, kind: str, content: Element) -> None:
    """Add an annotation to `parent`."""
    annotations = parent.find(_tag("ssd", "Annotations"))
    if annotations is None:
        annotations = SubElement(parent, _tag("ssd", "Annotations"))
    SubElement(annotations, _tag("ssc", "Annotation"), type=kind).append(content)


def _connected(component: Component) -> list[Variable]:
    """Return the variables of a component that become connectors: inputs, outputs."""
    return [v for v in component.variables if v.causality in ("input", "output")]


def _component(name: str, source: str, parameters: str, component: Component) -> Element:
    """Return the Component element: connectors, geometry, parameter set."""
    element = Element(
        _tag("ssd", "Component"), name=name, source=source, type="application/x-fmu-sharedlibrary",
        implementation="CoSimulation",
    )  # fmt: skip
    connectors = SubElement(element, _tag("ssd", "Connectors"))
    for variable in _connected(component):
        connector = SubElement(connectors, _tag("ssd", "Connector"), name=variable.name, kind=variable.causality)
        SubElement(connector, _tag("ssc", "Real"), unit=variable.unit)
    x1, y1, x2, y2 = _GEOMETRY[name]
    SubElement(element, _tag("ssd", "ElementGeometry"), x1=x1, y1=y1, x2=x2, y2=y2)
    bindings = SubElement(element, _tag("ssd", "ParameterBindings"))
    SubElement(bindings, _tag("ssd", "ParameterBinding"), source=parameters)
    return element


def _parameter_set(component: Component, values: Mapping[str, float]) -> Element:
    """Return an SSV with some parameters of a component."""
    root = Element(_tag("ssv", "ParameterSet"), version="1.0", name="initialValues")
    parameters = SubElement(root, _tag("ssv", "Parameters"))
    declared = {v.name: v for v in component.of("parameter")}
    for name, value in values.items():
        parameter = SubElement(parameters, _tag("ssv", "Parameter"), name=name)
        SubElement(parameter, _tag("ssv", "Real"), value=repr(declared[name].check(value)), unit=declared[name].unit)
    _units(root, "ssv", (declared[name] for name in values))
    return root


def _units(root: Element, prefix: str, variables: Any) -> None:
    """Define the units of some variables."""
    units = SubElement(root, _tag(prefix, "Units"))
    for unit in sorted({v.unit for v in variables}):
        element = SubElement(units, _tag("ssc", "Unit"), name=unit)
        SubElement(element, _tag("ssc", "BaseUnit"), {name: str(e) for name, e in (UNITS[unit] or {}).items()})
