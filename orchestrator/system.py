"""An SSP or SSD file in, a `System` out: components, connections, parameters. No FMUs are loaded.

What the files say and this reader does not support is an error that names it; nothing is ignored silently.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import fmpy.ssp
from lxml import etree

from .archive import unpack
from .errors import InputError
from .fmu import Value

_BASE = "http://ssp-standard.org/SSP1/"
SSD = f"{{{_BASE}SystemStructureDescription}}"
SSC = f"{{{_BASE}SystemStructureCommon}}"
SSV = f"{{{_BASE}SystemStructureParameterValues}}"
MASTER = "{urn:curvesqueal:ssp}Master"
OSP_STEP = "{http://opensimulationplatform.com/SSP/OSPAnnotations}FixedStepAlgorithm"


@dataclass(frozen=True)
class Parameter:
    """A parameter value and the unit it is given in; None: the FMU's own."""

    value: Value
    unit: str | None = None


@dataclass(frozen=True)
class Element:
    """A component of the system.

    Attributes
    ----------
    name : name in the system
    source : its FMU file
    parameters : values by variable name
    units : units that the SSD gives to connectors
    """

    name: str
    source: Path
    parameters: dict[str, Parameter] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Wire:
    """A connection: end = factor * start + offset, besides a change of units."""

    start_element: str
    start_connector: str
    end_element: str
    end_connector: str
    factor: float = 1.0
    offset: float = 0.0

    def __str__(self) -> str:
        """Return the connection as messages name it."""
        return f"{self.start_element}.{self.start_connector} -> {self.end_element}.{self.end_connector}"


@dataclass(frozen=True)
class System:
    """A system to simulate.

    Attributes
    ----------
    name : name of the system structure description
    path : where it came from
    elements : components by name, in the file's order
    wires : connections
    start, stop : default experiment [s]
    step_size : communication step [s], None if the file does not say
    algorithm : name of the master algorithm, None if the file does not say
    """

    name: str
    path: Path
    elements: dict[str, Element]
    wires: tuple[Wire, ...]
    start: float = 0.0
    stop: float | None = None
    step_size: float | None = None
    algorithm: str | None = None

    def with_sources(self, sources: dict[str, Path]) -> System:
        """Return this system with other FMUs in some places."""
        elements = dict(self.elements)
        for name, source in sources.items():
            if name not in elements:
                raise InputError(f"--replace {name}: the system has no component {name!r}; it has {_list(elements)}")
            elements[name] = replace(elements[name], source=source)
        return replace(self, elements=elements)

    def with_parameters(self, values: dict[str, dict[str, Value]]) -> System:
        """Return this system with other parameter values, by component and variable name."""
        elements = dict(self.elements)
        for name, more in values.items():
            if name not in elements:
                raise InputError(f"--set {name}: the system has no component {name!r}; it has {_list(elements)}")
            changed = {key: Parameter(value) for key, value in more.items()}
            elements[name] = replace(elements[name], parameters={**elements[name].parameters, **changed})
        return replace(self, elements=elements)


def _list(names: Any) -> str:
    return ", ".join(names) or "none"


def read_system(path: Path, variant: str | None = None) -> System:
    """Return the system that an .ssp archive or an .ssd file describes.

    Parameters
    ----------
    path : the file
    variant : name of the system structure description in the archive; default the one in SystemStructure.ssd

    Raises
    ------
    InputError
        For a file that is missing, malformed, not valid against the SSP 1.0 schema, or that uses what is not supported.
    """
    if path.suffix == ".ssd":
        if not path.is_file():
            raise InputError(f"{path}: no such SSD file")
        return _read_description(path, path.parent, path)
    folder = unpack(path, "SSP")
    if not (folder / "SystemStructure.ssd").is_file():
        raise InputError(f"{path}: holds no SystemStructure.ssd, so it is not an SSP")
    if variant is None:
        return _read_description(folder / "SystemStructure.ssd", folder, path)
    names = []
    for file in sorted(folder.glob("*.ssd")):
        names.append(_parse(file, "SystemStructureDescription", path).get("name"))
        if names[-1] == variant:
            return _read_description(file, folder, path)
    raise InputError(f"{path}: has no variant {variant!r}; it has {_list(sorted(names))}")


@cache
def _schema(name: str) -> etree.XMLSchema:
    return etree.XMLSchema(etree.parse(Path(fmpy.ssp.__file__).parent / "schema" / f"{name}.xsd"))


