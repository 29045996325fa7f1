"""The command `curvesqueal competition`: a case in, the distribution of its dominant frequency out."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from ...errors import InputError
from ...runs.changes import Changes
from ..options import System, changes_system
from ..tools import Json, messages, notice, say, screen


@changes_system
def competition(  # noqa: PLR0913 - one argument per option
    case: System,
    *,
    changes: Changes,
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
    compare: Annotated[
        bool, typer.Option("--cycles/--no-cycles", help="Compare every end with the limit cycles of the system.")
    ] = True,
    json: Json = False,
) -> None:
    """Find which tone wins: many random starts of a case, and how often each dominant frequency comes out.

    Stopped half-way, it keeps what is done; called again, it goes on from there.
    """
    from ...campaigns.competition import Starts, compete, competition_plan  # noqa: PLC0415 - loads scipy and dask
    from ...campaigns.sweep import How  # noqa: PLC0415
    from ...figures.competition import draw_competition  # noqa: PLC0415
    from ...runs.stopping import stop_on_signals  # noqa: PLC0415

    starts = Starts(runs, seed, start_mode or (), stiffness or ())
    plan = competition_plan(changes.scenario(case, duration=duration, step=step), starts)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with (
        Progress(*columns, console=messages, transient=True, disable=not messages.is_terminal) as bar,
        stop_on_signals() as stop_requested,
    ):
        task = bar.add_task("runs", total=None)

        def report(now: Any) -> None:
            bar.update(task, total=now.wanted, completed=now.done + now.failed)

        ended = compete(plan, out, How(workers=max(1, jobs), report=report, stop_requested=stop_requested))
    picture = out / f"competition-{Path(case).stem}.png"
    if ended.groups:
        draw_competition(case, ended.groups, picture)
    words = _compared(plan, ended) if compare and ended.groups else {}
    if json:
        screen.print_json(data={**_described(case, ended, picture), "cycles": words})
    else:
        _show(case, ended.groups, ended.store, picture)
        for group, lines in words.items():
            for line in lines:
                screen.print(f"{group}: {line}" if len(words) > 1 else line, highlight=False, soft_wrap=True)
    for sentence in ended.failures:
        say(f"failed: {sentence}")
    if ended.done < ended.wanted and not ended.failures:
        say(f"stopped after {ended.done} of {ended.wanted} runs; the same command goes on from there")
        raise typer.Exit(130)


def _compared(plan: Any, ended: Any) -> dict[str, Any]:
    """Return what the ends are among the limit cycles; nothing, with a notice, where these are not known."""
    from ...campaigns.competition import against_cycles  # noqa: PLC0415 - loads scipy and dask

    try:
        return dict(against_cycles(plan, ended))
    except InputError as reason:
        notice(f"the ends are not compared with limit cycles: {reason}")
        return {}


def _described(case: str, ended: Any, picture: Path) -> dict[str, Any]:
    """Return the whole as one JSON object."""
    groups = ended.groups
    return {
        "case": case,
        "wanted": ended.wanted,
        "done": ended.done,
        "failures": list(ended.failures),
        "confidence": 0.95,
        "starts": {key: [t.as_data() for t in found] for key, found in groups.items()},
        "runs": str(ended.store),
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
            interval = f"{t.low:.0%} to {t.high:.0%}"
            table.add_row(words if i == 0 else "", t.words, f"{t.count} of {t.of}", f"{t.share:.0%}", interval)
    screen.print(table)
    screen.print(f"runs     {path}\npicture  {picture}", highlight=False, soft_wrap=True)
