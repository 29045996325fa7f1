"""SSP archives and SSD files, nested as they are, read into a graph and from there into a flat `System`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePath

from lxml import etree

from ..archive import unpack, zip_faults
from ..errors import Fault, InputError
from .annotations import read_component, read_settings
from .bindings import bindings, mapping_table
from .graph import SOURCES, TARGETS, Graph, Port
from .model import Connector, Element, Hop, Parameter, System, listing
from .xml import SSB, SSC, SSD, Document, local, parse, read_document

_FMU = "application/x-fmu-sharedlibrary"
_SSD = "application/x-ssp-definition"
_SSP = "application/x-ssp-package"
_SSB = "application/x-ssp-signal-dictionary"

DEEPEST = 50
"""Largest number of systems within each other."""

MOST_REFERENCES = 1000
"""Largest number of references to other SSDs and SSPs in a system."""


@dataclass(frozen=True)
class _Place:
    """Where in the nested system the reader is.

    Attributes
    ----------
    document : the file
    path : full name of the system, empty for the root
    values : for this system from the levels above, by name
    dictionaries : signal dictionaries in reach: the name that their ports have as owner, by name
    depth : number of systems around
    """

    document: Document
    path: str
    values: Mapping[str, Parameter]
    dictionaries: Mapping[str, str]
    depth: int = 0

    def full(self, name: str) -> str:
        """Return the full name of an element of this system."""
        return f"{self.path}.{name}" if self.path else name

    def below(self, name: str, values: Mapping[str, Parameter], dictionaries: Mapping[str, str]) -> _Place:
        """Return the place of an element of this system, with what the values here say of it."""
        part = {key.removeprefix(f"{name}."): v for key, v in values.items() if key.startswith(f"{name}.")}
        return replace(self, path=self.full(name), values=part, dictionaries=dictionaries, depth=self.depth + 1)


def read_archive(path: Path, variant: str | None) -> System:
    """Return the system of an .ssp file."""
    faults: list[str] = []
    folder, file, names = _variant(path, variant, faults)
    system = read_description(file, folder, f"{path}: {file.name}")
    return replace(system, path=path, variants=names, notices=(*zip_faults(path), *faults, *system.notices))


def _variant(path: Path, variant: str | None, notices: list[str]) -> tuple[Path, Path, tuple[str, ...]]:
    """Return the folder of an unpacked archive, the SSD of a variant, and the names of all variants.

    Another variant that cannot be read is passed over with a notice.
    """
    folder = unpack(path, "SSP")
    default = folder / "SystemStructure.ssd"
    if not default.is_file():
        raise InputError(f"{path}: holds no SystemStructure.ssd, so it is not an SSP")
    files = [default, *(f for f in sorted(folder.glob("*.ssd")) if f != default)]
    names: dict[Path, str] = {}
    for file in files:
        try:
            names[file] = str(parse(file, f"{path}: {file.name}").get("name"))
        except InputError as error:
            if file.name in (variant, None if variant else default.name):
                raise
            notices.append(Fault(f"{error}; another variant is read"))
    if variant is None:
        return folder, default, tuple(names.values())
    for file, name in names.items():
        if variant in (name, file.name):
            return folder, file, tuple(names.values())
    raise InputError(f"{path}: has no variant {variant!r}; it has {listing(sorted(names.values()))}")


def read_description(file: Path, folder: Path, shown: str) -> System:
    """Return the system of an SSD file.

    Parameters
    ----------
    file : the SSD
    folder : no source may leave it
    shown : how messages name the file
    """
    document = read_document(file, "Description", folder, shown)
    name = PurePath(document.root.get("name").replace("\\", "/"))
    if name.is_absolute() or ".." in name.parts:
        raise document.error(document.root, "results could not be called so; refused")
    graph = Graph()
    _read_system(graph, _Place(document, "", {}, {}), document.root.find(f"{SSD}System"))
    elements, wires, outputs = graph.flatten()
    settings = read_settings(document, graph.notices)
    return System(
        name=document.root.get("name"), path=file, elements=elements, wires=wires, outputs=outputs,
        start=settings.start, stop=settings.stop, step_size=settings.step_size, algorithm=settings.algorithm,
        version=document.root.get("version"), variants=(document.root.get("name"),), notices=tuple(graph.notices),
    )  # fmt: skip


def _read_system(graph: Graph, place: _Place, node: etree._Element) -> None:
    """Add a system and what is in it to the graph."""
    document = place.document
    if place.depth > DEEPEST:
        raise document.error(node, f"has {place.depth} systems around it; at most {DEEPEST} are read")
    values = {**bindings(document, node, graph.notices), **place.values}
    dictionaries = {**place.dictionaries, **_read_dictionaries(graph, place, node)}
    connectors = _read_connectors(document, node)
    graph.connectors.update({Port(place.path, name): connector for name, connector in connectors.items()})
    graph.values.update({Port(place.path, name): value for name, value in values.items() if name in connectors})
    kinds: dict[str, str] = {}
    references = []
    for child in node.iterfind(f"{SSD}Elements/*"):
        name = child.get("name")
        if name in kinds:
            raise document.error(child, f"two elements are named {name!r}")
        kinds[name] = local(child)
        inside = place.below(name, values, dictionaries)
        if kinds[name] == "Component":
            kinds[name] = _read_component(graph, inside, child)
        elif kinds[name] == "System":
            _read_system(graph, inside, child)
        else:
            references.append((_read_reference(graph, inside, child), child))
    for name, value in values.items():
        if name not in connectors and not any(name.startswith(f"{element}.") for element in kinds):
            graph.notices.append(f"{value.origin}: no component has it, so it is not applied")
    for connection in node.iterfind(f"{SSD}Connections/{SSD}Connection"):
        _read_connection(graph, place, connection, kinds)
    for dictionary, child in references:
        _link_reference(graph, place, child, dictionary)


def _read_component(graph: Graph, place: _Place, node: etree._Element) -> str:
    """Add a component to the graph, or the system that it refers to; return which."""
    document, name = place.document, place.path
    kind, source = node.get("type", _FMU), node.get("source")
    if source is None:
        raise document.error(node, "has no source, so there is nothing to simulate")
    values = {**bindings(document, node, graph.notices), **place.values}
    if kind in (_SSD, _SSP):
        _read_referenced(graph, replace(place, values=values, dictionaries={}), node)
        return "System"
    if kind != _FMU:
        raise document.error(node, f"type {kind} is not supported; FMUs, SSDs and SSPs are")
    wanted = node.get("implementation", "any")
    if wanted not in ("any", "CoSimulation"):
        graph.notices.append(Fault(f"{document.where(node)}: wants {wanted}; it is run as co-simulation"))
    connectors = _read_connectors(document, node)
    graph.connectors.update({Port(name, key): connector for key, connector in connectors.items()})
    stage, step = read_component(document, node, graph.notices)
    graph.elements[name] = Element(name, document.resolve(node, source), values, connectors, stage, step)
    return "Component"


def _read_referenced(graph: Graph, place: _Place, node: etree._Element) -> None:
    """Add the system of another SSD or SSP that a component refers to."""
    document, source = place.document, node.get("source")
    graph.references += 1
    if graph.references > MOST_REFERENCES:
        raise document.error(node, f"the system refers to other files more than {MOST_REFERENCES} times; refused")
    location, _, variant = source.partition("#")
    if not location:
        raise document.error(node, "a reference into the same file is not supported")
    if node.get("type") == _SSD:
        inner = document.open(node, location, "Description")
    else:
        package = document.resolve(node, location)
        folder, file, _ = _variant(package, variant or None, graph.notices)
        inner = read_document(file, "Description", folder, f"{package.name}: {file.name}")
    _read_system(graph, replace(place, document=inner), inner.root.find(f"{SSD}System"))
    for name, outside in _read_connectors(document, node).items():
        inside = graph.connectors.get(Port(place.path, name))
        if inside is None or (outside.kind, outside.unit or inside.unit) != (inside.kind, inside.unit):
            raise document.error(node, f"its connector {name!r} is not as in {source}")


def _read_connectors(document: Document, node: etree._Element) -> dict[str, Connector]:
    """Return the connectors of an element by name."""
    found: dict[str, Connector] = {}
    for connector in node.iterfind(f"{SSD}Connectors/{SSD}Connector"):
        name = connector.get("name")
        if name in found:
            raise document.error(connector, f"{node.get('name')!r} has two connectors of this name")
        typed = next((child for child in connector if child.tag.startswith(SSC) and local(child) != "Dimension"), None)
        found[name] = Connector(
            connector.get("kind"),
            None if typed is None else local(typed),
            None if typed is None else document.unit(typed.get("unit")),
        )
    return found


def _read_connection(graph: Graph, place: _Place, node: etree._Element, kinds: Mapping[str, str]) -> None:
    """Add a connection to the graph, in the direction that its connectors' kinds give."""
    document = place.document
    ends = [_read_end(graph, place, node, end, kinds) for end in ("start", "end")]
    (start, start_gives), (end, end_gives) = ends
    if start_gives is not None and start_gives == end_gives:
        verb = "give" if start_gives else "take"
        raise document.error(node, f"both connectors {verb} values: {start} and {end}")
    source, target = (end, start) if start_gives is False or end_gives else (start, end)
    factor, offset, declared, table = 1.0, 0.0, False, None
    for change in node:
        if local(change) == "LinearTransformation":
            declared = True
            factor, offset = document.number(change, "factor", 1.0), document.number(change, "offset", 0.0)
        elif local(change).endswith("Transformation"):
            table = mapping_table(document, node, change)
    convert = node.get("suppressUnitConversion", "false") not in ("true", "1")
    unit = graph.connectors.get(target, Connector()).unit
    graph.connect(source, target, Hop(unit, factor, offset, convert, declared, table), document.where(node))


