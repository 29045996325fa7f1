"""What is inside an FMU or a system, as plain data."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..errors import InputError
from ..fmi.instance import Fmu, open_fmu
from ..units import unit_name
from .cases import find_system
from .model import Element, Hop, Wire
from .reader import read_system
from .settable import settable


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
                "type": v.fmi_type,
                "unit": v.unit,
                "start": v.start,
                "description": v.description,
            }
            for v in fmu.variables.values()
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
        text += "" if hop.table is None else ", ".join(f"{s} becomes {t}" for s, t in hop.table.texts())
        text += "" if hop.convert else " (units as they are)"
        if hop.unit and hop is not hops[-1]:
            text += f" in {unit_name(hop.unit)}"
        steps.append(text.strip())
    return ", then ".join(filter(None, steps)) or None


def settable_in(file: Path) -> list[dict[str, Any]]:
    """Return what can be set in an FMU, a system or a case, with types, units, start values and ranges."""
    if file.suffix == ".fmu":
        fmus = {file.stem: open_fmu(file)}
    else:
        fmus = {name: open_fmu(element.source) for name, element in find_system(str(file)).elements.items()}
    return [asdict(each) for each in settable(fmus)]
