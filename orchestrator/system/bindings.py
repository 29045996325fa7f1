"""Parameter bindings of an SSD: parameter sets (SSV), inline or in files, through mappings (SSM)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from lxml import etree

from ..errors import Fault
from ..fmi.instance import Value
from ..fmi.types import INTEGERS
from .model import Hop, MapTable, Parameter
from .xml import SSC, SSD, SSM, SSV, Document, local

_MIME = "application/x-ssp-"

_READERS: dict[str, Callable[[str], Value]] = {
    **dict.fromkeys(("Real", "Float64", "Float32"), float),
    **dict.fromkeys(("Integer", *INTEGERS), int),
    "Boolean": lambda text: text.strip() in ("true", "1"),
    "String": str,
    "Enumeration": str,
}


def bindings(document: Document, node: etree._Element, notices: list[str]) -> dict[str, Parameter]:
    """Return the values that the parameter bindings of a component or system give; later bindings win.

    Parameters
    ----------
    document : the SSD
    node : the component or system
    notices : takes a sentence for what the standard wants passed over
    """
    values: dict[str, Parameter] = {}
    for binding in node.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        found = {
            binding.get("prefix", "") + name: parameter
            for name, parameter in _values(_content(document, binding, "ParameterValues", "set"), notices)
        }
        mapping = binding.find(f"{SSD}ParameterMapping")
        if mapping is not None:
            found = _mapped(found, _content(document, mapping, "ParameterMapping", "mapping"), notices)
        values.update(found)
    return values


def _content(document: Document, node: etree._Element, kind: str, mime: str) -> Document:
    """Return the parameter set or mapping that a binding or mapping element holds or names."""
    if node.get("type", f"{_MIME}parameter-{mime}") != f"{_MIME}parameter-{mime}":
        raise document.error(node, f"type {node.get('type')!r} is not supported")
    if node.get("sourceBase", "SSD") != "SSD":
        raise document.error(node, "sourceBase 'component' is not supported")
    tag = f"{SSV}ParameterSet" if kind == "ParameterValues" else f"{SSM}ParameterMapping"
    holder = node.find(f"{SSD}{kind}") if kind == "ParameterValues" else node
    inside = [] if holder is None else [child for child in holder if child.tag == tag]
    if node.get("source") is not None:
        if inside:
            raise document.error(node, "has both a source and a content; one is wanted")
        return document.open(node, node.get("source"), kind)
    if len(inside) != 1:
        raise document.error(node, f"has neither source nor {local(etree.Element(tag))} inside")
    return document.inline(inside[0], kind)


def _values(document: Document, notices: list[str]) -> Iterator[tuple[str, Parameter]]:
    """Yield names and values of a parameter set; one that is repeated must be the same."""
    seen: dict[str, Parameter] = {}
    for node in document.root.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        name, parameter = node.get("name"), _parameter(document, node)
        first = seen.setdefault(name, parameter)
        if first is parameter:
            yield name, parameter
        elif replace(first, origin=None) == replace(parameter, origin=None):
            notices.append(Fault(f"{document.where(node)}: the parameter set has it twice, with the same value"))
        else:
            raise document.error(node, f"the parameter set has two of this name, and they differ: {first.origin}")


def _parameter(document: Document, node: etree._Element) -> Parameter:
    """Return the value of one parameter; that of an array as it is written, numbers with blanks between them."""
    typed, kind, text = node[0], local(node[0]), node[0].get("value")
    if kind not in _READERS:
        raise document.error(node, f"type {kind} is not supported")
    if len(typed):
        raise document.error(node, f"is an array of type {kind}; not supported")
    if text is None:
        raise document.error(node, "has no value")
    if _is_list(kind, text):
        return Parameter(text, document.unit(typed.get("unit")), origin=document.where(node))
    if kind == "Enumeration" and typed.get("name") is not None:
        items = document.enumerations.get(typed.get("name"))
        if items is None:
            raise document.error(node, f"the enumeration {typed.get('name')!r} is not defined")
        if text not in items:
            raise document.error(node, f"{text!r} is no item of {typed.get('name')!r}; it has {', '.join(items)}")
    return Parameter(_READERS[kind](text), document.unit(typed.get("unit")), origin=document.where(node))


def _is_list(kind: str, text: str | None) -> bool:
    return kind not in ("String", "Enumeration") and text is not None and len(text.split()) > 1


def _mapped(values: dict[str, Parameter], mapping: Document, notices: list[str]) -> dict[str, Parameter]:
    """Return the values under the names that a mapping gives them; what it does not name is left out."""
    result: dict[str, Parameter] = {}
    for entry in mapping.root.iterfind(f"{SSM}MappingEntry"):
        source, target = entry.get("source"), entry.get("target")
        if target in result:
            raise mapping.error(entry, f"the target {target!r} has a mapping already")
        if source not in values:
            notices.append(f"{mapping.where(entry)}: the parameter set has no {source!r}; the entry maps nothing")
            continue
        result[target] = _transformed(values[source], mapping, entry)
    return result


def _transformed(parameter: Parameter, document: Document, entry: etree._Element) -> Parameter:
    """Return a value after the transformation of a mapping entry."""
    convert = entry.get("suppressUnitConversion", "false") not in ("true", "1")
    for change in entry:
        if local(change) == "LinearTransformation":
            if not isinstance(parameter.value, float):
                raise document.error(entry, f"a LinearTransformation of {parameter.value!r}, which is not Real")
            hop = Hop(None, document.number(change, "factor", 1.0), document.number(change, "offset", 0.0), convert)
            return replace(parameter, hops=(hop,))
        if local(change).endswith("Transformation"):
            return replace(parameter, value=_looked_up(parameter.value, document, entry, change))
    return replace(parameter, hops=(Hop(convert=convert),))


def _looked_up(value: Value, document: Document, entry: etree._Element, change: etree._Element) -> Value:
    """Return the value that a mapping table has for another."""
    found = mapping_table(document, entry, change)
    if type(value) is not {"Boolean": bool, "Integer": int, "Enumeration": str}[found.kind]:
        raise document.error(entry, f"a {found} of {value!r}, which is not {found.kind}")
    table = dict(found.entries)
    if value not in table:
        raise document.error(entry, f"the table has no entry for {value!r}")
    return table[value]


def mapping_table(document: Document, node: etree._Element, change: etree._Element) -> MapTable:
    """Return a mapping transformation of a connection or a mapping entry; a value has one entry.

    Parameters
    ----------
    node : begins messages
    change : the transformation
    """
    kind = local(change).removesuffix("MappingTransformation")
    read: Callable[[str], Value] = _READERS[kind]
    table: dict[Value, Value] = {}
    for item in change.iterfind(f"{SSC}MapEntry"):
        source, target = read(item.get("source")), read(item.get("target"))
        if table.setdefault(source, target) != target:
            value = item.get("source")
            raise document.error(node, f"the {local(change)} has two entries for {value!r}, and they differ")
    return MapTable(kind, tuple(table.items()))
