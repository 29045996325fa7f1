"""What is inside an FMU or a system, as plain data and as tables."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.table import Table

from .errors import InputError
from .fmu import Fmu, open_fmu
from .system import read_system

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
    if path.suffix in (".ssp", ".ssd"):
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
    system = read_system(path)
    return {
        "file": str(path),
        "system": system.name,
        "start_s": system.start,
        "stop_s": system.stop,
        "step_s": system.step_size,
        "algorithm": system.algorithm,
        "components": [
            {"name": e.name, "source": e.source.name, "parameters": {k: p.value for k, p in e.parameters.items()}}
            for e in system.elements.values()
        ],
        "connections": [str(wire) for wire in system.wires],
    }


def tables(description: dict[str, Any]) -> Iterator[Table]:
    """Yield the tables that show a description; numbered variables such as shape_lat_001 ... share a row."""
    head = Table(show_header=False, title=description["file"], title_justify="left")
    for key, value in description.items():
        if not isinstance(value, list) or key == "platforms":
            head.add_row(key, ", ".join(value) if isinstance(value, list) else str(value))
    yield head
    if "variables" in description:
        yield _variables(description["variables"])
        return
    parts = Table("component", "FMU", "parameters", title="components", title_justify="left")
    for part in description["components"]:
        text = ", ".join(f"{name} = {value}" for name, value in part["parameters"].items())
        parts.add_row(part["name"], part["source"], text)
    yield parts
    wires = Table("from", "to", title="connections", title_justify="left")
    for wire in description["connections"]:
        wires.add_row(*wire.split(" -> "))
    yield wires


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
