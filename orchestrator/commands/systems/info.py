"""The command `info`: what is inside an FMU or a system, as tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.padding import Padding
from rich.table import Table
from rich.tree import Tree

from ..tools import Json, screen

_COLUMNS = ("name", "causality", "type", "unit", "start")


def tables(description: dict[str, Any], every: bool = False) -> Iterator[Table | Tree]:
    """Yield what shows a description; numbered ones such as shape_lat_001 share a row, unless every one is wanted."""
    head = Table(show_header=False, title=description["file"], title_justify="left")
    for key, value in description.items():
        if not isinstance(value, list) or key in ("platforms", "variants"):
            head.add_row(key, ", ".join(value) if isinstance(value, list) else str(value))
    yield head
    if "variables" in description:
        yield (_described if every else _variables)(description["variables"])
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
            notices.add_row(notice)
        yield notices


def _tree(name: str, components: list[dict[str, Any]]) -> Tree:
    """Return systems, components and parameters as a tree."""
    root = Tree(name)
    branches = {"": root}
    for part in components:
        *systems, own = part["name"].split(".")
        for depth in range(len(systems)):
            path, above = ".".join(systems[: depth + 1]), ".".join(systems[:depth])
            if path not in branches:
                branches[path] = branches[above].add(systems[depth])
        stage = "" if part["stage"] is None else f", stage {part['stage']}"
        leaf = branches[".".join(systems)].add(f"{own}  ({part['source']}{stage})")
        for p in part["parameters"]:
            text = f"{p['name']} = {p['value']}{' ' + p['unit'] if p['unit'] else ''}"
            leaf.add(text + (f"  [{p['change']}]" if p["change"] else ""))
    return root


def _variables(variables: list[dict[str, Any]]) -> Table:
    """Return the variables without descriptions; those that differ by a number only are one."""
    table = Table(title="variables", title_justify="left")
    for heading in _COLUMNS:
        table.add_column(heading, overflow="fold", no_wrap=heading in ("name", "unit"))
    families = Counter(_family(v["name"]) for v in variables)
    shown: set[str] = set()
    for v in variables:
        family = _family(v["name"])
        if families[family] <= 3:
            table.add_row(*("" if v[c] is None else str(v[c]) for c in _COLUMNS))
        elif family not in shown:
            one = {**v, "name": f"{family} ({families[family]})", "start": "..."}
            table.add_row(*(str(one[c] or "") for c in _COLUMNS))
            shown.add(family)
    return table


def _described(variables: list[dict[str, Any]]) -> Table:
    """Return every variable, its description in a line of its own: beside five columns there is no room for it."""
    table = Table(title="variables", title_justify="left", show_header=False, box=None)
    for v in variables:
        start = [] if v["start"] is None else ["=", str(v["start"])]
        table.add_row(" ".join([v["name"] + ":", v["causality"] or "", v["type"], *start, v["unit"] or ""]))
        table.add_row(Padding(v["description"] or "", (0, 0, 0, 4)))
    return table


def _settable(variables: list[dict[str, Any]], title: str) -> Table:
    """Return what can be set: a row per variable, and one per mode for all that a mode has."""
    table = Table("name", "start", "unit", "range", "description", title=title, title_justify="left")
    modes: dict[tuple[str, str], list[str]] = {}
    for v in variables:
        mode = re.search(r"of (mode \d+.*)$", v["description"])
        number = re.search(r"_(\d+)$|(\[\d+\])$", v["name"])
        if mode and number:
            stem, end = v["name"][: number.start()], number.group()
            modes.setdefault((f"{stem.partition('.')[0]}.*{end}", mode.group(1)), []).append(stem.partition(".")[2])
            continue
        low, high = v["minimum"], v["maximum"]
        limits = (
            "" if low is None and high is None else f"{'' if low is None else low} .. {'' if high is None else high}"
        )
        start = "" if v["start"] is None else str(v["start"])
        table.add_row(v["name"], start, v["unit"] or "", limits, v["description"])
    for (name, label), stems in modes.items():
        table.add_row(name, "", "", "", f"{label}: {', '.join(stems)}")
    return table


def _family(name: str) -> str:
    """Return the name of a numbered variable, or of an array's element, without its number."""
    return re.sub(r"_\d+$|\[[\d,]+\]$", "_*", name)


def info(
    file: Annotated[Path, typer.Argument(help="An .fmu, .ssp or .ssd file.")],
    set_: Annotated[bool, typer.Option("--set", help="List what `run --set` can set instead.")] = False,
    every: Annotated[bool, typer.Option("--all", help="Every variable, with its description.")] = False,
    json: Json = False,
) -> None:
    """Show what is inside an FMU or a system."""
    from ...system.inspection import describe, settable_in  # noqa: PLC0415 - keeps the start of other commands short

    if set_:
        variables = settable_in(file)
        if json:
            screen.print_json(data=variables)
        else:
            screen.print(_settable(variables, f"what --set can set in {file.name}"))
        return
    description = describe(file)
    if json:
        screen.print_json(data=description)
    else:
        for table in tables(description, every):
            screen.print(table)