def _parse(file: Path, schema: str, shown: Path) -> etree._Element:
    """Return the root of an XML file that is valid against an SSP schema; entities are not expanded."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        document = etree.parse(file, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(f"{shown}: {file.name} is not well-formed XML: {error}") from None
    if document.docinfo.internalDTD is not None:
        raise InputError(f"{shown}: {file.name} has a document type declaration; refused")
    checker = _schema(schema)
    if not checker.validate(document):
        first = checker.error_log[0]
        raise InputError(f"{shown}: {file.name}, line {first.line}: {first.message}")
    return document.getroot()


def _read_description(file: Path, folder: Path, shown: Path) -> System:
    root = _parse(file, "SystemStructureDescription", shown)
    system = root.find(f"{SSD}System")
    _refuse(system, ("SignalDictionaries", "Connectors"), shown)
    elements: dict[str, Element] = {}
    for node in system.iterfind(f"{SSD}Elements/*"):
        if node.tag != f"{SSD}Component":
            raise InputError(f"{shown}: {_local(node)} {node.get('name')!r} is not supported; only Component is")
        element = _read_component(node, folder, shown)
        if element.name in elements:
            raise InputError(f"{shown}: two components are named {element.name!r}")
        elements[element.name] = element
    for name, parameter in _bindings(system, folder, shown):
        target, _, variable = name.partition(".")
        if target not in elements or not variable:
            raise InputError(f"{shown}: parameter {name!r} of the system belongs to no component")
        elements[target].parameters[variable] = parameter
    experiment = root.find(f"{SSD}DefaultExperiment")
    master = _find_anywhere(root, MASTER)
    step = master.get("stepSize") if master is not None else None
    if step is None:
        fixed = _find_anywhere(root, OSP_STEP)
        step = fixed.get("baseStepSize") if fixed is not None else None
    return System(
        name=root.get("name"),
        path=shown,
        elements=elements,
        wires=tuple(_wires(system, elements, shown)),
        start=float(experiment.get("startTime", 0.0)) if experiment is not None else 0.0,
        stop=float(experiment.get("stopTime")) if experiment is not None and experiment.get("stopTime") else None,
        step_size=float(step) if step else None,
        algorithm=master.get("algorithm") if master is not None else None,
    )


def _local(node: etree._Element) -> str:
    return str(etree.QName(node).localname)


def _refuse(node: etree._Element, names: tuple[str, ...], shown: Path) -> None:
    """Raise InputError if the system uses an element that is not supported."""
    for name in names:
        found = node.find(f"{SSD}{name}")
        if found is not None and len(found):
            raise InputError(f"{shown}: {name} of system {node.get('name')!r} are not supported")


def _find_anywhere(root: etree._Element, tag: str) -> etree._Element | None:
    return next(root.iter(tag), None)


def _resolve(source: str, folder: Path, shown: Path) -> Path:
    """Return the file that a source attribute names, which must lie below the folder of the system."""
    path = (folder / unquote(source)).resolve()
    if not path.is_relative_to(folder.resolve()):
        raise InputError(f"{shown}: source {source!r} lies outside the system's folder; refused")
    return path


def _read_component(node: etree._Element, folder: Path, shown: Path) -> Element:
    name = node.get("name")
    kind = node.get("type", "application/x-fmu-sharedlibrary")
    if kind != "application/x-fmu-sharedlibrary":
        raise InputError(f"{shown}: component {name!r} is of type {kind}; only FMUs are supported")
    units = {}
    for connector in node.iterfind(f"{SSD}Connectors/{SSD}Connector"):
        for real in connector.iterfind(f"{SSC}Real"):
            if real.get("unit"):
                units[connector.get("name")] = real.get("unit")
    return Element(name, _resolve(node.get("source"), folder, shown), dict(_bindings(node, folder, shown)), units)


def _bindings(node: etree._Element, folder: Path, shown: Path) -> Iterator[tuple[str, Parameter]]:
    """Yield the parameters that the bindings of a component or system give."""
    for binding in node.iterfind(f"{SSD}ParameterBindings/{SSD}ParameterBinding"):
        if binding.find(f"{SSD}ParameterMapping") is not None:
            raise InputError(f"{shown}: the ParameterMapping of {node.get('name')!r} is not supported")
        inline = binding.find(f"{SSD}ParameterValues/{SSV}ParameterSet")
        if inline is None and not binding.get("source"):
            raise InputError(f"{shown}: a ParameterBinding of {node.get('name')!r} has neither source nor values")
        if inline is None:
            file = _resolve(binding.get("source"), folder, shown)
            if not file.is_file():
                raise InputError(f"{shown}: the parameter set {binding.get('source')!r} is missing")
            inline = _parse(file, "SystemStructureParameterValues", shown)
        for parameter in inline.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
            yield binding.get("prefix", "") + parameter.get("name"), _parameter(parameter[0], shown)


def _parameter(node: etree._Element, shown: Path) -> Parameter:
    """Return the value of an SSV parameter."""
    text = node.get("value")
    convert: dict[str, Any] = {
        "Real": float,
        "Integer": int,
        "Boolean": lambda t: t in ("true", "1"),
        "String": str,
    }
    kind = _local(node)
    if kind not in convert:
        raise InputError(f"{shown}: parameter {node.getparent().get('name')!r} is of type {kind}; not supported")
    return Parameter(convert[kind](text), node.get("unit"))


def _wires(system: etree._Element, elements: dict[str, Element], shown: Path) -> Iterator[Wire]:
    for node in system.iterfind(f"{SSD}Connections/{SSD}Connection"):
        for end in ("startElement", "endElement"):
            if node.get(end) is None:
                raise InputError(f"{shown}: a connection to the system's own connector is not supported")
            if node.get(end) not in elements:
                raise InputError(
                    f"{shown}: a connection names the component {node.get(end)!r}; there are {_list(elements)}"
                )
        factor, offset = 1.0, 0.0
        for change in node:
            if _local(change) == "LinearTransformation":
                factor, offset = float(change.get("factor", 1.0)), float(change.get("offset", 0.0))
            elif _local(change).endswith("Transformation"):
                raise InputError(f"{shown}: a {_local(change)} of a connection is not supported")
        yield Wire(
            node.get("startElement"), node.get("startConnector"), node.get("endElement"), node.get("endConnector"),
            factor, offset,
        )  # fmt: skip
