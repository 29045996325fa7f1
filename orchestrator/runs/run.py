"""One scenario from start to end: simulate, record, keep checkpoints, summarise, draw."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ..coupling.master import Master, Progress
from ..errors import InputError, SimulationError
from ..results.file import ResultsFile, open_results
from ..results.formats import require_parquet, write_csv, write_parquet
from ..results.samples import read_samples
from ..signals.summary import summarise
from ..stability.scheme import spurious_growth
from .attributes import IDENTITY, RUN, _attributes
from .checkpoint import check_serialisable, read_checkpoint, write_checkpoint
from .identity import identity, resolved
from .outcome import Outcome
from .scenario import Scenario
from .stopping import stop_on_signals
from .trial import try_replaced
from .verdict import verdict

LONG, SOON = 3600.0, 1.0
"""Wall time of a run that is told of beforehand, and after which it is known well enough [s]."""


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
    trial : whether replaced structures are tried before the run
    picture : whether to draw histories and spectra; it can be had later (`orchestrator.figures.run.draw_run`)
    """

    progress: Callable[[Progress], None] = lambda _: None
    notice: Callable[[str], None] = lambda _: None
    csv: bool = False
    picture: bool = False
    parquet: bool = False
    trial: bool = True


def run_scenario(scenario: Scenario, folder: Path, report: Report, keeping: Keeping | None = None) -> Outcome:
    """Run a scenario and leave results in `folder`; earlier results there are kept.

    Raises
    ------
    InputError
        If the scenario cannot be run.
    SimulationError
        If a component fails before anything was recorded.
    """
    if report.parquet:
        require_parquet()
    scenario, folder = scenario.absolute(), folder.absolute()  # an FMU may change the working directory
    keeping = None if keeping is None else replace(keeping, path=keeping.path.absolute())
    assembly, settings = scenario.prepare()
    if report.trial:
        try_replaced(assembly, settings)
    if keeping is not None:
        check_serialisable(assembly)
    with Master(assembly, settings) as master:
        for notice in (*assembly.notices, *master.notices):
            report.notice(notice)
        attributes = _attributes(scenario, assembly, settings, master)
        try:
            results = ResultsFile.claim(folder, assembly.system.name, master.signals(), attributes)
        except OSError as failure:
            raise SimulationError(f"{folder}: cannot write results: {failure.strerror or failure}") from None
        return _go(scenario, master, results, report, keeping)


def resume(checkpoint: Path, report: Report, every: float = Keeping.every) -> Outcome:
    """Go on with a run where its checkpoint stands; its results file grows, its checkpoint moves on.

    Raises
    ------
    InputError
        If the checkpoint, its results or its FMUs are not there or not the same.
    """
    checkpoint = checkpoint.absolute()
    kept = read_checkpoint(checkpoint)
    assembly, settings = kept.scenario.prepare()
    kept.check(assembly, settings)
    with Master(assembly, settings) as master:
        results = ResultsFile.reopen(
            kept.results, master.signals(), {RUN: kept.run, IDENTITY: identity(assembly, settings)}
        )
        try:
            latest = read_checkpoint(checkpoint)  # whoever had the lock before may have moved it on
            if (latest.run, latest.results) != (kept.run, kept.results):
                raise InputError(f"{checkpoint}: another run has written its checkpoint here meanwhile; try again")
            latest.check(assembly, settings)
            latest.restore(master)
            results.cut(latest.rows)
        except BaseException:
            results.close()
            raise
        return _go(kept.scenario, master, results, report, Keeping(checkpoint, every))


def _go(scenario: Scenario, master: Master, results: ResultsFile, report: Report, keeping: Keeping | None) -> Outcome:
    """Step to the end, keep checkpoints on the way, and sum up."""
    error = None
    last = time.monotonic()
    told: list[float] = []
    begun: list[Progress] = []  # after the first chunk, in which the loop may be compiled
    known = {} if keeping is None else resolved(master.assembly, master.settings)

    def follow(latest: Progress) -> None:
        nonlocal last
        if keeping is not None and time.monotonic() - last >= keeping.every:
            write_checkpoint(keeping.path, scenario, master, results, known)
            last = time.monotonic()
        if not begun:
            begun.append(replace(latest))
        elif not told and latest.wall - begun[0].wall > SOON and latest.steps > begun[0].steps:
            rate = (latest.wall - begun[0].wall) / (latest.steps - begun[0].steps)
            told.append(rate * latest.total)
            if told[0] > LONG:
                report.notice(f"this will take about {told[0] / 3600:.1f} h at the speed of the first steps")
        report.progress(latest)

    with results, stop_on_signals() as stop_requested:
        if keeping is not None:
            write_checkpoint(keeping.path, scenario, master, results, known)
        try:
            master.run(results, follow, stop_requested)
            if keeping is not None:
                write_checkpoint(keeping.path, scenario, master, results, known)
        except (SimulationError, InputError) as failure:
            error = str(failure)
        except OSError as failure:
            error = f"{results.path}: cannot write results: {failure.strerror or failure}"
    spurious = spurious_growth(master.assembly, master.settings)
    data = read_samples(results.path)
    summary = summarise(data)
    answer = verdict(results.path, data, summary, master.progress, spurious)
    picture = _write_more(results.path, error, report)
    case = master.assembly.system.name
    return Outcome(case, master.settings, master.progress, summary, results.path, picture, spurious, error, answer)


def _write_more(path: Path, error: str | None, report: Report) -> Path | None:
    """Draw what was recorded and write it in other forms, as wanted; return the picture."""
    if not (report.picture or report.csv or report.parquet):
        return None
    picture = path.with_suffix(".png") if report.picture else None
    with open_results(path) as data:
        try:
            if picture is not None:
                from ..figures.run import draw_run  # noqa: PLC0415

                draw_run(data, picture)
            if report.csv:
                write_csv(data, path.with_suffix(".csv"))
            if report.parquet:
                write_parquet(data, path.with_suffix(".parquet"))
        except OSError as failure:
            said = f"cannot write beside {path}: {failure.strerror or failure}"
            raise SimulationError(f"{error}; {said}" if error else said) from None
    return picture
