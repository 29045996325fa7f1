"""The command `curvesqueal sweep`: a plan in, a store of its runs out."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ...campaigns.plan import read_plan
from ..tools import Json, messages, say, screen

_PIPED_EVERY = 5.0
"""Time between two lines of progress where there is no terminal [s]."""


def sweep(  # noqa: PLR0913, PLR0917 - one argument per option
    plan: Annotated[Path, typer.Argument(metavar="PLAN.toml", help="What varies and what is computed.")],
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, such as tcp://host:8786; default: this machine.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes on this machine; default: one per core.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Store; default: as the plan, with .zarr.")] = None,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Say how many runs, how long, how large; run none.")
    ] = False,
    retry_failed: Annotated[bool, typer.Option("--retry-failed", help="Make failed runs again.")] = False,
    parquet: Annotated[Path | None, typer.Option(help="Write the rows as Parquet, too.")] = None,
    json: Json = False,
) -> None:
    """Run a campaign: every point of a plan, on this machine or on any Dask cluster.

    A run that fails is a row with its sentence. Stopped or killed, it keeps what is done; the same plan goes on from
    there.
    """
    from ...campaigns import sweep as campaign  # noqa: PLC0415 - dask takes its time
    from ...campaigns.results.export import write_rows  # noqa: PLC0415
    from ...runs.stopping import stop_on_signals  # noqa: PLC0415

    the_plan = read_plan(plan)
    path = out or plan.with_suffix(".zarr")
    if dry_run:
        found = campaign.estimate(the_plan, workers or os.cpu_count() or 1)
        if json:
            screen.print_json(data={"plan": str(plan), **found.__dict__})
        else:
            screen.print(
                f"{found.runs:,} runs, about {_time(found.seconds)} ({found.seconds_per_run:.3g} s of a core each), "
                f"about {found.bytes / 1e6:.3g} MB",
                highlight=False,
            )
        return
    with stop_on_signals() as stop_requested, _following() as report:
        how = campaign.How(scheduler, workers, retry_failed, report, say, stop_requested)
        begin = time.monotonic()
        ended = campaign.sweep(the_plan, path, how)
        seconds = time.monotonic() - begin
    if parquet is not None:
        write_rows(path, parquet)
    if json:
        data = {"store": str(path), "runs": ended.wanted, "done": ended.done, "failed": ended.failed, "wall_s": seconds}
        screen.print_json(data=data)
    else:
        screen.print(f"{path}: {ended.done} of {ended.wanted} runs done, {ended.failed} failed", highlight=False)
    if ended.done + ended.failed < ended.wanted:
        say("stopped; the same command goes on from there")
        raise typer.Exit(130)


def _time(seconds: float) -> str:
    """Return a time as people say it."""
    if seconds < 120:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.0f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


@contextmanager
def _following() -> Iterator[Callable[..., None]]:
    """Show progress with rate and time left: a bar on a terminal, a line now and then where there is none."""
    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(),
    )  # fmt: skip
    last = [time.monotonic()]
    with Progress(*columns, console=messages, transient=True, disable=not messages.is_terminal) as bar:
        task = bar.add_task("runs", total=None, rate="")

        def report(now: campaign.Progress) -> None:  # type: ignore[name-defined]  # noqa: F821
            over = now.done + now.failed
            bar.update(task, total=now.wanted, completed=over, rate=f"{now.rate:.3g}/s")
            if not messages.is_terminal and time.monotonic() - last[0] >= _PIPED_EVERY:
                last[0] = time.monotonic()
                left = "" if now.left_s is None else f", {_time(now.left_s)} left"
                say(f"{over} of {now.wanted} runs, {now.failed} failed, {now.rate:.3g} runs/s{left}")

        yield report
