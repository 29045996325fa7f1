"""What the model descriptions of FMI 2.0 and 3.0 share: identity, units, log categories, types."""

from __future__ import annotations

import math
from uuid import NAMESPACE_URL, uuid5
from xml.etree.ElementTree import Element, SubElement, tostring

from ...component import Component, Variable
from ...interface import UNITS

VARIABILITY = {
    "parameter": "fixed",
    "calculatedParameter": "fixed",
    "local": "continuous",
    "input": "continuous",
    "output": "continuous",
}


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
    """Define every unit that a variable of the component has, and that of the time."""
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({"s", *(v.unit for v in component.variables if v.kind == "Real")}):
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
