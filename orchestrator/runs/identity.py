"""What was run: a resolved scenario in, its hash out. Pure: no files, no clock, no machine."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import version
from typing import Any

from ..coupling.assembly import Assembly
from ..coupling.settings import Settings
from ..fmi.file import Fmu
from ..fmi.instance import Value
from .attributes import PACKAGES, plain


@lru_cache(1)
def versions() -> dict[str, str]:
    """Return the versions of the packages that may change a number."""
    return {name: version(name) for name in PACKAGES}


def identity(assembly: Assembly, settings: Settings) -> str:
    """Return the hash of a resolved scenario, 64 hexadecimal digits.

    Two scenarios have one identity if and only if they are the same system run in the same way by the same software:
    components with their FMUs' checksums and parameter values, wires with their conversions, order of stepping, start,
    step, number of steps, algorithm, versions. How a value came to be, from a file or from the user, does not
    matter, nor what is recorded.
    """
    links = sorted(
        (link.wire.start_element, link.wire.start_connector, link.wire.end_element, link.wire.end_connector,
         float(link.gain), float(link.offset))
        for link in assembly.links
    )  # fmt: skip
    return _digest(
        {
            "components": {name: component(fmu, assembly.parameters[name]) for name, fmu in assembly.fmus.items()},
            "links": links,
            "stages": dict(assembly.system.stages),
            "start": float(assembly.system.start),
            "step": float(settings.step),
            "steps": settings.steps,
            "algorithm": settings.algorithm,
            "versions": versions(),
        }
    )


def component(fmu: Fmu, values: Mapping[str, Value]) -> str:
    """Return the hash of an FMU with the values that differ from its start values."""
    changed = {
        name: known
        for name, value in values.items()
        if (known := plain(value, fmu.variables[name].type)) != _start(fmu, name)
    }
    return _digest({"fmu": fmu.checksum, "values": changed})


def _start(fmu: Fmu, name: str) -> float | str | None:
    variable = fmu.variables[name]
    return None if variable.start is None else plain(variable.start, variable.type)


def _digest(data: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()
