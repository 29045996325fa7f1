"""The commands `run` and `resume`."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from shlex import quote
from typing import Annotated

import typer
from rich.table import Table

from fmus.interface import DIRECTIONS

from ...coupling.algorithms import ALGORITHMS
from ...coupling.recording import patterns
from ...coupling.settings import Progress
from ...errors import SimulationError
from ...runs import run as running
from ...runs.changes import Changes
from ...runs.outcome import Outcome, as_json
from ...runs.verdict import energy_share
from ...signals.axes import NORMAL, PLANE
from ...signals.figures_told import FIGURES, rows_by_direction
from ..options import System, changes_system
from ..progress import run_bar
from ..tools import Json, Seed, notice, say, screen

Csv = Annotated[bool, typer.Option("--csv", help="Write the results as CSV, too.")]

CheckpointEvery = Annotated[float, typer.Option(min=0.0, help="Wall time between checkpoints [s].")]


@changes_system
def run(  # noqa: PLR0913 - one argument per option
    system: System,
    duration: Annotated[float | None, typer.Option(help="Simulated time [s]; default as the system says: 6.")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; default as the system: 5e-6.")] = None,
    algorithm: Annotated[str | None, typer.Option(help=f"Master algorithm: {', '.join(ALGORITHMS)}.")] = None,
    *,
    changes: Changes,
    seed: Seed = None,
    start_cycle: Annotated[
        float | None,
        typer.Option(help="Start on the limit cycle near this frequency [Hz], as `cycle` finds it: no growth phase."),
    ] = None,
    record_every: Annotated[int, typer.Option(help="Record after every this many steps.")] = 4,
    record: Annotated[
        list[str] | None,
        typer.Option(help="Record local variables, too, such as 'rail.modal_*'; 'none' for none. Repeatable."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("results"),
    parquet: Annotated[bool, typer.Option("--parquet", help="Write the results as Parquet, too.")] = False,
    isolate: Annotated[
        bool,
        typer.Option(
            "--isolate", help="Each FMU in a process of its own, slowly: protects against crashes and hangs only."
        ),
    ] = False,
    timeout: Annotated[float, typer.Option(help="Time that a call may take with --isolate [s].")] = 10.0,
    csv: Csv = False,
    picture: Annotated[
        bool, typer.Option("--picture", help="Draw histories and spectra, too; `picture` does so later.")
    ] = False,
    checkpoint: Annotated[Path | None, typer.Option(help="Keep checkpoints in this file, for `resume`.")] = None,
    checkpoint_every: CheckpointEvery = running.Keeping.every,
    strict: Annotated[bool, typer.Option("--strict", help="Refuse files with faults that change no number.")] = False,
    check: Annotated[bool, typer.Option(help="Try replaced structures before the run: sign, size, energy.")] = True,
    json: Json = False,
) -> None:
    """Simulate a case of the paper or any system of co-simulation FMUs.

    Leaves results (NetCDF), of which `picture`, `report` and `listen` make more; prints the verdict, levels, energies.

    Running an FMU runs its code: take FMUs from sources that you trust.
    """
    scenario = changes.scenario(
        system,
        duration=duration,
        step=step,
        algorithm=algorithm,
        seed=seed,
        record_every=record_every,
        record=patterns(record),
        timeout=timeout if isolate else None,
        strict=strict,
    )
    if start_cycle is not None:
        from ...runs.starts import on_cycle  # noqa: PLC0415 - compiles the cycles' kernels

        scenario = on_cycle(scenario, start_cycle)
    keeping = None if checkpoint is None else running.Keeping(checkpoint, checkpoint_every)
    with run_bar() as progress:
        outcome = running.run_scenario(
            scenario, out, running.Report(progress, notice, csv, picture, parquet, check), keeping
        )
    _tell(outcome, json)


def resume(
    checkpoint: Annotated[Path, typer.Argument(help="File that `run --checkpoint` wrote.")],
    csv: Csv = False,
    checkpoint_every: CheckpointEvery = running.Keeping.every,
    json: Json = False,
) -> None:
    """Go on with a run from its checkpoint, to the bit as if it had never stopped; the results file grows."""
    with run_bar() as progress:
        outcome = running.resume(checkpoint, running.Report(progress, notice, csv), checkpoint_every)
    _tell(outcome, json)


def _tell(outcome: Outcome, json: bool) -> None:
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
