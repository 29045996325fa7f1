"""Connectors of a nested system and the connections between them, and the flat system that they mean.

Every connection carries its value one way, from a source to a target, and a target has one source. So each variable of
a component is followed upstream: it ends at another component's variable, which makes a wire, or at a connector that
nothing feeds, whose value it takes.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

from ..errors import InputError
from .model import Connector, Element, Hop, Parameter, Wire

SOURCES = frozenset(("output", "calculatedParameter", "constant", "local"))
"""Kinds of an element's connectors that values leave."""

TARGETS = frozenset(("input", "parameter", "structuralParameter"))
"""Kinds of an element's connectors that take values."""


class Port(NamedTuple):
    """A connector: the name of its component or system, empty for the root system, and its own."""

    owner: str
    name: str

    def __str__(self) -> str:
        """Return the name that messages use."""
        return ".".join(filter(None, self))


@dataclass(frozen=True)
class Edge:
    """A connection, in the direction that the value goes.

    Attributes
    ----------
    source : where the value comes from
    hop : what happens to it
    where : file, line and element
    """

    source: Port
    hop: Hop
    where: str


@dataclass
class Graph:
    """A nested system, while it is read.

    Attributes
    ----------
    elements : components by full name
    connectors : of components, systems and signal dictionaries
    edges : by target
    values : of connectors of systems, in the connectors' units
    notices : what was passed over
    references : number of references to other files that were followed
    """

    elements: dict[str, Element] = field(default_factory=dict)
    connectors: dict[Port, Connector] = field(default_factory=dict)
    edges: dict[Port, Edge] = field(default_factory=dict)
    values: dict[Port, Parameter] = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)
    references: int = 0

    def connect(self, source: Port, target: Port, hop: Hop, where: str) -> None:
        """Add a connection.

        Raises
        ------
        InputError
            If the target has a source already.
        """
        if target in self.edges:
            raise InputError(f"{where}: {target} is fed by two connections")
        self.edges[target] = Edge(source, hop, where)

    def upstream(self, port: Port) -> list[tuple[Port, Hop]]:
        """Return the way to a connector, from its origin on: the ports on it, each with the hop that leaves it.

        Raises
        ------
        InputError
            If the connections go in a circle.
        """
        way: list[tuple[Port, Hop]] = []
        passed = {port}
        while port in self.edges:
            edge = self.edges[port]
            way.insert(0, (edge.source, edge.hop))
            port = edge.source
            if port in passed:
                raise InputError(f"{edge.where}: the connections go in a circle")
            passed.add(port)
        return way

    def flatten(self) -> tuple[dict[str, Element], tuple[Wire, ...], tuple[Wire, ...]]:
        """Return components with the values that reach them, wires between them, and outputs of the system."""
        elements = dict(self.elements)
        wires: list[Wire] = []
        outputs: list[Wire] = []
        idle = {port for port in self.values if self.connectors[port].kind not in TARGETS or port not in self.edges}
        for target in self.edges:
            if target.owner and target.owner not in elements:
                continue
            way = self.upstream(target)
            origin = way[0][0]
            if origin.owner in elements:
                wire = Wire(origin.owner, origin.name, target.owner, target.name, tuple(hop for _, hop in way))
                (wires if target.owner else outputs).append(wire)
            elif target.owner:
                value = self._value(way)
                idle.difference_update(port for port, _ in way)
                if value is not None:
                    element = elements[target.owner]
                    parameters = {**element.parameters, target.name: value}
                    elements[target.owner] = replace(element, parameters=parameters)
            else:
                self.notices.append(f"{self.edges[target].where}: no component feeds the system's output {target}")
        for port in sorted(idle):
            self.notices.append(f"{self.values[port].origin}: the connector {port} passes no value on; not applied")
        return elements, tuple(wires), tuple(outputs)

    def _value(self, way: list[tuple[Port, Hop]]) -> Parameter | None:
        """Return the value that goes a way which begins at a connector that nothing feeds; the first one counts."""
        for place, (port, _) in enumerate(way):
            if port in self.values:
                value = self.values[port]
                *before, last = value.hops
                here = replace(last, unit=self.connectors[port].unit)
                return replace(value, hops=(*before, here, *(hop for _, hop in way[place:])))
        return None
