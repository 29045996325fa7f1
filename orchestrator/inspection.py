"""What is inside an FMU or a system, as plain data and as tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.markup import escape
from rich.table import Table
from rich.tree import Tree

from .errors import InputError
from .fmu import Fmu, open_fmu
from .system import Element, Hop, Wire, read_system
from .units import unit_name

_COLUMNS = ("name", "causality", "type", "unit", "start", "description")


def describe(path: Path) -> dict[str, Any]:
    """Return what an .fmu, .ssp or .ssd file holds.

    Raises
    ------
    InputError
        If the file is of another kind or cannot be read.
    """
    if path.suffix == ".fmu":
        return _describe_fmu(open_fmu(path))
    if path.suffix in (".ssp", ".ssd") or ".ssp#" in path.name:
        return _describe_system(path)
    raise InputError(f"{path}: must be an .fmu, .ssp or .ssd file")


def _describe_fmu(fmu: Fmu) -> dict[str, Any]:
    d = fmu.description
    cs = d.coSimulation
    return {
        "file": str(fmu.path),
        "model": d.modelName,
        "description": d.description,
        "fmi": d.fmiVersion,
        "version": d.version,
        "guid": d.guid,
        "sha256": fmu.checksum,
        "tool": d.generationTool,
        "platforms": sorted(p.name for p in (fmu.folder / "binaries").iterdir()),
        "step_s": None if d.defaultExperiment is None else float(d.defaultExperiment.stepSize or 0) or None,
        "get_set_state": bool(cs.canGetAndSetFMUstate),
        "serialise_state": bool(cs.canSerializeFMUstate),
        "feedthrough": fmu.has_feedthrough(),
        "variables": [
            {
                "name": v.name,
                "causality": v.causality,
                "type": v.type,
                "unit": fmu.unit(v.name),
                "start": v.start,
                "description": v.description,
            }
            for v in d.modelVariables
        ],
    }


def _describe_system(path: Path) -> dict[str, Any]:
    """Return a system as it is after nesting, bindings and mappings are worked out; no FMU is opened."""
    system = read_system(path)
    return {
        "file": str(path),
        "system": system.name,
        "ssp": system.version,
        "variants": list(system.variants),
        "start_s": system.start,
        "stop_s": system.stop,
        "step_s": system.step_size,
        "algorithm": system.algorithm,
        "components": [_component(element) for element in system.elements.values()],
        "connections": [_connection(wire) for wire in system.wires],
        "outputs": [_connection(wire) for wire in system.outputs],
        "notices": list(system.notices),
    }


def _component(element: Element) -> dict[str, Any]:
    values = [
        {
            "name": name,
            "value": p.value,
            "unit": unit_name(p.unit) if p.unit else None,
            "change": _change(p.hops),
            "from": p.origin,
        }
        for name, p in element.parameters.items()
    ]
    return {"name": element.name, "source": element.source.name, "stage": element.stage, "parameters": values}


def _connection(wire: Wire) -> dict[str, Any]:
    start, _, end = str(wire).partition(" -> ")
    return {"from": start, "to": end, "change": _change(wire.hops)}


def _change(hops: tuple[Hop, ...]) -> str | None:
    """Return what the steps of a value's way do to it, in words; None if nothing but a change of units."""
    steps = []
    for hop in hops:
        text = "" if hop.factor == 1.0 else f"* {hop.factor:g}"
        text += "" if hop.offset == 0.0 else f" {'-' if hop.offset < 0 else '+'} {abs(hop.offset):g}"
        text += "" if hop.convert else " (units as they are)"
        if hop.unit and hop is not hops[-1]:
            text += f" in {unit_name(hop.unit)}"
        steps.append(text.strip())
    return ", then ".join(filter(None, steps)) or None


def tables(description: dict[str, Any]) -> Iterator[Table | Tree]:
    """Yield what shows a description; numbered variables such as shape_lat_001 ... share a row."""
    head = Table(show_header=False, title=description["file"], title_justify="left")
    for key, value in description.items():
        if not isinstance(value, list) or key in ("platforms", "variants"):
            head.add_row(key, ", ".join(value) if isinstance(value, list) else str(value))
    yield head
    if "variables" in description:
        yield _variables(description["variables"])
        return
    yield _tree(description["system"], description["components"])
    for title in ("connections", "outputs"):
        if description[title]:
            wires = Table("from", "to", "change", title=title, title_justify="left")
            for wire in description[title]:
                wires.add_row(wire["from"], wire["to"], wire["change"] or "")
            yield wires
    if description["notices"]:
        notices = Table(title="passed over", title_justify="left", show_header=False)
        for notice in description["notices"]:
            notices.add_row(escape(notice))
        yield notices


def _tree(name: str, components: list[dict[str, Any]]) -> Tree:
    """Return systems, components and parameters as a tree."""
    root = Tree(escape(name))
    branches = {"": root}
    for part in components:
        *systems, own = part["name"].split(".")
        for depth in range(len(systems)):
            path, above = ".".join(systems[: depth + 1]), ".".join(systems[:depth])
            if path not in branches:
                branches[path] = branches[above].add(escape(systems[depth]))
        stage = "" if part["stage"] is None else f", stage {part['stage']}"
        leaf = branches[".".join(systems)].add(escape(f"{own}  ({part['source']}{stage})"))
        for p in part["parameters"]:
            text = f"{p['name']} = {p['value']}{' ' + p['unit'] if p['unit'] else ''}"
            leaf.add(escape(text + (f"  [{p['change']}]" if p["change"] else "")))
    return root


def _variables(variables: list[dict[str, Any]]) -> Table:
    table = Table(title="variables", title_justify="left")
    for heading in _COLUMNS:
        table.add_column(heading, overflow="fold", no_wrap=heading in ("name", "unit"))
    families = Counter(_family(v["name"]) for v in variables)
    shown: set[str] = set()
    for v in variables:
        family = _family(v["name"])
        if families[family] > 3:
            if family not in shown:
                cells = (
                    f"{family} ({families[family]})",
                    v["causality"],
                    v["type"],
                    v["unit"],
                    "...",
                    v["description"],
                )
                table.add_row(*(str(cell or "") for cell in cells))
            shown.add(family)
        else:
            table.add_row(*("" if v[c] is None else str(v[c]) for c in _COLUMNS))
    return table


def _family(name: str) -> str:
    """Return the name of a numbered variable without its number."""
    return re.sub(r"_\d+$", "_*", name)
