"""The parameters of a run, all of them: FMUs and what was changed in, plain values for a results file out."""

from __future__ import annotations

from collections.abc import Mapping

from .fmu import Value
from .fmu_file import Fmu


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
        for variable in fmu.names("parameter"):
            value = changed.get(name, {}).get(variable, fmu.variables[variable].start)
            own[variable] = None if value is None else _plain(value, fmu.variables[variable].type)
    return values


def _plain(value: Value, kind: str) -> float | str:
    """Return a parameter value as a number where it is one; true is 1."""
    if kind == "Boolean":
        return float(str(value).lower() in ("true", "1"))
    return float(value) if kind in ("Real", "Integer") else str(value)
