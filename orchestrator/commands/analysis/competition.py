"""The command `curvesqueal competition`: a case in, the distribution of its dominant frequency out."""

from __future__ import annotations

import json as json_format
import os
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ..tools import Json, messages, screen


def competition(  # noqa: PLR0913, PLR0917 - one argument per option
    case: Annotated[
        str,
        typer.Argument(metavar="CASE|FILE", help="case1 to case4, inferred1 to inferred4, an .ssp or an .ssd file."),
    ],
    runs: Annotated[int, typer.Option(help="Starts for every start mode and stiffness.")] = 20,
    seed: Annotated[int, typer.Option(help="Seed of the first start; the next ones count up.")] = 0,
    start_mode: Annotated[
        list[float] | None,
        typer.Option(help="Start on the wheel mode near this frequency [Hz], at 0.1 m/s. Repeatable."),
    ] = None,
    stiffness: Annotated[
        list[float] | None, typer.Option(help="Stiffness of the contact spring [N/m]. Repeatable.")
    ] = None,
    duration: Annotated[float | None, typer.Option(help="Simulated time of a run [s]; default as the system.")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; default as the system.")] = None,
    jobs: Annotated[int, typer.Option(help="Processes at once; default: one per core.")] = os.cpu_count() or 1,
    out: Annotated[Path, typer.Option(help="Folder for the list of runs and the picture.")] = Path("results"),
    json: Json = False,
) -> None:
    """Find which tone wins: many random starts of a case, and how often each dominant frequency comes out.

    Stopped half-way, it keeps what is done; called again, it goes on from there.
    """
    from ...figures.competition import draw_competition  # noqa: PLC0415
    from ...runs.competition import compete, plan  # noqa: PLC0415 - loads scipy
    from ...runs.stopping import stop_on_signals  # noqa: PLC0415

    trials = [
        replace(trial, duration=duration, step=step)
        for trial in plan(case, runs, seed, start_mode or [], stiffness or [])
    ]
    name = f"competition-{Path(case).stem}"
    path = out / f"{name}.jsonl"
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with (
        Progress(*columns, console=messages, transient=True, disable=not messages.is_terminal) as bar,
        stop_on_signals() as stop_requested,
    ):
        task = bar.add_task("runs", total=len(trials))
        endings = compete(trials, path, jobs, lambda done, _: bar.update(task, completed=done), stop_requested)
    groups = _groups(endings)
    picture = out / f"{name}.png"
    if endings:
        draw_competition(case, groups, picture)
    if json:
        typer.echo(json_format.dumps(_described(case, groups, path, picture, len(trials)), indent=1))
    else:
        _show(case, groups, path, picture)
    if len(endings) < len(trials):
        messages.print(
            f"stopped after {len(endings)} of {len(trials)} runs; the same command goes on from there", highlight=False
        )
        raise typer.Exit(130)


def _groups(endings: list[Any]) -> dict[str, list[Any]]:
    """Return the tones by what was common to their starts, in words."""
    from ...signals.tones import tones  # noqa: PLC0415

    words: dict[str, list[Any]] = {}
    for ending in sorted(endings, key=lambda e: (e.trial.stiffness or 0, e.trial.start_hz or 0)):
        t = ending.trial
        start = "random start" if t.start_hz is None else f"started at {t.start_hz:g} Hz"
        spring = "" if t.stiffness is None else f", {t.stiffness:g} N/m"
        words.setdefault(start + spring, []).append(ending)
    return {key: tones(e.frequency_hz for e in group) for key, group in words.items()}


def _described(case: str, groups: dict[str, list[Any]], path: Path, picture: Path, wanted: int) -> dict[str, Any]:
    """Return the whole as one JSON object."""
    return {
        "case": case,
        "wanted": wanted,
        "done": sum(t.count for found in groups.values() for t in found),
        "confidence": 0.95,
        "starts": {key: [{**asdict(t), "share": t.share} for t in found] for key, found in groups.items()},
        "runs": str(path),
        "picture": str(picture),
    }


def _show(case: str, groups: dict[str, list[Any]], path: Path, picture: Path) -> None:
    """Print a table of the tones."""
    table = Table(title=f"{case}: dominant frequency of the wheel's lateral velocity", title_justify="left")
    table.add_column("start")
    for heading in ("frequency", "runs", "share", "95 % confidence"):
        table.add_column(heading, justify="right")
    for words, found in groups.items():
        for i, t in enumerate(found):
            frequency = "at rest" if t.frequency_hz is None else f"{t.frequency_hz:.1f} Hz"
            interval = f"{t.low:.0%} to {t.high:.0%}"
            table.add_row(words if i == 0 else "", frequency, f"{t.count} of {t.of}", f"{t.share:.0%}", interval)
    screen.print(table)
    screen.print(f"runs     {path}\npicture  {picture}", highlight=False, soft_wrap=True)
