"""What was run: a resolved scenario in, its hash out. Pure: no files, no clock, no machine."""

from __future__ import annotations

import hashlib
import json
import platform
from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import version
from typing import Any

from ..coupling.assembly import Assembly
from ..coupling.settings import Settings
from ..fmi.file import Fmu
from ..fmi.instance import Value

PACKAGES = ("curvesqueal", "fmpy", "llvmlite", "numba", "numpy", "pythonfmu", "scipy")
"""Whose versions may change a number."""


@lru_cache(1)
def versions() -> dict[str, str]:
    """Return the versions of what may change a number."""
    return {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}}


def identity(assembly: Assembly, settings: Settings) -> str:
    """Return the hash of a resolved scenario, 64 hexadecimal digits.

    Two scenarios have one identity if and only if they are the same system run in the same way by the same software:
    components with their FMUs' checksums, sizes of arrays and parameter values, wires with their conversions, order of
    stepping, start, step, number of steps, algorithm, versions. How a value came to be, from a file or from the user,
    does not matter, nor what is recorded.
    """
    return _digest(resolved(assembly, settings))


def resolved(assembly: Assembly, settings: Settings) -> dict[str, Any]:
    """Return what the identity is the hash of, as JSON data."""
    links = sorted(
        (link.wire.start_element, link.wire.start_connector, link.wire.end_element, link.wire.end_connector,
         float(link.gain), float(link.offset))
        for link in assembly.links
    )  # fmt: skip
    tables = {str(link.wire): dict(link.lookup.numbers) for link in assembly.links if link.lookup is not None}
    return {
        **({"tables": {w: [list(pair) for pair in sorted(t.items())] for w, t in tables.items()}} if tables else {}),
        "components": {name: component(fmu, assembly.parameters[name]) for name, fmu in assembly.fmus.items()},
        "links": [list(link) for link in links],
        "stages": dict(assembly.system.stages),
        "steps of components": {name: element.step for name, element in assembly.system.elements.items()},
        "start": float(assembly.system.start),
        "step": float(settings.step),
        "steps": settings.steps,
        "algorithm": settings.algorithm,
        "versions": versions(),
    }


def difference(before: Mapping[str, Any], now: Mapping[str, Any]) -> str | None:
    """Return in words what is not the same in two resolved scenarios, the first thing found; None if nothing is."""
    for key in sorted({*before, *now}):
        then, here = before.get(key), now.get(key)
        if then == here:
            continue
        if key == "links":
            wires = [{f"{s}.{a} -> {e}.{b}": (g, o) for s, a, e, b, g, o in side or []} for side in (then, here)]
            wire = next(w for w in {**wires[0], **wires[1]} if wires[0].get(w) != wires[1].get(w))
            return (
                f"the connection {wire} was {_conversion(wires[0].get(wire))} and is {_conversion(wires[1].get(wire))}"
            )
        if isinstance(then, Mapping) and isinstance(here, Mapping):
            name = next(n for n in sorted({*then, *here}) if then.get(n) != here.get(n))
            if key == "components":
                return f"component {name} has another FMU or other parameter values"
            return f"{key}: {name} was {then.get(name)} and is {here.get(name)}"
        return f"{key} was {then} and is {here}"
    return None


def _conversion(known: tuple[float, float] | None) -> str:
    return "not there" if known is None else f"there with factor {known[0]:.9g} and offset {known[1]:.9g}"


def component(fmu: Fmu, values: Mapping[str, Value]) -> str:
    """Return the hash of an FMU with the values that differ from its start values."""
    changed = {
        name: known
        for name, value in values.items()
        if (known := plain(value, fmu.variables[name].type)) != _start(fmu, name)
    }
    return _digest({"fmu": fmu.checksum, "values": changed, "sizes": dict(fmu.structure)})


def plain(value: Value, kind: str) -> float | str:
    """Return a parameter value as a number where it is one; true is 1."""
    if kind == "Boolean":
        return float(str(value).lower() in ("true", "1"))
    return float(value) if kind in ("Real", "Integer") else str(value)


def _start(fmu: Fmu, name: str) -> float | str | None:
    variable = fmu.variables[name]
    return None if variable.start is None else plain(variable.start, variable.type)


def _digest(data: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
