"""A component's declaration in, its FMI 3.0 model description out; numbered variables become arrays. No files."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement

from ...component import Component
from ...interface import DEFAULT_STEP
from ...modal.layout import DAMPING_RATIO
from .arrays import Array, arrays, scalars
from .common import identify, log_categories, roles, type_attributes, unit_definitions

TYPES = {"Real": "Float64", "Integer": "Int32", "Boolean": "Boolean"}
TIME = "time"


FIRST_REFERENCE = 1
"""Value references count the variables from 1 on: some hosts take them for positions in the list."""


def model_description3(component: Component, version: str, content: str, only_scalars: bool = False) -> Element:
    """Return the root element of modelDescription.xml for FMI 3.0.

    Parameters
    ----------
    component : Component
    version : version of the project
    content : text that identifies the code in the FMU; together with the declaration it makes the token
    only_scalars : whether numbered variables stay scalars, for hosts that know no arrays
    """
    groups = scalars(component) if only_scalars else arrays(component)
    root = Element("fmiModelDescription")
    options = {
        "modelIdentifier": component.name,
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "hasEventMode": "false",
        "canGetAndSetFMUState": "true",
        "canSerializeFMUState": "true",
    }
    if component.differentiable:
        options["providesDirectionalDerivatives"] = "true"
    SubElement(root, "CoSimulation", options)
    unit_definitions(root, component)
    log_categories(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(DEFAULT_STEP))
    variables = SubElement(root, "ModelVariables")
    for reference, group in enumerate(groups, FIRST_REFERENCE):
        variables.append(_variable(reference, group))
    SubElement(
        variables, "Float64", name=TIME, valueReference=str(FIRST_REFERENCE + len(groups)), causality="independent",
        variability="continuous", unit="s", description="time",
    )  # fmt: skip
    _model_structure(root, groups)
    identify(root, component, version, content, ("3.0", "instantiationToken"))
    return root


def _variable(reference: int, group: Array) -> Element:
    """Return the element of a variable; limits and nominal of an array are those of all its members."""
    variable = group.variables[0]
    text = variable.description
    attributes = {
        "name": group.name,
        "valueReference": str(reference),
        "description": text if group.is_scalar else _of_all(group),
        **roles(variable),
        **type_attributes(variable),
    }
    if len(group.variables) > 1 and variable.start is not None:
        attributes["start"] = " ".join(repr(v.start) for v in group.variables)
    element = Element(TYPES[variable.kind], attributes)
    if not group.is_scalar:
        SubElement(element, "Dimension", start=str(len(group.variables)))
    return element


def _of_all(group: Array) -> str:
    """Return the description of an array; that of the damping ratios has the labels of the modes."""
    parts = [variable.description.partition(" of mode ") for variable in group.variables]
    text, labels = f"{parts[0][0]}, one value per mode", [part[2].partition(", ")[2] for part in parts]
    return f"{text}: {'; '.join(labels)}" if group.name == DAMPING_RATIO and any(labels) else text


def _model_structure(root: Element, groups: list[Array]) -> None:
    """Write outputs with their dependencies, and the unknowns of the initialisation."""
    reference = {v.name: r for r, group in enumerate(groups, FIRST_REFERENCE) for v in group.variables}
    structure = SubElement(root, "ModelStructure")

    def add(kind: str, group: Array, known: Iterable[str] | None) -> None:
        attributes = {"valueReference": str(reference[group.variables[0].name])}
        if known is not None:
            attributes["dependencies"] = " ".join(map(str, dict.fromkeys(reference[name] for name in known)))
        SubElement(structure, kind, attributes)

    for group in groups:
        if group.variables[0].causality == "output":
            add("Output", group, group.variables[0].depends_on)
    for group in groups:
        if group.variables[0].causality in ("output", "calculatedParameter"):
            add("InitialUnknown", group, group.variables[0].initially_depends_on)
