"""The command `rail measured`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from fmus.measured.choice import Choice

from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes
from .measured_options import Files, print_used, reads_functions
from .rail_files import write_rail

if TYPE_CHECKING:
    from fmus.rail.measured import RailFit


@reads_functions
def measured(
    files: Files,
    choice: Choice,
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
        data, fit = rail_from_files(files, choice, modes)
        if out is not None:
            write_rail(data, out, "rail_measured")
    if json:
        screen.print_json(data={d: {**fit.quality[d], "used": dict(fit.used[d])} for d in fit.quality})
        return
    screen.print(_table(fit, data.title))
    print_used(fit.used.values())
    if out is not None:
        screen.print(str(out), highlight=False, markup=False, soft_wrap=True)


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
