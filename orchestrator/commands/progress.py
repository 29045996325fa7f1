"""Progress of a run on the error stream."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from ..coupling import master
from .tools import messages


@contextmanager
def run_bar() -> Iterator[Callable[[master.Progress], None]]:
    """Show a bar on the error stream, with simulated time and time to go."""
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[now]}"), TimeRemainingColumn())
    with Progress(*columns, console=messages, transient=True, disable=not messages.is_terminal) as bar:
        task = bar.add_task("loading", total=None, now="")

        def report(progress: master.Progress) -> None:
            bar.update(
                task,
                description="simulating",
                total=progress.total,
                completed=progress.steps,
                now=f"{progress.steps / progress.total:.0%}",
            )

        yield report
