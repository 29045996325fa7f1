"""The command `export`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...coupling.algorithms import ALGORITHMS
from ...errors import InputError
from ...runs.changes import Changes
from ..options import System, changes_system
from ..tools import Force, Json, Seed, messages, screen, user_mistakes


@changes_system
def export(  # noqa: PLR0913 - one argument per option
    system: System,
    out: Annotated[Path, typer.Argument(metavar="OUT.ssp", help="File to write.")],
    duration: Annotated[float | None, typer.Option(help="Simulated time [s]; default as the system says.")] = None,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; default as the system says.")] = None,
    algorithm: Annotated[str | None, typer.Option(help=f"Master algorithm: {', '.join(ALGORITHMS)}.")] = None,
    *,
    changes: Changes,
    seed: Seed = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Write the system that `run` would run with the same options as an .ssp that reproduces the run.

    The archive is flat and complete: FMUs, one parameter set per component, connections, step size and algorithm.
    """
    from ...runs.export import export_system  # noqa: PLC0415 - keeps the start of the other commands short

    if out.suffix != ".ssp":
        raise InputError(f"{out}: must end with .ssp")
    if out.exists() and not force:
        raise InputError(f"{out}: is there already; give another name, or --force to overwrite it")
    scenario = changes.scenario(system, duration=duration, step=step, algorithm=algorithm, seed=seed)
    assembly, settings = scenario.prepare()
    with user_mistakes():
        export_system(assembly, settings, out)
    for notice in assembly.notices:
        messages.print(f"note: {notice}", markup=False, highlight=False, soft_wrap=True)
    if json:
        screen.print_json(data={"file": str(out), "components": list(assembly.fmus), "notices": assembly.notices})
    else:
        screen.print(f"{out}  ({out.stat().st_size / 1000:.0f} kB)", markup=False, highlight=False, soft_wrap=True)
