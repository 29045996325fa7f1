"""A component's declaration in, its FMI 2.0 model description out. No files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from xml.etree.ElementTree import Element, SubElement

from ...component import Component, Variable
from ...interface import DEFAULT_STEP
from .common import identify, log_categories, roles, type_attributes, unit_definitions


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
