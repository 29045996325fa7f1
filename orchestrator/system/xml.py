"""XML files of an SSP: parsed without entities, validated against the official schemas, errors that name the line."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from pathlib import Path
from urllib.parse import unquote, urlsplit

import fmpy.ssp
from lxml import etree

from fmus.packaging.ssp.namespaces import tag

from ..errors import InputError
from ..units import BASE_UNITS, Unit

SSD, SSC, SSV, SSM, SSB = (tag(prefix) for prefix in ("ssd", "ssc", "ssv", "ssm", "ssb"))

SCHEMAS = {
    "1.0": Path(fmpy.ssp.__file__).parent / "schema",
    "2.0": Path(__file__).parent / "schemas" / "ssp2",
}
"""Folders of the schemas by version of the standard."""


@dataclass(frozen=True)
class Document:
    """An XML file of a system.

    Attributes
    ----------
    root : its root element
    path : the file
    top : folder that no source may leave
    shown : how messages name the file
    units : units that it defines, by name
    enumerations : values of its enumerations, by name of enumeration and item
    """

    root: etree._Element
    path: Path
    top: Path
    shown: str
    units: dict[str, Unit] = field(default_factory=dict)
    enumerations: dict[str, dict[str, int]] = field(default_factory=dict)

    def error(self, node: etree._Element, text: str) -> InputError:
        """Return the error that names file, line and element."""
        return InputError(f"{self.where(node)}: {text}")

    def where(self, node: etree._Element) -> str:
        """Return file, line and element as messages name them."""
        return f"{self.shown}, line {node.sourceline}, {label(node)}"

    def unit(self, name: str | None) -> Unit | str | None:
        """Return a unit as this file defines it, else its name, for a library to know."""
        return None if not name else self.units.get(name, name)

    def number(self, node: etree._Element, attribute: str, default: float) -> float:
        """Return a finite number that an attribute holds."""
        value = float(node.get(attribute, default))
        if not isfinite(value):
            raise self.error(node, f"{attribute} = {value}: must be a finite number")
        return value

    def resolve(self, node: etree._Element, source: str) -> Path:
        """Return the file that a source attribute names; it must lie in the system's folder."""
        parts = urlsplit(source)
        if parts.scheme or parts.netloc:
            raise self.error(node, f"source {source!r} is not relative; only files beside the system are read")
        try:
            path = (self.path.parent / unquote(parts.path)).resolve()
            path.exists()
        except (OSError, ValueError):  # too long, or with a zero in it
            raise self.error(node, "the source is no file name") from None
        if not path.is_relative_to(self.top.resolve()):
            raise self.error(node, f"source {source!r} lies outside the system's folder; refused")
        return path

    def open(self, node: etree._Element, source: str, kind: str) -> Document:
        """Return another file of the system that a source attribute names."""
        path = self.resolve(node, source)
        if not path.is_file():
            raise self.error(node, f"the file {source!r} is missing")
        archive, mark, _ = self.shown.rpartition(": ")
        return read_document(path, kind, self.top, f"{archive}: {unquote(source)}" if mark else str(path))

    def inline(self, node: etree._Element, kind: str) -> Document:
        """Return an element of this file that is of a format of its own, validated."""
        _validate(node, kind, self.shown)
        return Document(
            node, self.path, self.top, self.shown,
            {**self.units, **_units(node, self.shown)}, {**self.enumerations, **_enumerations(node)},
        )  # fmt: skip


def read_document(path: Path, kind: str, top: Path, shown: str) -> Document:
    """Return an XML file that is valid against an SSP schema.

    Parameters
    ----------
    path : the file
    kind : of content: Description, ParameterValues, ParameterMapping or SignalDictionary
    top : folder that no source in it may leave
    shown : how messages name the file

    Raises
    ------
    InputError
        If the file is not well-formed, has a document type declaration, or is not valid.
    """
    root = parse(path, shown)
    _validate(root, kind, shown)
    return Document(root, path, top, shown, _units(root, shown), _enumerations(root))


def parse(path: Path, shown: str) -> etree._Element:
    """Return the root of an XML file; one with a document type declaration, and so with entities, is refused."""
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True, remove_pis=True
    )
    try:
        document = etree.parse(path, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"{shown} is not well-formed XML: {error}") from None
    except OSError as error:
        raise InputError(f"{shown}: cannot be read: {error}") from None
    if document.docinfo.internalDTD is not None:
        raise InputError(f"{shown} has a document type declaration; refused")
    return document.getroot()


@cache
def _schema(version: str, kind: str) -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(SCHEMAS[version] / f"SystemStructure{kind}.xsd"))


def _validate(root: etree._Element, kind: str, shown: str) -> None:
    """Raise InputError unless an element is valid against the schema of its own version."""
    version = root.get("version", "1.0").strip()
    if version not in SCHEMAS:
        raise InputError(f"{shown}, line {root.sourceline}: SSP version {version!r}; {' and '.join(SCHEMAS)} are read")
    checker = _schema(version, kind)
    if not checker.validate(etree.ElementTree(root)):
        first = checker.error_log[0]
        raise InputError(f"{shown}, line {first.line}: {first.message}")


def local(node: etree._Element) -> str:
    """Return the name of an element without its namespace."""
    return str(etree.QName(node).localname)


def label(node: etree._Element) -> str:
    """Return an element as messages name it."""
    if local(node) == "Connection":
        ends = (".".join(filter(None, (node.get(f"{e}Element"), node.get(f"{e}Connector")))) for e in ("start", "end"))
        return f"connection {' -> '.join(ends)}"
    name = node.get("name") or node.get("source")
    return f"{local(node)} {name!r}" if name else local(node)


def _units(root: etree._Element, shown: str) -> dict[str, Unit]:
    """Return the units that a file defines."""
    units = {}
    for node in root.iterfind(f"{{*}}Units/{SSC}Unit"):
        base = node.find(f"{SSC}BaseUnit")
        exponents = {name: int(base.get(name, 0)) for name in BASE_UNITS}
        name, factor, offset = node.get("name"), float(base.get("factor", 1.0)), float(base.get("offset", 0.0))
        if not (factor and isfinite(factor) and isfinite(offset)):
            raise InputError(f"{shown}, line {node.sourceline}, {label(node)}: factor or offset is no usable number")
        units[name] = Unit.of(name, exponents, factor, offset)
    return units


def _enumerations(root: etree._Element) -> dict[str, dict[str, int]]:
    """Return the enumerations that a file defines."""
    return {
        node.get("name"): {item.get("name"): int(item.get("value")) for item in node.iterfind(f"{SSC}Item")}
        for node in root.iterfind(f"{{*}}Enumerations/{SSC}Enumeration")
    }
