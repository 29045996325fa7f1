"""What a results file says of its run: scenario, FMUs and versions in, attributes out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from uuid import uuid4

from fmus.interface import CHANGE

from ..coupling.assembly import Assembly
from ..coupling.master import Master, Settings
from ..fmi.file import Fmu
from ..fmi.instance import Value
from ..visible import visible
from .identity import identity, plain, versions
from .scenario import Scenario

RUN, IDENTITY = "run", "identity"
"""Attributes that tell this run from every other, and this scenario from every other."""


def all_parameters(
    fmus: Mapping[str, Fmu], changed: Mapping[str, Mapping[str, Value]]
) -> dict[str, dict[str, float | str | None]]:
    """Return the value of every parameter of every FMU: its start value, or what it was changed to.

    Modes, damping and contact of a run are then known from its results alone. None is a start value that the FMU does
    not tell.
    """
    values: dict[str, dict[str, float | str | None]] = {}
    for name, fmu in fmus.items():
        own = values[name] = {}
        moved = (v for v in changed.get(name, {}) if v.endswith(CHANGE))  # inputs that are added to a parameter
        for variable in (*fmu.names("parameter"), *moved):
            value = changed.get(name, {}).get(variable, fmu.variables[variable].start)
            own[variable] = None if value is None else plain(value, fmu.variables[variable].type)
    return values


def _attributes(
    scenario: Scenario, assembly: Assembly, settings: Settings, master: Master
) -> dict[str, str | float | int]:
    """Return what a results file says of itself: enough to run it again."""
    fmus = {
        name: {"file": fmu.path.name, "sha256": fmu.checksum, "guid": fmu.description.guid}
        for name, fmu in assembly.fmus.items()
    }
    return {
        RUN: uuid4().hex,
        IDENTITY: identity(assembly, settings),
        "title": assembly.system.name,
        "case": assembly.system.name,
        "system": visible(assembly.system.path.name),
        "algorithm": settings.algorithm,
        "step_s": settings.step,
        "duration_s": settings.duration,
        "steps": settings.steps,
        "record_every": settings.record_every,
        "seed": -1 if scenario.seed is None else scenario.seed,
        "parameters": json.dumps(master.parameters),
        "all_parameters": json.dumps(all_parameters(assembly.fmus, master.parameters)),
        "fmus": json.dumps(fmus),
        "versions": json.dumps(versions()),
    }
