"""Random systems of systems of blocks, run by the master, against an evaluation that knows nothing of SSP."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from block_systems import archive, component, connector, description, inline, simulate, system, wire
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

METRES = {"": None, "m": 1.0, "mm": 1e-3, "km": 1e3}


@dataclass(frozen=True)
class Block:
    """A component y = k u + b with units at its ends; `level` says how many systems up its parameters are bound."""

    k: float
    b: float
    units: tuple[str, str]
    level: int


@dataclass(frozen=True)
class Chain:
    """A system: its parts one after the other, between an input and an output with units; a change per connection."""

    parts: tuple[Block | Chain, ...]
    units: tuple[str, str]
    changes: tuple[tuple[float, float], ...]


numbers = st.integers(-8, 8).map(lambda n: n / 4)
units = st.tuples(*2 * [st.sampled_from(sorted(METRES))])
blocks = st.builds(Block, numbers, numbers, units, st.integers(0, 3))


def chains(parts: st.SearchStrategy[Block | Chain]) -> st.SearchStrategy[Chain]:
    """Return chains of up to three parts."""
    return st.lists(parts, min_size=1, max_size=3).flatmap(
        lambda found: st.builds(
            Chain,
            st.just(tuple(found)),
            units,
            st.tuples(*(len(found) + 1) * [st.tuples(numbers.filter(bool), numbers)]),
        )
    )


trees = chains(st.recursive(blocks, chains, max_leaves=5))


def flat(node: Block | Chain, value: float, unit: str) -> tuple[float, str]:
    """Return what leaves a part if a value in a unit enters it, and its unit; no unit keeps the value's."""
    if isinstance(node, Block):
        return node.k * converted(value, unit, node.units[0]) + node.b, node.units[1]
    entered = node.units[0] or unit
    value, unit = converted(value, unit, entered), entered
    targets = [*(part.units[0] for part in node.parts), node.units[1]]
    for place, (factor, offset) in enumerate(node.changes):
        value = factor * converted(value, unit, targets[place]) + offset
        unit = targets[place] or unit
        if place < len(node.parts):
            value, unit = flat(node.parts[place], value, unit)
    return value, unit


def converted(value: float, given: str, wanted: str) -> float:
    """Return a value in another unit; one that is not told changes nothing."""
    source, target = METRES[given], METRES[wanted]
    return value if source is None or target is None else value * source / target


def written(node: Chain, name: str = "root", start: float | None = None) -> tuple[str, dict[str, tuple[int, float]]]:
    """Return the System element of a chain, and the values that systems above it bind, with levels to go."""
    elements, ends = "", ["u"]
    mine: dict[str, tuple[int, float]] = {}
    above: dict[str, tuple[int, float]] = {}
    for place, part in enumerate(node.parts):
        own = f"p{place}"
        ends += [f"{own}.u", f"{own}.y"]
        if isinstance(part, Chain):
            text, waiting = written(part, own)
        else:
            values = {"k": part.k, "b": part.b}
            text = component(own, inline(values if part.level == 0 else {"k": 99.0, "b": 99.0}), part.units)
            waiting = {key: (part.level, value) for key, value in values.items() if part.level}
        elements += text
        for key, (level, value) in waiting.items():
            here = level == 1 or start is not None
            (mine if here else above)[f"{own}.{key}"] = (level - 1, value)
    ends.append("y")
    wires = "".join(
        wire(ends[2 * i], ends[2 * i + 1], f'<ssc:LinearTransformation factor="{f}" offset="{o}"/>')
        for i, (f, o) in enumerate(node.changes)
    )
    ports = connector("u", "input", node.units[0]) + connector("y", "output", node.units[1])
    bound = {key: value for key, (_, value) in mine.items()} | ({} if start is None else {"u": start})
    return system(elements, wires, ports, inline(bound) if bound else "", name), above


@settings(max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(tree=trees, start=numbers)
def test_nested_systems_equal_their_flat_evaluation(tmp_path: Path, block: Path, tree: Chain, start: float) -> None:
    """Parameters bound at any level, units and transformations at every connection; rounding only.

    The system's output is another name for the last block's; what its connection makes of it is in the assembly.
    """
    root, waiting = written(tree, start=start)
    assert not waiting
    run = simulate(archive(tmp_path / "a.ssp", block, description(root)), steps=20)
    (alias,) = run.assembly.outputs
    found = alias.gain * run.outputs[f"{alias.wire.start_element}.y"] + alias.offset
    expected, _ = flat(tree, start, tree.units[0])
    assert found == pytest.approx(expected, rel=1e-12, abs=1e-12)