def _read_end(
    graph: Graph, place: _Place, node: etree._Element, end: str, kinds: Mapping[str, str]
) -> tuple[Port, bool | None]:
    """Return a connector at an end of a connection, and whether it gives values; None: both or unknown.

    An element of a component's array has its indices in its name, counted from 1, as the FMU's variables have them.
    """
    document, element, name = place.document, node.get(f"{end}Element"), node.get(f"{end}Connector")
    if element == "":
        graph.notices.append(Fault(f"{document.where(node)}: {end}Element is empty; read as the system itself"))
        element = None
    if element is not None and element not in kinds:
        raise document.error(node, f"names the component {element!r}; there are {listing(kinds)}")
    port = Port(place.path if element is None else place.full(element), name)
    connector = graph.connectors.get(port)
    indices = node.get(f"{end}Indices")
    if element is None or kinds[element] != "Component":
        owner = "this system" if element is None else f"{kinds[element]} {element!r}"
        if connector is None:
            raise document.error(node, f"{owner} has no connector {name!r}")
        if indices is not None:
            raise document.error(node, f"{end}Indices at a connector of {owner} are not supported")
    if indices is not None:
        port = Port(port.owner, f"{name}[{','.join(indices.split())}]")
        graph.connectors[port] = connector or Connector()
    if connector is None:
        return port, None
    if connector.type in ("Clock", "Binary"):
        raise document.error(node, f"{port} is of type {connector.type}; not supported")
    gives, takes = connector.kind in SOURCES, connector.kind in TARGETS
    if not gives and not takes:
        return port, None
    return port, gives == (element is not None)


