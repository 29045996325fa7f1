"""The command `rail measured`, and the options that say what a measured file holds: the same for rail and wheel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.table import Table

from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes
from .rail import write_rail

if TYPE_CHECKING:
    from fmus.measured.selection import Choice
    from fmus.rail.measured import RailFit

Files = Annotated[list[Path], typer.Argument(help="Universal files (UFF), CSV or NumPy archives.")]
Quantity = Annotated[
    str | None, typer.Option(help="receptance, mobility or accelerance, where the file does not say it.")
]
Units = Annotated[
    str | None, typer.Option(help="Unit (mm/s/N), or units of length and force (mm,N), where the file does not say it.")
]
Node = Annotated[int | None, typer.Option(help="Driving point, where a file has several.")]
Axis = Annotated[
    list[str] | None, typer.Option(help="Direction code of a universal file: 3=lat, or -1=lon. Repeatable.")
]
From = Annotated[float | None, typer.Option("--from", help="Lowest frequency that is used [Hz].")]
To = Annotated[float | None, typer.Option("--to", help="Highest frequency that is used [Hz].")]


def measured(  # noqa: PLR0913, PLR0917 - one argument per option
    files: Files,
    quantity: Quantity = None,
    units: Units = None,
    node: Node = None,
    axis: Axis = None,
    start: From = None,
    stop: To = None,
    modes: Annotated[int, typer.Option(help="Most modes in each direction.")] = 8,
    out: Annotated[Path | None, typer.Option(help="FILE.fmu or modal data FILE.toml; default: none.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit a passive modal rail to measured point functions; a direction that was not measured is rigid.

    Without --from and --to the band is the widest one with good data. What was used is printed.
    """
    from fmus.rail.measured import rail_from_files  # noqa: PLC0415

    with user_mistakes():
        if out is not None:
            require_suffix(out, (".toml", ".fmu"))
            require_free(out, force)
        data, fit = rail_from_files(files, choice(quantity, units, node, axis, (start, stop)), modes)
        if out is not None:
            write_rail(data, out, "rail_measured")
    if json:
        screen.print_json(data={d: {**fit.quality[d], "used": dict(fit.used[d])} for d in fit.quality})
        return
    screen.print(_table(fit, data.title))
    print_used(fit.used.values())
    if out is not None:
        screen.print(str(out), highlight=False, markup=False, soft_wrap=True)


def choice(
    quantity: str | None,
    units: str | None,
    node: int | None,
    axis: list[str] | None,
    band: tuple[float | None, float | None],
) -> Choice:
    """Return what the options say about measured files."""
    from fmus.measured.selection import Choice, read_axes  # noqa: PLC0415

    return Choice(quantity, units, node, read_axes(axis or []), *band)


def print_used(used: Iterable[Mapping[str, Any]]) -> None:
    """Print what was taken from the files, a line per function."""
    for row in used:
        text = (
            f"used: {row['direction']} as {row['quantity']}, {row['point']}, {row['set']}; {row['units']}; "
            f"factor to SI {row['factor']:g}, sign {row['sign']:+g}; {row['from_hz']:g} to {row['to_hz']:g} Hz"
        )
        screen.print(text, highlight=False, markup=False, soft_wrap=True)


def _table(fit: RailFit, title: str) -> Table:
    """Return a table of the quality of a fit, a row per direction."""
    table = Table("direction", title=f"{title}: receptance against the data, rms", title_justify="left")
    for heading in ("dB", "degrees", "modes", "band \\[Hz]", "of \\[Hz]", "noise"):
        table.add_column(heading, justify="right")
    for direction, q in fit.quality.items():
        table.add_row(
            direction, f"{q['rms_db']:.2f}", f"{q['rms_degrees']:.1f}", f"{q['modes']:.0f}",
            f"{q['from_hz']:g} to {q['to_hz']:g}", f"{q['data_from_hz']:g} to {q['data_to_hz']:g}", f"{q['noise']:.1%}",
        )  # fmt: skip
    return table
