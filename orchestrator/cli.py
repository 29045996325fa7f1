"""The command line `curvesqueal`."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable

import typer

from .commands import rail, wheel
from .commands.build import build
from .commands.check import check
from .commands.competition import competition
from .commands.coupling import coupling
from .commands.export import export
from .commands.friction import friction
from .commands.info import info
from .commands.listen import listen
from .commands.paper import paper
from .commands.rail_measured import measured as rail_measured
from .commands.report import report
from .commands.run import resume, run
from .commands.stability import stability
from .commands.table4 import table4
from .commands.tools import say
from .errors import InputError, SimulationError

app = typer.Typer(
    name="curvesqueal",
    help="Railway curve squeal as FMI co-simulation: build the FMUs, run the paper's cases, look inside.",
    rich_markup_mode=None,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
rails = typer.Typer(
    help="Rails: fit modal data to a track or a measurement, draw receptances, build FMUs.", no_args_is_help=True
)
wheels = typer.Typer(help="Wheels: build an FMU from modal data, draw sections and modes.", no_args_is_help=True)

COMMANDS: tuple[Callable[..., None], ...] = (
    build, run, resume, info, friction, check, export, coupling, stability, table4, listen, report, competition, paper,
)  # fmt: skip
RAIL_COMMANDS: tuple[Callable[..., None], ...] = (rail.fit, rail.figures, rail.build, rail.regenerate)
WHEEL_COMMANDS: tuple[Callable[..., None], ...] = (wheel.build, wheel.figures)
for command in COMMANDS:
    app.command()(command)
for command in RAIL_COMMANDS:
    rails.command()(command)
rails.command("measured")(rail_measured)
for command in WHEEL_COMMANDS:
    wheels.command()(command)
app.add_typer(rails, name="rail")
app.add_typer(wheels, name="wheel")


def command_line() -> int:
    """Run the command line and return its exit code; a user's mistake is one sentence and a non-zero code."""
    try:
        app()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except (InputError, SimulationError) as error:
        say(f"curvesqueal: {error}")
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
