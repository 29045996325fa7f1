"""The command line `curvesqueal`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from fmus.interface import DIRECTIONS

from . import master, report_commands, running
from .algorithms import ALGORITHMS
from .command_tools import Json, Replace, Seed, Values
from .commands.map import map_
from .commands.sweep import sweep
from .competition_commands import competition
from .coupling_commands import coupling
from .errors import InputError, SimulationError
from .export_commands import export
from .outcome import Outcome, as_json
from .paper import paper
from .rail_commands import check, rail_app
from .recording import patterns
from .scenario import Scenario, built_ssp, parse_sources, parse_values
from .sound_commands import listen
from .stability_commands import stability, table4
from .wheel_commands import wheel_app

Csv = Annotated[bool, typer.Option("--csv", help="Write the results as CSV, too.")]
CheckpointEvery = Annotated[float, typer.Option(min=0.0, help="Wall time between checkpoints [s].")]

app = typer.Typer(
    name="curvesqueal",
    help="Railway curve squeal as FMI co-simulation: build the FMUs, run the paper's cases, look inside.",
    rich_markup_mode=None,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
messages = Console(stderr=True)
screen = Console()


@app.command()
def build(
    out: Annotated[Path, typer.Option(help="Folder for the FMUs and the SSP.")] = Path("build"),
    flavour: Annotated[
        str | None,
        typer.Option(help="native, python or all (one folder each); default: native if a C compiler is there."),
    ] = None,
    fmi: Annotated[int, typer.Option(help="Version of FMI: 2 or 3.")] = 2,
    platforms: Annotated[
        str, typer.Option(help="Native FMUs: x86_64-linux,aarch64-linux,x86_64-windows,... Default: this one.")
    ] = "",
    json: Json = False,
) -> None:
    """Build the FMUs (wheel, rails, contact, system) and the SSP that couples them."""
    from fmus.packaging import build as building  # noqa: PLC0415 - compiles kernels

    files: list[Path] = []

    def report(path: Path) -> None:
        files.append(path)
        if not json:
            screen.print(f"{path}  ({path.stat().st_size / 1000:.0f} kB)", highlight=False)

    try:
        chosen = building.targets(flavour, fmi, [name for name in platforms.split(",") if name])
        for target in chosen:
            _say(str(target))
            building.build(out / target.flavour if len(chosen) > 1 else out, target, report)
    except ValueError as error:
        raise InputError(str(error)) from None
    except RuntimeError as error:
        raise SimulationError(f"build: {error}") from None
    except OSError as error:
        raise InputError(f"{out}: cannot write there: {error.strerror or error}") from None
    if json:
        screen.print_json(data={"files": [str(path) for path in files]})


@app.command()
def run(  # noqa: PLR0913, PLR0917 - one argument per option
    system: Annotated[str, typer.Argument(metavar="CASE|FILE", help="case1 to case4, an .ssp or an .ssd file.")],
    duration: Annotated[float | None, typer.Option(help="Simulated time [s]; default as the system says: 6.")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; default as the system: 5e-6.")] = None,
    algorithm: Annotated[str | None, typer.Option(help=f"Master algorithm: {', '.join(ALGORITHMS)}.")] = None,
    values: Values = None,
    replace: Replace = None,
    seed: Seed = None,
    record_every: Annotated[int, typer.Option(help="Record after every this many steps.")] = 4,
    record: Annotated[
        list[str] | None,
        typer.Option(help="Record local variables, too, such as 'rail.modal_*'; 'none' for none. Repeatable."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Folder for results and picture.")] = Path("results"),
    parquet: Annotated[bool, typer.Option("--parquet", help="Write the results as Parquet, too.")] = False,
    isolate: Annotated[bool, typer.Option("--isolate", help="Each FMU in a process of its own, slowly.")] = False,
    timeout: Annotated[float, typer.Option(help="Time that a call may take with --isolate [s].")] = 10.0,
    csv: Csv = False,
    checkpoint: Annotated[Path | None, typer.Option(help="Keep checkpoints in this file, for `resume`.")] = None,
    checkpoint_every: CheckpointEvery = running.Keeping.every,
    json: Json = False,
) -> None:
    """Simulate a case of the paper or any system of co-simulation FMUs.

    Leaves results (NetCDF) and a picture of velocities and spectra; prints dominant frequency, levels and energies.
    """
    scenario = Scenario(
        system=system,
        duration=duration,
        step=step,
        algorithm=algorithm,
        values=parse_values(values or []),
        sources=parse_sources(replace or []),
        seed=seed,
        record_every=record_every,
        record=patterns(record),
        timeout=timeout if isolate else None,
    )
    keeping = None if checkpoint is None else running.Keeping(checkpoint, checkpoint_every)
    with _progress_bar() as progress:
        outcome = running.run_scenario(scenario, out, running.Report(progress, _notice, csv, parquet=parquet), keeping)
    _tell(outcome, json)


@app.command()
def resume(
    checkpoint: Annotated[Path, typer.Argument(help="File that `run --checkpoint` wrote.")],
    csv: Csv = False,
    checkpoint_every: CheckpointEvery = running.Keeping.every,
    json: Json = False,
) -> None:
    """Go on with a run from its checkpoint, to the bit as if it had never stopped; the results file grows."""
    with _progress_bar() as progress:
        outcome = running.resume(checkpoint, running.Report(progress, _notice, csv), checkpoint_every)
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
        _say(f"stopped; results up to then are in {outcome.results}")
        raise typer.Exit(130)


def _say(text: str) -> None:
    """Print a sentence on the error stream, as it is."""
    messages.print(text, markup=False, highlight=False, soft_wrap=True)


def _notice(text: str) -> None:
    _say(f"note: {text}")


@contextmanager
def _progress_bar() -> Iterator[Callable[[master.Progress], None]]:
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


def _show(outcome: Outcome) -> None:
    """Print the table of a run."""
    s, p = outcome.summary, outcome.progress
    time = p.steps * outcome.settings.step
    title = (
        f"{outcome.case}: {time:g} s in {p.steps} steps of {outcome.settings.step:g} s ({outcome.settings.algorithm})"
    )
    table = Table(title=title, title_justify="left")
    for heading in ("", *DIRECTIONS):
        table.add_column(heading, justify="right" if heading else "left")
    rows = (
        ("wheel velocity, rms [m/s, rad/s]", s.wheel_velocity_rms),
        ("rail velocity, rms [m/s, rad/s]", s.rail_velocity_rms),
        ("energy into wheel and rail [J]", p.energy_into_structures),
        ("energy residual of the coupling [J]", p.energy_residual),
    )
    for label, numbers in rows:
        table.add_row(escape(label), *(f"{numbers[d]:.3g}" if d in numbers else "-" for d in DIRECTIONS))
    screen.print(table)
    lines = {
        "dominant frequency": "none" if s.dominant_frequency_hz is None else f"{s.dominant_frequency_hz:.1f} Hz",
        "growth rate": "none seen" if s.growth_rate is None else f"{s.growth_rate:.2f} 1/s",
        "energy residual": _share(sum(p.energy_residual.values()), s.energy_dissipated),
        "spurious growth": outcome.spurious.sentence,
        **({"sweeps": f"{p.sweeps:.1f} per step, at most {p.most_sweeps}"} if p.most_sweeps > 1 else {}),
        "contact lost": "-" if s.contact_lost is None else f"{s.contact_lost:.1%} of the time",
        "wall time": f"{p.wall:.1f} s ({p.wall / max(p.steps, 1) * 1e6:.1f} us per step)",
        "results": str(outcome.results),
        "picture": str(outcome.picture),
    }
    for label, text in lines.items():
        screen.print(f"{label:20}{text}", highlight=False, soft_wrap=True)


def _share(residual: float, dissipated: float | None) -> str:
    """Return the energy that the coupling added, and against what the contact dissipated."""
    against = f", {abs(residual / dissipated):.1e} of the {dissipated:.3g} J dissipated" if dissipated else ""
    return f"{residual:.3g} J in all directions{against}"


@app.command()
def info(
    file: Annotated[Path, typer.Argument(help="An .fmu, .ssp or .ssd file.")],
    json: Json = False,
) -> None:
    """Show what is inside an FMU or a system."""
    from . import inspection  # noqa: PLC0415 - keeps the start of the other commands short

    description = inspection.describe(file)
    if json:
        screen.print_json(data=description)
    else:
        for table in inspection.tables(description):
            screen.print(table)


@app.command()
def friction(
    out: Annotated[Path, typer.Option(help="Picture to write.")] = Path("results/friction.png"),
    contact: Annotated[Path | None, typer.Option(help="Contact FMU; default: the project's own.")] = None,
    json: Json = False,
) -> None:
    """Draw the two friction curves of the paper, its figure 5, from the contact FMU."""
    from .archive import unpack  # noqa: PLC0415
    from .figures import draw_friction  # noqa: PLC0415
    from .friction_curve import friction_curve  # noqa: PLC0415

    fmu = contact or unpack(built_ssp(), "SSP") / "resources" / "contact.fmu"
    creepage = np.concatenate([np.linspace(0.0, 0.006, 61), np.linspace(0.0065, 0.05, 88)])
    curves = {
        "constant friction": friction_curve(fmu, creepage, {"falling_ratio": 0.0}),
        "falling friction": friction_curve(fmu, creepage),
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    draw_friction(creepage, curves, out)
    if json:
        screen.print_json(data={"creepage": creepage.tolist(), **{k: v.tolist() for k, v in curves.items()}})
    else:
        screen.print(str(out), highlight=False)


app.add_typer(rail_app, name="rail")
app.add_typer(wheel_app, name="wheel")
app.command()(check)
app.command()(export)
app.command()(coupling)
app.command()(stability)
app.command()(table4)
app.command()(listen)
app.command()(report_commands.report)
app.command()(competition)
app.command()(sweep)
app.command("map")(map_)
app.command()(paper)


def command_line() -> int:
    """Run the command line and return its exit code; a user's mistake is one sentence and a non-zero code."""
    try:
        app()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except (InputError, SimulationError) as error:
        _say(f"curvesqueal: {error}")
        return 1
    return 0


def main() -> None:
    """Run the command line and leave the process at once.

    PythonFMU 0.7.0 frees its state twice when a process ends in the usual way, and an FMU that failed may have damaged
    it anyway: the libraries of FMUs get no chance to do more.
    """
    code = command_line()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
