"""What depends on what within a step, output by output; the stages of stepping that follow from it, out.

FMI has it that an output whose dependencies are not declared depends on all inputs. Where such FMUs feed each other in
a ring, some of what they depend on has to come a step late, and nobody has said which: a choice is made and stated.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from graphlib import CycleError, TopologicalSorter
from typing import TypeVar

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

T = TypeVar("T")

Stages = list[list[str]]

Node = tuple[str, int]
"""Outputs of a component that depend on the same inputs: the component, and a number of their own."""

Edge = tuple[str, str]
"""A component, and one whose outputs depend within a step on its outputs."""


@dataclass(frozen=True)
class Coupling:
    """What an algorithm needs to know of a system.

    Attributes
    ----------
    feeds : for each component the components that its inputs come from
    needs : for each node the nodes that it depends on within a step
    silent : nodes whose dependencies nobody declares, so that they depend on all inputs
    told : stage of a component as an annotation of the system gives it, 0 first; components may be missing
    repeatable : components whose state can be got and set
    """

    feeds: Mapping[str, frozenset[str]]
    needs: Mapping[Node, frozenset[Node]]
    silent: frozenset[Node] = frozenset()
    told: Mapping[str, int] = field(default_factory=dict)
    repeatable: frozenset[str] = frozenset()

    @classmethod
    def of_components(
        cls,
        feeds: Mapping[str, frozenset[str]],
        feedthrough: Mapping[str, bool | None],
        told: Mapping[str, int] | None = None,
    ) -> Coupling:
        """Return the coupling of components whose outputs all depend on all inputs, or on none; None: nobody tells."""
        needs = {(c, 0): frozenset((s, 0) for s in feeds[c] if feedthrough[c] is not False) for c in feeds}
        silent = frozenset((c, 0) for c, known in feedthrough.items() if known is None)
        return cls(feeds, needs, silent, told or {}, frozenset(feeds))

    @cached_property
    def order(self) -> Order:
        """The order of stepping that follows."""
        return Order.of(self)

    def dependent(self) -> list[str]:
        """Return the components that step after what their outputs depend on."""
        return [name for name in self.feeds if name in self.order.dependent]

    def guesses(self) -> list[str]:
        """Return a sentence for each choice that was made because nobody tells the dependencies."""
        return list(self.order.guesses)


@dataclass(frozen=True)
class Order:
    """Who steps after whom.

    Attributes
    ----------
    stages : components, stage by stage; the members of an algebraic loop share a stage
    loops : algebraic loops, each as its members
    dependent : components that step after what their outputs depend on
    guesses : choices that were made because dependencies are not declared, and values that come late, as sentences
    """

    stages: Stages
    loops: list[list[str]]
    dependent: frozenset[str]
    guesses: list[str]

    @classmethod
    def of(cls, coupling: Coupling) -> Order:
        """Return the order of a system."""
        names = list(coupling.feeds)
        loops = _algebraic_loops(coupling)
        together = {name: members[0] for members in loops for name in members}
        declared, silent = _edges(coupling)
        guesses = []
        for ring in _rings(names, declared | silent, together):
            place, guess = _resolve(ring, coupling, declared, silent)
            late = {(s, c) for s, c in declared | silent if s in place and c in place and place[s] >= place[c]}
            late = {(s, c) for s, c in late if together.get(s, s) != together.get(c, c)}
            declared, silent = declared - late, silent - late
            guesses += guess
        edges = declared | silent
        selves = sorted(
            {n[0] for n in coupling.silent if any(s == n[0] for s, _ in coupling.needs[n])}, key=names.index
        )
        guesses += [
            f"{c} feeds itself and does not declare dependencies: it gets its outputs a step late" for c in selves
        ]
        return cls(_stages(names, edges, together), loops, frozenset(c for _, c in edges), guesses)


def _edges(coupling: Coupling) -> tuple[set[Edge], set[Edge]]:
    """Return the dependencies between components: those that an FMU declares, and those that only silence makes."""
    declared: set[Edge] = set()
    silent: set[Edge] = set()
    for node, needed in coupling.needs.items():
        for source, _ in needed:
            if source != node[0]:
                (silent if node in coupling.silent else declared).add((source, node[0]))
    told = coupling.told
    return declared, {(s, c) for s, c in silent - declared if c not in told or told.get(s, 0) < told[c]}


def _algebraic_loops(coupling: Coupling) -> list[list[str]]:
    """Return the members of each ring of outputs that are declared to depend on each other."""
    nodes = list(coupling.needs)
    edges = {(s, n) for n, needed in coupling.needs.items() if n not in coupling.silent for s in needed}
    parts = _components(nodes, edges)
    rings = [part for part in parts if len(part) > 1 or (part[0], part[0]) in edges]
    owners = {(node[0], ring[0][0]) for ring in rings for node in ring}
    merged = _components(list(coupling.feeds), owners | {(b, a) for a, b in owners})
    touched = {name for edge in owners for name in edge}
    return [part for part in merged if touched & set(part)]


def _rings(names: Sequence[str], edges: set[Edge], together: Mapping[str, str]) -> list[list[str]]:
    """Return the components that wait for each other, ring by ring, but for algebraic loops alone."""
    parts = _components(names, edges | {(s, c) for c, s in together.items()} | set(together.items()))
    return [part for part in parts if len({together.get(name, name) for name in part}) > 1]


def _components(names: Sequence[T], edges: Iterable[tuple[T, T]]) -> list[list[T]]:
    """Return the strongly connected parts of a directed graph, each in the order of `names`."""
    index = {name: i for i, name in enumerate(names)}
    pairs = np.array([(index[a], index[b]) for a, b in edges], dtype=int).reshape(-1, 2)
    matrix = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(names), len(names)))
    count, label = connected_components(matrix.tocsr(), directed=True, connection="strong")
    parts: list[list[T]] = [[] for _ in range(count)]
    for name, k in zip(names, label.tolist(), strict=True):
        parts[k].append(name)
    return sorted(parts, key=lambda part: index[part[0]])


def _resolve(
    ring: Sequence[str], coupling: Coupling, declared: set[Edge], silent: set[Edge]
) -> tuple[dict[str, int], list[str]]:
    """Return the places of components that wait for each other, and what has to be said of that choice."""
    inside = set(ring)
    own = {(s, c) for s, c in declared if s in inside and c in inside}
    guessed = {(s, c) for s, c in silent if s in inside and c in inside}
    place = None if own else _two_sides(ring, guessed)
    if place is None:
        place = {name: i for i, name in enumerate(_one_by_one(ring, own, coupling))}
    first = [name for name in ring if place[name] == min(place.values())]
    rest = sorted((name for name in ring if name not in first), key=lambda name: (place[name], ring.index(name)))
    how = f"{_list(first)} first with inputs of the step before, then {_list(rest)}"
    silent_ones = {name for name, _ in coupling.silent}
    quiet = [name for name in ring if name in silent_ones]
    if not guessed:
        return place, [f"{_list(ring)} wait for each other, though no output depends on itself: {how}"]
    return place, [
        f"{_list(quiet)} {'do' if len(quiet) > 1 else 'does'} not declare which outputs depend on which inputs, so FMI "
        f"has them depend on all, and {_list(ring)} wait for each other: {how}; if that is wrong, the annotation "
        '<Component stage="..."/> in the SSD settles it (docs/conventions.md)'
    ]


def _list(names: Sequence[str]) -> str:
    """Return names as messages list them, a few of many."""
    return ", ".join(names) if len(names) <= 6 else f"{', '.join(names[:5])} and {len(names) - 5} more"


def _two_sides(ring: Sequence[str], edges: set[Edge]) -> dict[str, int] | None:
    """Return 0 or 1 for each component so that nobody waits for his own side; None if that cannot be.

    So it is with bodies and the springs between them. The larger side comes first: coupling elements are fewer.
    """
    neighbours: dict[str, set[str]] = {name: set() for name in ring}
    for s, c in edges:
        neighbours[s].add(c)
        neighbours[c].add(s)
    side = {ring[0]: 0}
    waiting = [ring[0]]
    while waiting:
        name = waiting.pop()
        for other in neighbours[name]:
            if other not in side:
                side[other] = 1 - side[name]
                waiting.append(other)
            elif side[other] == side[name]:
                return None
    if 2 * sum(side.values()) > len(ring):
        side = {name: 1 - k for name, k in side.items()}
    return side


def _one_by_one(ring: Sequence[str], declared: set[Edge], coupling: Coupling) -> list[str]:
    """Return components one after the other, as their declared dependencies want it, else in the system's order."""
    number = {name: i for i, name in enumerate(ring)}
    try:
        return _sorted(ring, declared, number)
    except CycleError:  # of components, not of outputs: who has an output early steps early
        level = _levels(coupling, set(ring), number)
        return sorted(ring, key=lambda name: (level.get(name, 0), number[name]))


