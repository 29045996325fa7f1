"""The command line `curvesqueal`: a table of commands, each loaded when it is asked for, and what a failure looks like.

Loading a command late is what keeps `--help` and completion fast: numba, fmpy and matplotlib take seconds together.
"""

from __future__ import annotations

import os
import re
import sys
import traceback
import warnings
from collections.abc import Callable
from contextlib import suppress
from functools import wraps
from importlib import import_module
from importlib.metadata import version as version_of
from pathlib import Path
from typing import Annotated, Any, ClassVar

import typer
from typer.core import TyperGroup

from .errors import DamageWarning, InputError, SimulationError
from .fmi.exit_guard import tell_who_ends_the_process
from .streams import BROKEN, broken, end_on_interrupt, flushed, keep_standard_output, open_closed_streams
from .visible import visible

Table = dict[str, tuple[str, str]]
"""Name of a command: its module in `orchestrator.commands` (`:function` if that has another name), what it does."""

COMMANDS: Table = {
    "build": ("systems.build", "Build the FMUs (wheel, rails, contact, system) and the SSP that couples them."),
    "run": ("systems.run", "Simulate a case of the paper or any system of co-simulation FMUs."),
    "resume": ("systems.resume", "Go on with a run from its checkpoint, to the bit as if it had never stopped."),
    "info": ("systems.info", "Show what is inside an FMU or a system."),
    "friction": (
        "analysis.friction:friction",
        "Draw friction curves, by default those of figure 5, from the contact FMU.",
    ),
    "check": (
        "systems.check:check",
        "Test an FMU against the contract of a rail.",
    ),
    "export": (
        "systems.export:export",
        "Write the system that `run` would run with the same options, for other tools.",
    ),
    "coupling": (
        "analysis.coupling:coupling",
        "Show what each master algorithm does to the growth rates, mode by mode.",
    ),
    "stability": ("analysis.stability", "Find the unstable frequencies of a case or of a system of FMUs."),
    "cycle": (
        "analysis.cycle",
        "Find every tone that a system can squeal at and whether it lasts, by harmonic balance.",
    ),
    "curve": ("analysis.curve", "Find how a bogie runs through a curve, and which of its wheels squeals."),
    "table4": (
        "pages.table4:table4",
        "Print Table 4 of the paper next to ours, cell by cell.",
    ),
    "listen": (
        "pages.listen",
        "Make the sound of a run, or of a case that is run first, as a WAV file.",
    ),
    "picture": ("pages.picture", "Draw histories and spectra of a run from its results."),
    "report": ("pages.report", "Write one self-contained HTML page about runs."),
    "competition": ("analysis.competition", "Find which tone wins: many random starts of a case."),
    "sweep": ("analysis.sweep", "Run a campaign: every point of a plan, on this machine or on a Dask cluster."),
    "map": ("analysis.map", "Show a campaign: a quantity over two parameters, Sobol indices, shares of tones."),
    "paper": ("pages.paper", "Write the page that sets every table, figure and claim of the paper next to ours."),
}
RAIL_COMMANDS: Table = {
    "fit": ("structures.rail_fit", "Fit a modal rail to the analytical track of a track file."),
    "figures": ("structures.rail_figures", "Draw the receptances of a track and its modal rails."),
    "measured": ("structures.rail_measured", "Fit a passive modal rail to measured functions."),
    "build": ("structures.rail_build", "Build a rail FMU from a modal data file."),
    "regenerate": ("structures.rail_regenerate", "Make the modal data files that the project ships anew."),
}
WHEEL_COMMANDS: Table = {
    "build": ("structures.wheel_build", "Build a wheel FMU from modal data or finite elements."),
    "treat": ("structures.wheel_treat", "Write a wheel with tuned absorbers or more damping."),
    "measured": ("structures.wheel_measured", "Fit a passive modal wheel to measured functions."),
    "figures": ("structures.wheel_figures", "Draw cross-sections and modes of the shipped wheels."),
}
FAULT = 70
"""Exit code of a fault of this program, EX_SOFTWARE of sysexits.h."""


class LateGroup(TyperGroup):
    """A group whose commands are imported when they are asked for."""

    table: ClassVar[Table] = {}

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the names, in the order of the table, then those of groups."""
        return [*self.table, *super().list_commands(ctx)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Import and return a command."""
        if cmd_name not in self.table:
            return super().get_command(ctx, cmd_name)
        module, _, function = self.table[cmd_name][0].partition(":")
        one = typer.Typer(add_completion=False, rich_markup_mode=None)
        command = getattr(import_module(f".commands.{module}", __package__), function or cmd_name)
        one.command(cmd_name)(_with_absolute_paths(command))
        return typer.main.get_command(one)

    def format_commands(self, _ctx: Any, formatter: Any) -> None:
        """List the commands with what they do, without importing them."""
        groups = [(name, command.get_short_help_str(300)) for name, command in self.commands.items()]
        with formatter.section("Commands"):
            formatter.write_dl([*((name, text) for name, (_, text) in self.table.items()), *groups])


