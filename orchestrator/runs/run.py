"""One scenario from start to end: simulate, record, keep checkpoints, summarise, draw."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..coupling.master import Master, Progress
from ..errors import InputError, SimulationError
from ..results.file import ResultsFile, open_results
from ..results.formats import require_parquet, write_csv, write_parquet
from ..signals.summary import Summary, summarise
from ..stability.scheme import spurious_growth
from .attributes import _attributes
from .checkpoint import check_serialisable, read_checkpoint, write_checkpoint
from .outcome import Outcome
from .scenario import Scenario
from .stopping import stop_on_signals


@dataclass(frozen=True)
class Keeping:
    """Where a run keeps checkpoints, and how often.

    Attributes
    ----------
    path : the file
    every : wall time between two checkpoints [s]; 0: as often as possible
    """

    path: Path
    every: float = 60.0


@dataclass(frozen=True)
class Report:
    """What a run tells and leaves besides its results.

    Attributes
    ----------
    progress : called after each chunk of steps
    notice : called with each sentence that the user should read
    csv, parquet : whether to write the results in this form, too
    picture : whether to draw histories and spectra
    """

    progress: Callable[[Progress], None] = lambda _: None
    notice: Callable[[str], None] = lambda _: None
    csv: bool = False
    picture: bool = True
    parquet: bool = False


def run_scenario(scenario: Scenario, folder: Path, report: Report, keeping: Keeping | None = None) -> Outcome:
    """Run a scenario and leave results and picture in `folder`; earlier results there are kept.

    Raises
    ------
    InputError
        If the scenario cannot be run.
    SimulationError
        If a component fails before anything was recorded.
    """
    if report.parquet:
        require_parquet()
    assembly, settings = scenario.prepare()
    if keeping is not None:
        check_serialisable(assembly)
    with Master(assembly, settings) as master:
        for notice in (*assembly.notices, *master.notices):
            report.notice(notice)
        path = _claim(folder, assembly.system.name)
        try:
            results = ResultsFile(path, master.signals(), _attributes(scenario, assembly, settings, master))
        except OSError as failure:
            raise SimulationError(f"{path}: cannot write results: {failure.strerror or failure}") from None
        return _go(scenario, master, results, report, keeping)


def resume(checkpoint: Path, report: Report, every: float = Keeping.every) -> Outcome:
    """Go on with a run where its checkpoint stands; its results file grows, its checkpoint moves on.

    Raises
    ------
    InputError
        If the checkpoint, its results or its FMUs are not there or not the same.
    """
    kept = read_checkpoint(checkpoint)
    assembly, settings = kept.scenario.prepare()
    with Master(assembly, settings) as master:
        kept.restore(master)
        results = ResultsFile.reopen(kept.results, master.signals(), kept.header, kept.rows)
        return _go(kept.scenario, master, results, report, Keeping(checkpoint, every))


def _go(scenario: Scenario, master: Master, results: ResultsFile, report: Report, keeping: Keeping | None) -> Outcome:
    """Step to the end, keep checkpoints on the way, and sum up."""
    error = None
    last = time.monotonic()

    def follow(latest: Progress) -> None:
        nonlocal last
        if keeping is not None and time.monotonic() - last >= keeping.every:
            write_checkpoint(keeping.path, scenario, master, results)
            last = time.monotonic()
        report.progress(latest)

    with results, stop_on_signals() as stop_requested:
        if keeping is not None:
            write_checkpoint(keeping.path, scenario, master, results)
        try:
            master.run(results, follow, stop_requested)
            if keeping is not None:
                write_checkpoint(keeping.path, scenario, master, results)
        except (SimulationError, InputError) as failure:
            error = str(failure)
        except OSError as failure:
            error = f"{results.path}: cannot write results: {failure.strerror or failure}"
    spurious = spurious_growth(master.assembly, master.settings)
    summary, picture = _finish(results.path, error, report)
    case = master.assembly.system.name
    return Outcome(case, master.settings, master.progress, summary, results.path, picture, spurious, error)


def _finish(path: Path, error: str | None, report: Report) -> tuple[Summary, Path | None]:
    """Summarise and draw what was recorded."""
    with open_results(path) as data:
        summary = summarise(data)
        picture = None
        try:
            if report.picture:
                from ..figures.run import draw_run  # noqa: PLC0415 - matplotlib takes its time

                picture = path.with_suffix(".png")
                draw_run(data, picture)
            if report.csv:
                write_csv(data, path.with_suffix(".csv"))
            if report.parquet:
                write_parquet(data, path.with_suffix(".parquet"))
        except OSError as failure:
            said = f"cannot write beside {path}: {failure.strerror or failure}"
            raise SimulationError(f"{error}; {said}" if error else said) from None
        return summary, picture


def _claim(folder: Path, name: str) -> Path:
    """Return the path of an empty new file in `folder`; no other run, earlier or at the same time, gets the same.

    Raises
    ------
    SimulationError
        If nothing can be written there.
    """
    number = 1
    while True:
        path = folder / (f"{name}.nc" if number == 1 else f"{name}-{number}.nc")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch(exist_ok=False)
        except FileExistsError:
            number += 1
        except OSError as failure:
            raise SimulationError(f"{path}: cannot write results: {failure.strerror or failure}") from None
        else:
            return path
