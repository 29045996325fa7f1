"""The command `run`: a case, a system or an FMU in, results out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...coupling.algorithms import ALGORITHMS
from ...coupling.recording import patterns
from ...runs import run as running
from ...runs.changes import Changes
from ..options import System, changes_system
from ..progress import run_bar
from ..tools import Json, Seed, notice
from .told import tell

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
    tell(outcome, json)
