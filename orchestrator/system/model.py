"""What a system is: components, connections, parameters; and reading one from an SSP or SSD file. No FMUs are loaded.

What the files say and this reader does not support is an error that names it; nothing is ignored silently.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..errors import InputError
from ..fmi.instance import Value
from ..units import Unit, unit_name


@dataclass(frozen=True)
class MapTable:
    """A mapping transformation of SSP: values by values.

    Attributes
    ----------
    kind : Boolean, Integer or Enumeration
    entries : pairs of a value and what it becomes: true or false, whole numbers, names of items
    """

    kind: str
    entries: tuple[tuple[Value, Value], ...]

    def then(self, other: MapTable) -> MapTable:
        """Return one table for two; what the second one does not have drops out."""
        further = dict(other.entries)
        return MapTable(self.kind, tuple((s, further[t]) for s, t in self.entries if t in further))

    def texts(self) -> list[tuple[str, str]]:
        """Return the entries as files have them."""
        words = [str(v).lower() if isinstance(v, bool) else str(v) for pair in self.entries for v in pair]
        return list(zip(words[::2], words[1::2], strict=True))

    def __str__(self) -> str:
        """Return its name in SSP."""
        return f"{self.kind}MappingTransformation"


@dataclass(frozen=True)
class Hop:
    """One step of a value's way: target = factor * (value in the target's unit) + offset.

    Attributes
    ----------
    unit : of the connector where the step ends; None: not told, the value keeps its own
    factor, offset : linear transformation, after the change of units
    convert : whether units are converted
    declared : whether the file states the transformation
    table : looks the value up instead; None if there is none
    """

    unit: Unit | str | None = None
    factor: float = 1.0
    offset: float = 0.0
    convert: bool = True
    declared: bool = False
    table: MapTable | None = None


@dataclass(frozen=True)
class Parameter:
    """A value for a parameter or a start value.

    Attributes
    ----------
    value : as given; the name of an item for an enumeration; the elements of an array in a text, row by row
    unit : the unit that it is given in; None: the FMU's own
    hops : its way to the FMU's variable, for a value that is mapped or comes through connectors of systems
    origin : file, line and element that give it; None: the user
    """

    value: Value
    unit: Unit | str | None = None
    hops: tuple[Hop, ...] = (Hop(),)
    origin: str | None = None


@dataclass(frozen=True)
class Connector:
    """What an SSD says of a connector; None where it says nothing.

    Attributes
    ----------
    kind : input, output, parameter, ...
    type : Real, Integer, ...
    unit : of a real connector
    """

    kind: str | None = None
    type: str | None = None
    unit: Unit | str | None = None


@dataclass(frozen=True)
class Element:
    """A component of the system.

    Attributes
    ----------
    name : with the names of the systems around it, such as `train.wheel`
    source : its FMU file
    parameters : values by variable name
    connectors : what the SSD says of its connectors
    stage : place in the order of stepping that an annotation gives it, None if none does
    step : step of its own that an annotation gives it [s], None if none does
    replaced : whether the user put another FMU in its place: what the SSD says of units and values was of the first one
    """

    name: str
    source: Path
    parameters: dict[str, Parameter] = field(default_factory=dict)
    connectors: dict[str, Connector] = field(default_factory=dict)
    stage: int | None = None
    step: float | None = None
    replaced: bool = False

    @property
    def units(self) -> dict[str, str]:
        """Names of the units that the SSD gives to connectors."""
        return {name: unit_name(c.unit) for name, c in self.connectors.items() if c.unit}


@dataclass(frozen=True)
class Wire:
    """A connection of two components' variables, through any number of connectors of systems between them.

    An `end_element` that is empty stands for the system itself: its output is another name for a component's.
    """

    start_element: str
    start_connector: str
    end_element: str
    end_connector: str
    hops: tuple[Hop, ...] = (Hop(),)

    @property
    def factor(self) -> float:
        """Factor of the linear transformations on the way, besides changes of units."""
        product = 1.0
        for hop in self.hops:
            product *= hop.factor
        return product

    @property
    def offset(self) -> float:
        """Offset of the linear transformations on the way, besides changes of units."""
        total = 0.0
        for hop in self.hops:
            total = hop.factor * total + hop.offset
        return total

    def __str__(self) -> str:
        """Return the connection as messages name it."""
        end = ".".join(filter(None, (self.end_element, self.end_connector)))
        return f"{self.start_element}.{self.start_connector} -> {end}"


@dataclass(frozen=True)
class System:
    """A system to simulate, flat: systems in systems have become longer names.

    Attributes
    ----------
    name : name of the system structure description
    path : where it came from
    elements : components by name, in the file's order
    wires : connections
    outputs : outputs of the system itself, each another name for a component's
    start, stop : default experiment [s]
    step_size : communication step [s], None if the file does not say
    algorithm : name of the master algorithm, None if the file does not say
    version : of the SSP standard that the description follows
    variants : names of all system structure descriptions in the archive
    notices : what the reader passed over, as the standard wants it, one sentence each
    """

    name: str
    path: Path
    elements: dict[str, Element]
    wires: tuple[Wire, ...]
    outputs: tuple[Wire, ...] = ()
    start: float = 0.0
    stop: float | None = None
    step_size: float | None = None
    algorithm: str | None = None
    version: str = "1.0"
    variants: tuple[str, ...] = ()
    notices: tuple[str, ...] = ()

    @property
    def stages(self) -> dict[str, int]:
        """Places in the order of stepping, by name of those components that the file gives one."""
        return {name: e.stage for name, e in self.elements.items() if e.stage is not None}

    def with_sources(self, sources: dict[str, Path]) -> System:
        """Return this system with other FMUs in some places."""
        elements = dict(self.elements)
        for name, source in sources.items():
            if name not in elements:
                raise InputError(f"replace {name}: the system has no component {name!r}; it has {listing(elements)}")
            elements[name] = replace(elements[name], source=source, replaced=True)
        return replace(self, elements=elements)

    def with_parameters(self, values: dict[str, dict[str, Value]]) -> System:
        """Return this system with other parameter values, by component and variable name.

        For a component in a system within the system the first dot may stand anywhere in its name.
        """
        elements = dict(self.elements)
        for first, more in values.items():
            for rest, value in more.items():
                full = f"{first}.{rest}"
                name = max((n for n in elements if full.startswith(f"{n}.")), key=len, default=None)
                if name is None:
                    raise InputError(f"set {first}: the system has no component {first!r}; it has {listing(elements)}")
                changed = {full.removeprefix(f"{name}."): Parameter(value)}
                elements[name] = replace(elements[name], parameters={**elements[name].parameters, **changed})
        return replace(self, elements=elements)


def listing(names: Iterable[str]) -> str:
    """Return names as messages list them."""
    return ", ".join(names) or "none"
