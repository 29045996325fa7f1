"""The terminals and the icon of a component: the plugs by which one rail is exchanged for another."""

from __future__ import annotations

from importlib.resources import files
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ...component import Component
from ...interface import STRUCTURES, connections

KIND = "org.curvesqueal.wheel-rail-contact"


def terminal_files(component: Component, fmi: int) -> dict[str, bytes]:
    """Return the files of the folder `terminalsAndIcons`, and the model's picture, by their names in the FMU.

    An FMU of FMI 2.0 has the picture only: the file's schema wants `fmiVersion` to be 3.0 or later, FMI Library wants
    it to be that of the model description and else logs a fatal error, so that nothing suits both.
    """
    icon = files(__package__).joinpath("icon.png").read_bytes()
    if fmi < 3:
        return {"model.png": icon}
    root = Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    picture = SubElement(root, "GraphicalRepresentation")
    SubElement(picture, "CoordinateSystem", x1="-100", y1="-100", x2="100", y2="100", suggestedScalingFactorTo_mm="0.1")
    SubElement(picture, "Icon", x1="-100", y1="-100", x2="100", y2="100")
    found = _plugs(component)
    if found:
        terminals = SubElement(root, "Terminals")
        for name, members in found.items():
            terminal = SubElement(terminals, "Terminal", name=name, matchingRule="plug", terminalKind=KIND)
            for member, variable in members.items():
                SubElement(
                    terminal, "TerminalMemberVariable", variableName=variable, memberName=member, variableKind="signal"
                )
    indent(root)
    return {
        "terminalsAndIcons/terminalsAndIcons.xml": tostring(root, "utf-8", xml_declaration=True),
        "terminalsAndIcons/icon.png": icon,
        "model.png": icon,
    }


def _plugs(component: Component) -> dict[str, dict[str, str]]:
    """Return variables by member name, by terminal: the wires of the contract, seen from either side.

    Members have the structure's names, so that the plug of a wheel or a rail fits the one of the contact.
    """
    names = {v.name for v in component.variables}
    plugs: dict[str, dict[str, str]] = {}
    for wire in connections():
        structure = wire.end_element if wire.start_element == "contact" else wire.start_element
        ends = {wire.start_element: wire.start_connector, wire.end_element: wire.end_connector}
        member, other = ends[structure], ends["contact"]
        if other in names:
            plugs.setdefault(structure, {})[member] = other
        elif member in names and structure == STRUCTURES[0]:
            plugs.setdefault("contact_point", {})[member] = member
    return plugs