def _read_dictionaries(graph: Graph, place: _Place, node: etree._Element) -> dict[str, str]:
    """Add the signal dictionaries of a system to the graph; return the owners of their ports by name."""
    owners = {}
    for dictionary in node.iterfind(f"{SSD}SignalDictionaries/{SSD}SignalDictionary"):
        if dictionary.get("type", _SSB) != _SSB:
            raise place.document.error(dictionary, f"type {dictionary.get('type')!r} is not supported")
        inside = [child for child in dictionary if child.tag == f"{SSB}SignalDictionary"]
        if dictionary.get("source") is not None:
            content = place.document.open(dictionary, dictionary.get("source"), "SignalDictionary")
        elif len(inside) == 1:
            content = place.document.inline(inside[0], "SignalDictionary")
        else:
            raise place.document.error(dictionary, "has neither source nor SignalDictionary inside")
        owner = f"signal dictionary {place.full(dictionary.get('name'))}"
        owners[dictionary.get("name")] = owner
        for entry in content.root.iterfind(f"{SSB}DictionaryEntry"):
            unit = content.unit(entry[0].get("unit"))
            graph.connectors[Port(owner, entry.get("name"))] = Connector("inout", local(entry[0]), unit)
    return owners


def _read_reference(graph: Graph, place: _Place, node: etree._Element) -> str:
    """Add the connectors of a reference to a signal dictionary; return the owner of the dictionary's ports."""
    name = node.get("dictionary")
    if name not in place.dictionaries:
        raise place.document.error(node, f"there is no signal dictionary {name!r}")
    for key, connector in _read_connectors(place.document, node).items():
        if Port(place.dictionaries[name], key) not in graph.connectors:
            raise place.document.error(node, f"the signal dictionary {name!r} has no entry {key!r}")
        graph.connectors[Port(place.path, key)] = replace(connector, kind="inout")
    return place.dictionaries[name]


def _link_reference(graph: Graph, place: _Place, node: etree._Element, dictionary: str) -> None:
    """Connect a reference to its dictionary: what is connected to it feeds the entry, else the entry feeds it."""
    where = place.document.where(node)
    for name in _read_connectors(place.document, node):
        own, entry = Port(place.full(node.get("name")), name), Port(dictionary, name)
        source, target = (own, entry) if own in graph.edges else (entry, own)
        graph.connect(source, target, Hop(graph.connectors[target].unit), where)


def read_system(path: Path, variant: str | None = None) -> System:
    """Return the system that an .ssp archive or an .ssd file describes.

    Parameters
    ----------
    path : the file; `name.ssp#variant` names a variant, too
    variant : name, or file name, of the system structure description in the archive; default SystemStructure.ssd

    Raises
    ------
    InputError
        For a file that is missing, malformed, not valid against the schemas of SSP 1.0 or 2.0, or that uses what is
        not supported.
    """
    pass

    if path.suffix == ".ssd" and path.is_file():
        return read_description(path, path.parent, str(path))
    archive, mark, name = path.name.partition("#")
    if mark and variant is None and Path(archive).suffix == ".ssp":
        return read_archive(path.with_name(archive), name)
    if path.suffix == ".ssd":
        raise InputError(f"{path}: no such SSD file")
    return read_archive(path, variant)
