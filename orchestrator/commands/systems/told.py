"""What `run` and `resume` say of a run: JSON, or the verdict, a table and what follows."""

from __future__ import annotations

from collections.abc import Mapping
from shlex import quote

import typer
from rich.table import Table

from fmus.interface import DIRECTIONS

from ...coupling.settings import Progress
from ...errors import SimulationError
from ...runs.outcome import Outcome, as_json
from ...runs.verdict import energy_share
from ...signals.axes import NORMAL, PLANE
from ...signals.figures_told import FIGURES, rows_by_direction
from ..tools import notice, say, screen


def tell(outcome: Outcome, json: bool) -> None:
    """Print what came out; an early end is an error or, where it was asked for, exit code 130."""
    if json:
        typer.echo(as_json(outcome))
    else:
        _show(outcome)
    if outcome.error is not None:
        raise SimulationError(f"{outcome.error}; results up to then are in {outcome.results}")
    if outcome.progress.stopped:
        say(f"stopped; results up to then are in {outcome.results}")
        raise typer.Exit(130)
    if outcome.progress.ended is not None:
        notice(outcome.progress.ended)


def _show(outcome: Outcome) -> None:
    """Print the table of a run."""
    s, p = outcome.summary, outcome.progress
    time = p.steps * outcome.settings.step
    title = (
        f"{outcome.case}: {time:g} s in {p.steps} steps of {outcome.settings.step:g} s ({outcome.settings.algorithm})"
    )
    table = Table(title=title, title_justify="left")
    columns = (*DIRECTIONS, PLANE, NORMAL)
    for heading in ("", *columns):
        table.add_column(heading, justify="right" if heading else "left")
    rows = (
        *((f"{label} [{unit}]", numbers) for label, (unit, numbers) in rows_by_direction(s).items()),
        ("energy into wheel and rail [J]", p.energy_into_structures),
        ("energy residual of the coupling [J]", _in_contact_axes(p.energy_residual)),
    )
    for label, numbers in rows:
        table.add_row(label, *(f"{numbers[d]:.3g}" if d in numbers else "-" for d in columns))
    screen.print(outcome.verdict.sentence, highlight=False, markup=False, soft_wrap=True)
    screen.print(table)
    lines = {
        **{figure.label: figure.words(s) for figure in FIGURES if not isinstance(figure.value(s), Mapping)},
        "energy residual": _balance(p),
        "spurious growth": outcome.spurious.sentence,
        **({"sweeps": f"{p.sweeps:.1f} per step, at most {p.most_sweeps}"} if p.most_sweeps > 1 else {}),
        "wall time": f"{p.wall:.1f} s ({p.wall / max(p.steps, 1) * 1e6:.1f} us per step)",
        "results": str(outcome.results),
        "picture": f"curvesqueal picture {quote(str(outcome.results))}"
        if outcome.picture is None
        else str(outcome.picture),
    }
    for label, text in lines.items():
        screen.print(f"{label:20}{text}", highlight=False, soft_wrap=True)


def _in_contact_axes(residual: Mapping[str, float]) -> Mapping[str, float]:
    """Return an account by contact direction under the names of the table's columns; one in track axes as it is."""
    return {PLANE if d == "lat" and NORMAL in residual else d: energy for d, energy in residual.items()}


def _balance(progress: Progress) -> str:
    """Return the energy that the coupling added, and against what wheel and rail took."""
    took = " and ".join(f"the {name} {energy:.3g} J" for name, energy in progress.energy_into.items())
    share = energy_share(progress)
    added = f"{sum(progress.energy_residual.values()):.2g} J in all"
    return added if share is None else f"{added}, {share:.1e} of what went into the structures ({took})"