def _with_absolute_paths(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command whose paths mean the same after an FMU has changed the working directory."""

    @wraps(command)
    def called(*given: Any, **named: Any) -> None:
        command(*map(_absolute, given), **{name: _absolute(value) for name, value in named.items()})

    return called


def _absolute(value: Any) -> Any:
    if isinstance(value, list):
        return [_absolute(each) for each in value]
    return value.absolute() if isinstance(value, Path) else value


class _Commands(LateGroup):
    table = COMMANDS


class _RailCommands(LateGroup):
    table = RAIL_COMMANDS


class _WheelCommands(LateGroup):
    table = WHEEL_COMMANDS


app = typer.Typer(cls=_Commands, rich_markup_mode=None, no_args_is_help=True, pretty_exceptions_enable=False)
rails = typer.Typer(
    cls=_RailCommands,
    help="Rails: fit modal data to a track or a measurement, draw receptances, build FMUs.",
    no_args_is_help=True,
)
wheels = typer.Typer(
    cls=_WheelCommands, help="Wheels: build an FMU from modal data, draw sections and modes.", no_args_is_help=True
)
for group in (rails, wheels):
    group.callback()(lambda: None)
app.add_typer(rails, name="rail")
app.add_typer(wheels, name="wheel")


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"curvesqueal {version_of('curvesqueal')}")
        raise typer.Exit


@app.callback()
def curvesqueal(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Railway curve squeal as FMI co-simulation: build the FMUs, run the paper's cases, look inside.

    Running an FMU runs its code, with all that you may do: take FMUs from sources that you trust.
    `run --isolate` protects against crashes and hangs only.
    """


def command_line() -> int:
    """Run the command line and return its exit code.

    A user's mistake, or an FMU's failure, is one sentence and 1; a fault of this program its traceback, a sentence and
    `FAULT`; an end by Ctrl-C 130; options that cannot be read 2; output whose reader has gone `BROKEN`.
    """
    warnings.showwarning = _told_warning
    try:
        app(prog_name="curvesqueal")
    except SystemExit as end:
        if end.code == 1 and broken(sys.stdout):
            return BROKEN
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except (InputError, SimulationError, OSError, UnicodeEncodeError) as error:
        return _failed(f"curvesqueal: {_refusal(error)}", 1) if _refusal(error) else _fault(error)
    except Exception as error:  # whatever else comes up to here is no mistake of the user's
        return _fault(error)
    return 0


def _refusal(error: Exception) -> str:
    """Return the sentence of an error that is not this program's own; nothing for one that is."""
    if isinstance(error, OSError):  # a full disk, a name that is too long, a folder that may not be read
        place = "standard output" if error.filename is None else os.fsdecode(error.filename)
        return f"{place}: {error.strerror or error}"
    if isinstance(error, UnicodeEncodeError):
        odd = re.search("[\ud800-\udfff]", error.object) is not None
        return f"{error.object}: is not UTF-8, as names of files must be" if odd else ""
    return str(error)


def _fault(error: Exception) -> int:
    """Say that this program is at fault, and where."""
    traceback.print_exception(error)
    said = f"{type(error).__name__}: {error}"
    return _failed(f"curvesqueal: a fault of the program itself, not of your input: {said}", FAULT)


_python_warning = warnings.showwarning


def _told_warning(message: Warning | str, category: type[Warning], *where: Any, **more: Any) -> None:
    """Show a warning of ours as a note; others as Python does."""
    if issubclass(category, DamageWarning):
        sys.stderr.write(f"note: {visible(str(message))}\n")
    else:
        _python_warning(message, category, *where, **more)


def _failed(sentence: str, code: int) -> int:
    with suppress(OSError):  # nobody reads it
        sys.stderr.write(f"{visible(sentence)}\n")
    return code


def main() -> None:
    """Run the command line and leave the process at once.

    PythonFMU 0.7.0 frees its state twice when a process ends in the usual way, and an FMU that failed may have damaged
    it anyway: the libraries of FMUs get no chance to do more.
    """
    end_on_interrupt()
    open_closed_streams()
    tell_who_ends_the_process()
    keep_standard_output()
    os._exit(flushed(command_line()))
