"""Namespaces of SSP files and of the annotations in them: ours and other tools', for the writer and the reader."""

from __future__ import annotations

_BASE = "http://ssp-standard.org/SSP1/"
NAMESPACES = {
    "ssd": _BASE + "SystemStructureDescription",
    "ssc": _BASE + "SystemStructureCommon",
    "ssv": _BASE + "SystemStructureParameterValues",
    "ssm": _BASE + "SystemStructureParameterMapping",
    "ssb": _BASE + "SystemStructureSignalDictionary",
    "osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
    "curvesqueal": "urn:curvesqueal:ssp",
}
"""By the prefixes that tools expect."""


def tag(prefix: str, name: str = "") -> str:
    """Return the full name of an element, or what the names of a namespace begin with.

    >>> tag("curvesqueal", "Settings")
    '{urn:curvesqueal:ssp}Settings'
    """
    return f"{{{NAMESPACES[prefix]}}}{name}"
