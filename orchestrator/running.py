"""One scenario from start to end: simulate, record, summarise, draw. Signals end a run in order, not in the middle."""

from __future__ import annotations

import json
import platform
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import FrameType

from .analysis import Summary, summarise
from .assembly import Assembly
from .errors import InputError, SimulationError
from .fmu import Value
from .master import Master, Progress, Settings
from .results import ResultsFile, open_results, require_parquet, write_csv, write_parquet
from .scenario import Scenario

PACKAGES = ("curvesqueal", "fmpy", "numba", "numpy", "pythonfmu", "scipy")


@dataclass(frozen=True)
class Outcome:
    """What a run left behind.

    Attributes
    ----------
    case : name of the system
    settings, progress, summary : how it was run, how far it came, what came out
    results : the results file
    picture : the picture of histories and spectra
    error : why it ended early; None if it did not
    """

    case: str
    settings: Settings
    progress: Progress
    summary: Summary
    results: Path
    picture: Path
    error: str | None


def run_scenario(
    scenario: Scenario,
    folder: Path,
    csv: bool = False,
    report: Callable[[Progress], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
    parquet: bool = False,
) -> Outcome:
    """Run a scenario and leave results and picture in `folder`; earlier results there are kept.

    Raises
    ------
    InputError
        If the scenario cannot be run.
    SimulationError
        If a component fails before anything was recorded.
    """
    if parquet:
        require_parquet()
    assembly, settings = scenario.prepare()
    if settings.algorithm == "jacobi":
        notice("jacobi delays the contact force by a step and can invent squeal; staggered does not")
    with Master(assembly, settings) as master, stop_on_signals() as stop_requested:
        path = _free_path(folder, assembly.system.name)
        error = None
        progress = Progress(settings.steps)

        def follow(latest: Progress) -> None:
            nonlocal progress
            progress = latest
            report(latest)

        try:
            with ResultsFile(path, master.signals(), _attributes(scenario, assembly, settings, master)) as results:
                master.run(results, follow, stop_requested)
        except SimulationError as failure:
            error = str(failure)
        except OSError as failure:
            raise InputError(f"{path}: cannot write results: {failure.strerror or failure}") from None
    outcome = _finish(path, settings, progress, error)
    with open_results(path) as data:
        if csv:
            write_csv(data, path.with_suffix(".csv"))
        if parquet:
            write_parquet(data, path.with_suffix(".parquet"))
    return outcome


def _finish(path: Path, settings: Settings, progress: Progress, error: str | None) -> Outcome:
    """Summarise and draw what was recorded."""
    with open_results(path) as data:
        if data.sizes["time"] < 3:
            raise SimulationError(error or f"{path}: only {data.sizes['time']} rows were recorded")
        summary = summarise(data)
        from .figures import draw_run  # noqa: PLC0415 - matplotlib takes its time

        picture = path.with_suffix(".png")
        draw_run(data, picture)
        return Outcome(str(data.attrs["case"]), settings, progress, summary, path, picture, error)


def _free_path(folder: Path, name: str) -> Path:
    """Return a path in `folder` that no earlier run has taken."""
    path = folder / f"{name}.nc"
    number = 2
    while path.exists():
        path = folder / f"{name}-{number}.nc"
        number += 1
    return path


def _attributes(
    scenario: Scenario, assembly: Assembly, settings: Settings, master: Master
) -> dict[str, str | float | int]:
    """Return what a results file says of itself: enough to run it again."""
    fmus = {
        name: {"file": fmu.path.name, "sha256": fmu.checksum, "guid": fmu.description.guid}
        for name, fmu in assembly.fmus.items()
    }
    return {
        "title": assembly.system.name,
        "case": assembly.system.name,
        "system": assembly.system.path.name,
        "algorithm": settings.algorithm,
        "step_s": settings.step,
        "duration_s": settings.duration,
        "steps": settings.steps,
        "record_every": settings.record_every,
        "seed": -1 if scenario.seed is None else scenario.seed,
        "parameters": json.dumps(master.parameters),
        "all_parameters": json.dumps(all_parameters(assembly, master.parameters)),
        "fmus": json.dumps(fmus),
        "versions": json.dumps({"python": platform.python_version(), **{p: version(p) for p in PACKAGES}}),
    }


def all_parameters(
    assembly: Assembly, changed: Mapping[str, Mapping[str, Value]]
) -> dict[str, dict[str, float | str | None]]:
    """Return the value of every parameter of every FMU: its start value, or what it was changed to.

    Modes, damping and contact of a run are then known from its results alone. None is a start value that the FMU does
    not tell.
    """
    values: dict[str, dict[str, float | str | None]] = {}
    for name, fmu in assembly.fmus.items():
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


@contextmanager
def stop_on_signals() -> Iterator[Callable[[], bool]]:
    """Catch Ctrl-C and SIGTERM; yield a function that tells whether one came.

    The signal must not become an exception inside an FMU that runs Python, which would report a failure of its own.
    """
    stopped = False

    def handler(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopped
        stopped = True

    try:
        before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not in the main thread: the host program handles signals
        before = {}
    try:
        yield lambda: stopped
    finally:
        for number, old in before.items():
            signal.signal(number, old)


def as_json(outcome: Outcome) -> str:
    """Return an outcome as one JSON object."""
    s = outcome.summary
    data = {
        "case": outcome.case,
        "steps": outcome.progress.steps,
        "step_s": outcome.settings.step,
        "duration_s": outcome.progress.steps * outcome.settings.step,
        "wall_s": outcome.progress.wall,
        "algorithm": outcome.settings.algorithm,
        "dominant_frequency_hz": s.dominant_frequency_hz,
        "growth_rate": s.growth_rate,
        "wheel_velocity_rms": s.wheel_velocity_rms,
        "rail_velocity_rms": s.rail_velocity_rms,
        "contact_lost": s.contact_lost,
        "energy_residual": outcome.progress.energy_residual,
        "energy_into_structures": outcome.progress.energy_into_structures,
        "completed": outcome.error is None and not outcome.progress.stopped,
        "error": outcome.error,
        "results": str(outcome.results),
        "picture": str(outcome.picture),
    }
    return json.dumps(data, allow_nan=False, indent=1)
