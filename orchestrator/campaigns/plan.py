"""The plan of a campaign: a TOML file or a dictionary in, a checked `Plan` out. No systems, no FMUs."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

from ..errors import InputError
from .factors import SEED, START_HZ, Factor, Listed, Value, read_factor

METHODS = ("grid", "latin", "sobol", "saltelli", "table")
MOST_RUNS = 10_000_000
STAGES = ("linear", "cycles", "time")

_TABLES: Mapping[str, tuple[str, ...]] = {
    "system": ("case", "file", "step", "duration", "algorithm", "set", "replace", "seed"),
    "sample": ("method", "n", "seed", "file"),
    "compute": ("stage", "timeout_s", "attempts", "record_every", "sound", "compare"),
}


@dataclass(frozen=True)
class Base:
    """The system that all runs share.

    Attributes
    ----------
    system : a case such as "case3", an .ssp or an .ssd file
    step, duration, algorithm : None: as the system says
    values : parameter values by component and name
    sources : FMU files, or names of shipped FMUs, that replace a component's own
    seed : random start of all runs; None: the force pulse
    """

    system: str
    step: float | None = None
    duration: float | None = None
    algorithm: str | None = None
    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    sources: Mapping[str, str] = field(default_factory=dict)
    seed: int | None = None


@dataclass(frozen=True)
class Sample:
    """How points are taken.

    Attributes
    ----------
    method : one of `METHODS`
    n : number of points; for saltelli the base number, n (d + 2) points in all; not for a grid or a table
    seed : of the random part of a method
    file : CSV of a table, one column per factor
    """

    method: str = "grid"
    n: int | None = None
    seed: int = 0
    file: Path | None = None


@dataclass(frozen=True)
class Compute:
    """What is computed at each point.

    Attributes
    ----------
    stages : in this order; each one but the first only where the one before found instability
    timeout_s : wall time after which a run counts as one that hangs
    attempts : how many worker processes a run may take with it until it counts as the cause
    record_every : of a simulated run, every this many steps are looked at
    sound : whether a simulated run is asked for its level in dB(A) and its mode
    compare : whether the end of a simulated run is looked for among the limit cycles and what they break up into
    """

    stages: tuple[str, ...] = ("linear",)
    timeout_s: float = 3600.0
    attempts: int = 4
    record_every: int = 8
    sound: bool = True
    compare: bool = True


@dataclass(frozen=True)
class Plan:
    """A campaign.

    Attributes
    ----------
    base : the system
    factors : what varies, by name: COMPONENT.PARAMETER, COMPONENT (an FMU), seed, start_hz, or the name of a choice
    choices : for each choice and each of its values, what it sets: COMPONENT.PARAMETER or COMPONENT
    sample, compute : how points are taken, and what is computed there
    text : the plan as JSON, for the store
    """

    base: Base
    factors: Mapping[str, Factor]
    choices: Mapping[str, Mapping[str, Mapping[str, Value]]]
    sample: Sample
    compute: Compute
    text: str

    @property
    def digest(self) -> str:
        """Hash of all that decides which points there are and what is computed."""
        data = json.loads(self.text)
        for key in ("timeout_s", "attempts"):
            data.get("compute", {}).pop(key, None)
        table = b"" if self.sample.file is None else self.sample.file.read_bytes()
        return hashlib.sha256(json.dumps(data, sort_keys=True).encode() + table).hexdigest()


def read_plan(path: Path) -> Plan:
    """Return the plan of a TOML file; files that it names are looked for beside it.

    Raises
    ------
    InputError
        For a file that is not there or no TOML, and for whatever in it means nothing.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is no TOML: {error}") from None
    try:
        return make_plan(data, path.parent)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def make_plan(data: Mapping[str, Any], folder: Path = Path()) -> Plan:
    """Return the plan of a dictionary with the tables of a plan file.

    Parameters
    ----------
    folder : where files are looked for

    Raises
    ------
    InputError
        For whatever means nothing.
    """
    unknown = sorted(data.keys() - {"system", "vary", "sample", "compute"})
    if unknown:
        raise InputError(f"[{unknown[0]}] means nothing here; known are system, vary, sample, compute")
    tables = {name: _table(data, name) for name in ("system", "vary", "sample", "compute")}
    for name, known in _TABLES.items():
        for key in tables[name]:
            if key not in known:
                raise InputError(f"[{name}] {key}: means nothing here; known are {', '.join(known)}")
    if not tables["vary"]:
        raise InputError("[vary] is empty; give at least one parameter")
    factors, choices = _vary(tables["vary"], folder)
    sample = _sample(tables["sample"], folder)
    _fits(factors, sample)
    text = json.dumps(data, sort_keys=True, default=str)
    return Plan(_base(tables["system"], folder), factors, choices, sample, _compute(tables["compute"]), text)


