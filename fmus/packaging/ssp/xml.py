"""Pieces of SSP 1.0 files that more than one writer makes: names, parameter sets, units, settings of the simulation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.etree.ElementTree import Element, SubElement, indent, register_namespace, tostring

from .namespaces import NAMESPACES, tag

Exponents = Mapping[str, float]
"""What a unit is in base units: their exponents, and `factor` and `offset` where they are not 1 and 0."""


def to_bytes(root: Element) -> bytes:
    """Return an XML file; the prefixes are those that tools expect."""
    for prefix, uri in NAMESPACES.items():  # only those that are used are written
        register_namespace(prefix, uri)
    indent(root)
    body: bytes = tostring(root, "utf-8", xml_declaration=False)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + body + b"\n"


def annotate(parent: Element, kind: str, content: Element) -> None:
    """Add an annotation to `parent`."""
    annotations = parent.find(tag("ssd", "Annotations"))
    if annotations is None:
        annotations = SubElement(parent, tag("ssd", "Annotations"))
    SubElement(annotations, tag("ssc", "Annotation"), type=kind).append(content)


def parameter_set(values: Iterable[tuple[str, float | int | bool | str, str | None]]) -> Element:
    """Return a parameter set of names, values and units; the type follows the value's."""
    root = Element(tag("ssv", "ParameterSet"), version="1.0", name="initialValues")
    parameters = SubElement(root, tag("ssv", "Parameters"))
    for name, value, unit in values:
        parameter = SubElement(parameters, tag("ssv", "Parameter"), name=name)
        kind = {bool: "Boolean", int: "Integer", str: "String"}.get(type(value), "Real")
        text = str(value).lower() if kind == "Boolean" else str(value) if kind != "Real" else repr(float(value))
        told = {"unit": unit} if unit and kind == "Real" else {}
        SubElement(parameter, tag("ssv", kind), {"value": text, **told})
    return root


def add_units(root: Element, prefix: str, units: Mapping[str, Exponents]) -> None:
    """Define units by name in a file."""
    if not units:
        return
    holder = SubElement(root, tag(prefix, "Units"))
    for name in sorted(units):
        element = SubElement(holder, tag("ssc", "Unit"), name=name)
        SubElement(element, tag("ssc", "BaseUnit"), {key: str(value) for key, value in units[name].items()})


def add_openmodelica_step(system: Element, step_size: float) -> None:
    """Add OMSimulator's way to say the step size [s]."""
    annotations = Element(tag("oms", "Annotations"))
    information = SubElement(annotations, tag("oms", "SimulationInformation"))
    SubElement(information, tag("oms", "FixedStepMaster"), description="oms-ma", stepSize=repr(step_size))
    annotate(system, "org.openmodelica", annotations)


def add_experiment(root: Element, start: float, stop: float, step_size: float, algorithm: str) -> None:
    """Add times and step size [s] and the master algorithm, as Open Simulation Platform's tools and ours read them."""
    experiment = SubElement(root, tag("ssd", "DefaultExperiment"), startTime=repr(start), stopTime=repr(stop))
    fixed = Element(tag("osp", "Algorithm"))
    SubElement(fixed, tag("osp", "FixedStepAlgorithm"), baseStepSize=repr(step_size))
    annotate(experiment, "com.opensimulationplatform", fixed)
    master = Element(tag("curvesqueal", "Master"), stepSize=repr(step_size), algorithm=algorithm)
    annotate(experiment, "curvesqueal", master)


def add_stage(component: Element, stage: int | None, step: float | None = None) -> None:
    """Add the place of a component in the order of stepping, and a step of its own [s]."""
    told = {"stage": None if stage is None else str(stage), "stepSize": None if step is None else repr(step)}
    given = {key: text for key, text in told.items() if text is not None}
    annotate(component, "curvesqueal", Element(tag("curvesqueal", "Component"), given))
