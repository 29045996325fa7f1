"""A component's declaration in, its FMI 2.0 model description out. No files."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from uuid import NAMESPACE_URL, uuid5
from xml.etree.ElementTree import Element, SubElement, tostring

from ..component import Component, Variable
from ..interface import DEFAULT_STEP, UNITS

VARIABILITY = {
    "parameter": "fixed",
    "calculatedParameter": "fixed",
    "local": "continuous",
    "input": "continuous",
    "output": "continuous",
}


def model_description(
    component: Component, version: str, content: str, derivatives: bool = False, sources: Sequence[str] = ()
) -> Element:
    """Return the root element of modelDescription.xml for FMI 2.0.

    Parameters
    ----------
    component : Component
    version : version of the project
    content : text that identifies the code in the FMU; together with the declaration it makes the guid
    derivatives : whether the FMU provides directional derivatives
    sources : names of the files that a C compiler makes the FMU of
    """
    root = Element("fmiModelDescription")
    options = {
        "modelIdentifier": component.name,
        "needsExecutionTool": "false",
        "canHandleVariableCommunicationStepSize": "true",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "true",
        "canSerializeFMUstate": "true",
    }
    if derivatives:
        options["providesDirectionalDerivative"] = "true"
    unit_definitions(root, component)
    interface = SubElement(root, "CoSimulation", options)
    if sources:
        listed = SubElement(interface, "SourceFiles")
        for name in sources:
            SubElement(listed, "File", name=name)
    log_categories(root)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="1", stepSize=repr(DEFAULT_STEP))
    variables = SubElement(root, "ModelVariables")
    for reference, variable in enumerate(component.variables):
        variables.append(_scalar_variable(reference, variable))
    _model_structure(root, component)
    # the schema wants CoSimulation before UnitDefinitions
    root[:2] = [root[1], root[0]]
    identify(root, component, version, content, ("2.0", "guid"))
    return root


def identify(root: Element, component: Component, version: str, content: str, names: tuple[str, str]) -> None:
    """Give the finished root its attributes; `names` are the FMI version and what it calls the identifier."""
    body = "".join(tostring(child, "unicode") for child in root)
    root.attrib = {
        "fmiVersion": names[0],
        "modelName": component.name,
        names[1]: f"{{{uuid5(NAMESPACE_URL, body + content + version)}}}",
        "description": component.description,
        "version": version,
        "license": "BSD-3-Clause",
        "generationTool": f"curvesqueal {version}",
        "variableNamingConvention": "flat",
    }


def unit_definitions(root: Element, component: Component) -> None:
    """Define every unit that a variable of the component has."""
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in component.variables if v.kind == "Real"}):
        element = SubElement(definitions, "Unit", name=unit)
        exponents = UNITS[unit]
        if exponents is not None:
            SubElement(element, "BaseUnit", {name: str(e) for name, e in exponents.items()})
        if unit == "rad":
            SubElement(element, "DisplayUnit", name="deg", factor=repr(180 / math.pi))


def log_categories(root: Element) -> None:
    """Declare the log categories that FMI recommends and the slave uses."""
    categories = SubElement(root, "LogCategories")
    for name, text in (
        ("logStatusWarning", "messages with fmi2Warning status"),
        ("logStatusDiscard", "messages with fmi2Discard status"),
        ("logStatusError", "messages with fmi2Error status"),
        ("logStatusFatal", "messages with fmi2Fatal status"),
        ("logAll", "all messages"),
    ):
        SubElement(categories, "Category", name=name, description=text)


def _scalar_variable(reference: int, variable: Variable) -> Element:
    """Return the ScalarVariable element of a variable."""
    attributes = {
        "name": variable.name,
        "valueReference": str(reference),
        "description": variable.description,
        **roles(variable),
    }
    element = Element("ScalarVariable", attributes)
    SubElement(element, variable.kind, type_attributes(variable))
    return element


def roles(variable: Variable) -> dict[str, str]:
    """Return causality, variability and initial."""
    attributes = {
        "causality": variable.causality,
        "variability": "tunable" if variable.tunable else VARIABILITY[variable.causality],
    }
    if variable.causality == "parameter":
        attributes["initial"] = "exact"
    elif variable.causality != "input":
        attributes["initial"] = "calculated"
    return attributes


def type_attributes(variable: Variable) -> dict[str, str]:
    """Return unit, limits, nominal and start as the type of the variable writes them."""
    if variable.kind == "Boolean":
        return {"start": str(bool(variable.start)).lower()}
    number = repr if variable.kind == "Real" else lambda value: str(int(value))
    attributes = {}
    if variable.kind == "Real":
        attributes["unit"] = variable.unit
        if variable.unit == "rad" and variable.causality == "parameter":
            attributes["displayUnit"] = "deg"
    if math.isfinite(variable.minimum):
        attributes["min"] = number(variable.minimum)
    if math.isfinite(variable.maximum):
        attributes["max"] = number(variable.maximum)
    if variable.kind == "Real":
        attributes["nominal"] = number(variable.nominal)
    if variable.start is not None:
        attributes["start"] = number(variable.start)
    return attributes


def _model_structure(root: Element, component: Component) -> None:
    """Write outputs with their dependencies, and the unknowns of the initialisation."""
    index = {v.name: i for i, v in enumerate(component.variables, start=1)}

    def add(parent: Element, variable: Variable, known: Iterable[str] | None) -> None:
        attributes = {"index": str(index[variable.name])}
        if known is not None:
            attributes["dependencies"] = " ".join(str(index[name]) for name in known)
        SubElement(parent, "Unknown", attributes)

    structure = SubElement(root, "ModelStructure")
    outputs = SubElement(structure, "Outputs")
    initial = SubElement(structure, "InitialUnknowns")
    for variable in component.of("output"):
        add(outputs, variable, variable.depends_on)
    for variable in component.variables:
        if variable.causality in ("output", "calculatedParameter"):
            add(initial, variable, variable.initially_depends_on)