def _table(data: Mapping[str, Any], name: str) -> dict[str, Any]:
    table = data.get(name, {})
    if not isinstance(table, dict):
        raise InputError(f"{name} = {table}: must be a table, [{name}]")
    return table


def _base(table: Mapping[str, Any], folder: Path) -> Base:
    """Return the system of [system]."""
    if ("case" in table) == ("file" in table):
        raise InputError('[system] must name a case, such as case = "case3", or a file, one of them')
    for key in ("case", "file", "algorithm"):
        if not isinstance(table.get(key, ""), str):
            raise InputError(f"[system] {key} = {table[key]}: must be a text")
    system = str(table.get("case", "")) or str(folder / table["file"])
    for key in ("step", "duration"):
        value = table.get(key, 1.0)
        if not isinstance(value, float | int) or isinstance(value, bool) or not 0 < value < float("inf"):
            raise InputError(f"[system] {key} = {value}: must be > 0 s")
    seed = table.get("seed")
    if seed is not None and (not isinstance(seed, int) or isinstance(seed, bool) or seed < 0):
        raise InputError(f"[system] seed = {seed}: must be a whole number >= 0")
    values: dict[str, dict[str, Value]] = {}
    for full, value in _flat(_table(table, "set")).items():
        component, parameter = split(full, "[system] set")
        values.setdefault(component, {})[parameter] = value
    sources = {name: _source(str(text), folder) for name, text in _table(table, "replace").items()}
    return Base(system, table.get("step"), table.get("duration"), table.get("algorithm"), values, sources, seed)