def _levels(coupling: Coupling, inside: set[str], number: Mapping[str, int]) -> dict[str, int]:
    """Return after how many other outputs the first output of a component can be known; nothing if they are a loop."""
    nodes = {node for node in coupling.needs if node[0] in inside and node not in coupling.silent}
    before = {node: coupling.needs[node] & nodes for node in nodes}
    level: dict[Node, int] = {}
    first: dict[str, int] = {}
    try:
        for node in _sorted(list(nodes), [(s, n) for n in nodes for s in before[n]], {n: number[n[0]] for n in nodes}):
            level[node] = max((1 + level[s] for s in before[node]), default=0)
            first[node[0]] = min(level[node], first.get(node[0], level[node]))
    except CycleError:
        return {}
    return first


def _sorted(names: Sequence[T], edges: Iterable[tuple[T, T]], number: Mapping[T, int]) -> list[T]:
    """Return names so that each edge goes forwards, else by their number."""
    sorter = TopologicalSorter({name: set() for name in names})
    for s, c in edges:
        sorter.add(c, s)
    sorter.prepare()
    result: list[T] = []
    while sorter.is_active():
        ready = sorted(sorter.get_ready(), key=lambda name: number[name])
        result += ready
        sorter.done(*ready)
    return result


def _stages(names: Sequence[str], edges: set[Edge], together: Mapping[str, str]) -> Stages:
    """Return the components stage by stage: each after all that it waits for, and as early as that allows."""
    before: dict[str, set[str]] = {together.get(name, name): set() for name in names}
    for s, c in edges:
        a, b = together.get(s, s), together.get(c, c)
        if a != b:
            before[b].add(a)
    level: dict[str, int] = {}
    for name in TopologicalSorter(before).static_order():
        level[name] = max((1 + level[other] for other in before[name]), default=0)
    stages: Stages = [[] for _ in range(max(level.values(), default=-1) + 1)]
    for name in names:
        stages[level[together.get(name, name)]].append(name)
    return stages
