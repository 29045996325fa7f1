"""One scenario from start to end: simulate, record, summarise, draw. Signals end a run in order, not in the middle."""

from __future__ import annotations

import json
import platform
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from types import FrameType

from .analysis import Summary, summarise
from .assembly import Assembly
from .coupling import modal_system
from .errors import InputError, SimulationError
from .master import Master, Progress, Settings
from .results import ResultsFile, open_results, write_csv
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
    spurious : what the algorithm does to the growth rates
    error : why it ended early; None if it did not
    """

    case: str
    settings: Settings
    progress: Progress
    summary: Summary
    results: Path
    picture: Path
    spurious: Spurious
    error: str | None


@dataclass(frozen=True)
class Spurious:
    """Growth that the coupling adds.

    Attributes
    ----------
    largest : largest error of a growth rate below 5 kHz [1/s]; None if it is not known
    sentence : the figures, or why there are none
    """

    largest: float | None
    sentence: str


def run_scenario(
    scenario: Scenario,
    folder: Path,
    csv: bool = False,
    report: Callable[[Progress], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
) -> Outcome:
    """Run a scenario and leave results and picture in `folder`; earlier results there are kept.

    Raises
    ------
    InputError
        If the scenario cannot be run.
    SimulationError
        If a component fails before anything was recorded.
    """
    assembly, settings = scenario.prepare()
    spurious = spurious_growth(assembly, settings)
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
    summary, picture, case = _finish(path, error, csv)
    return Outcome(case, settings, progress, summary, path, picture, spurious, error)


def spurious_growth(assembly: Assembly, settings: Settings) -> Spurious:
    """Return what the algorithm does to the growth rates of the linearised system, or why that is not known."""
    try:
        growth = modal_system(assembly).at(settings.step, settings.algorithm)
    except InputError as reason:
        return Spurious(None, f"not known: {reason}")
    return Spurious(growth.modes.largest, growth.sentence(settings.algorithm, settings.step))


def _finish(path: Path, error: str | None, csv: bool) -> tuple[Summary, Path, str]:
    """Summarise and draw what was recorded."""
    with open_results(path) as data:
        if data.sizes["time"] < 3:
            raise SimulationError(error or f"{path}: only {data.sizes['time']} rows were recorded")
        summary = summarise(data)
        from .figures import draw_run  # noqa: PLC0415 - matplotlib takes its time

        picture = path.with_suffix(".png")
        draw_run(data, picture)
        if csv:
            write_csv(data, path.with_suffix(".csv"))
        return summary, picture, str(data.attrs["case"])


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
        "fmus": json.dumps(fmus),
        "versions": json.dumps({"python": platform.python_version(), **{p: version(p) for p in PACKAGES}}),
    }


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
        "max_growth_rate_error": outcome.spurious.largest,
        "spurious_growth": outcome.spurious.sentence,
        "completed": outcome.error is None and not outcome.progress.stopped,
        "error": outcome.error,
        "results": str(outcome.results),
        "picture": str(outcome.picture),
    }
    return json.dumps(data, allow_nan=False, indent=1)