def _flat(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table whose keys may be written `contact.mu0` with or without quotes."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, dict):
            flat.update({f"{key}.{rest}": v for rest, v in _flat(value).items()})
        else:
            flat[key] = value
    return flat


def split(full: str, where: str) -> tuple[str, str]:
    """Return component and parameter of a name such as contact.mu0."""
    component, dot, parameter = full.partition(".")
    if not (component and dot and parameter):
        raise InputError(f"{where} {full}: must be COMPONENT.PARAMETER, such as contact.mu0")
    return component, parameter


def _source(text: str, folder: Path) -> str:
    """Return an FMU file beside the plan, or the name of a shipped FMU as it is."""
    return str((folder / text).resolve()) if text.endswith(".fmu") else text


_OF_A_FACTOR = {"from", "to", "n", "spacing", "values", "distribution", "mean", "std", "median", "sigma", "mode"}


def _vary(table: Mapping[str, Any], folder: Path) -> tuple[dict[str, Factor], dict[str, dict[str, dict[str, Value]]]]:
    """Return factors and choices of [vary]."""
    factors: dict[str, Factor] = {}
    choices: dict[str, dict[str, dict[str, Value]]] = {}
    for name, entry in _entries(table).items():
        if isinstance(entry, dict) and "choices" in entry:
            choices[name] = _choice(name, entry, folder)
            factors[name] = Listed(tuple(choices[name]))
            continue
        factor = read_factor(name, entry)
        if name not in (SEED, START_HZ) and "." not in name:
            factor = _fmus(name, factor, folder)
        factors[name] = factor
    return factors, choices


def _entries(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries of [vary], where `contact.mu0` may stand with or without quotes."""
    entries: dict[str, Any] = {}
    for name, entry in table.items():
        if isinstance(entry, dict) and entry and "choices" not in entry and not entry.keys() & _OF_A_FACTOR:
            entries.update({f"{name}.{rest}": e for rest, e in _entries(entry).items()})
        else:
            entries[name] = entry
    return entries


def _fmus(name: str, factor: Factor, folder: Path) -> Listed:
    """Return a list of FMUs that take a component's place."""
    if not isinstance(factor, Listed) or not all(isinstance(v, str) for v in factor.values):
        raise InputError(
            f"[vary] {name}: must be COMPONENT.PARAMETER, a component with FMUs, {SEED}, {START_HZ} or a choice"
        )
    return Listed(tuple(_source(str(v), folder) for v in factor.values))


def _choice(name: str, entry: Mapping[str, Any], folder: Path) -> dict[str, dict[str, Value]]:
    """Return what each value of a choice sets."""
    table = entry["choices"]
    if len(entry) > 1 or not isinstance(table, dict) or not table:
        raise InputError(
            f'[vary] {name}: choices must be a table of tables, such as {{ soft = {{ rail = "soft.fmu" }} }}'
        )
    found: dict[str, dict[str, Value]] = {}
    for label, what in table.items():
        if not isinstance(what, dict):
            raise InputError(f"[vary] {name}, choice {label}: must be a table of parameters and components")
        found[label] = {k: v if "." in k else _source(str(v), folder) for k, v in _flat(what).items()}
    return found


def _sample(table: Mapping[str, Any], folder: Path) -> Sample:
    """Return how points are taken, of [sample]."""
    method, n, seed = table.get("method", "grid"), table.get("n"), table.get("seed", 0)
    if method not in METHODS:
        raise InputError(f"[sample] method = {method}: must be one of {', '.join(METHODS)}")
    if (method in ("grid", "table")) != (n is None):
        raise InputError(
            f"[sample] n: a {method} has its number of points itself" if n is not None
            else f"[sample] n: {method} needs the number of points"
        )  # fmt: skip
    if n is not None and (not isinstance(n, int) or isinstance(n, bool) or not 1 <= n <= MOST_RUNS):
        raise InputError(f"[sample] n = {n}: must be a whole number from 1 to {MOST_RUNS:.0e}")
    if method == "saltelli" and n is not None and n & (n - 1):
        raise InputError(f"[sample] n = {n}: Saltelli's scheme needs a power of 2")
    if not isinstance(seed, int) or isinstance(seed, bool) or seed < 0:
        raise InputError(f"[sample] seed = {seed}: must be a whole number >= 0")
    if (method == "table") != ("file" in table):
        raise InputError("[sample] file: method table needs a CSV file, the others none")
    file = folder / str(table["file"]) if "file" in table else None
    if file is not None and not file.is_file():
        raise InputError(f"[sample] file = {file}: no such file")
    return Sample(method, n, seed, file)


def _fits(factors: Mapping[str, Factor], sample: Sample) -> None:
    """Raise InputError if a factor cannot be sampled so."""
    for name, factor in factors.items():
        if sample.method == "grid" and factor.levels() is None:
            raise InputError(f"[vary] {name}: a grid needs n or a list of values")
        if sample.method == "saltelli" and isinstance(factor, Listed) and isinstance(factor.values[0], str):
            raise InputError(f"[vary] {name}: Sobol indices need numbers")


def _compute(table: Mapping[str, Any]) -> Compute:
    """Return what is computed, of [compute]."""
    stage = table.get("stage", "linear")
    stages = tuple(stage) if isinstance(stage, list) else (stage,)
    for each in stages:
        if each not in STAGES:
            raise InputError(f"[compute] stage = {each}: must be one of {', '.join(STAGES)}")
    if not stages or len(set(stages)) < len(stages) or sorted(stages, key=STAGES.index) != list(stages):
        raise InputError(f"[compute] stage = {list(stages)}: each once and in the order {', '.join(STAGES)}")
    timeout = table.get("timeout_s", Compute.timeout_s)
    if not isinstance(timeout, float | int) or isinstance(timeout, bool) or not (timeout > 0 and isfinite(timeout)):
        raise InputError(f"[compute] timeout_s = {timeout}: must be > 0 s")
    for key in ("attempts", "record_every"):
        value = table.get(key, 1)
        if not isinstance(value, int) or isinstance(value, bool) or value < 1:
            raise InputError(f"[compute] {key} = {value}: must be a whole number >= 1")
    for key in ("sound", "compare"):
        if not isinstance(table.get(key, True), bool):
            raise InputError(f"[compute] {key} = {table[key]}: must be true or false")
    rest = {key: table[key] for key in ("attempts", "record_every", "sound", "compare") if key in table}
    return Compute(stages, float(timeout), **rest)
