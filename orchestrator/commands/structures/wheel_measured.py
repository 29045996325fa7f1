"""The command `wheel measured`: point and cross functions at the contact in, a wheel out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from fmus.measured.choice import Choice

from ..tools import Force, Json, messages, notice, require_free, require_suffix, screen, user_mistakes
from .measured_options import Files, print_used, reads_functions
from .wheel_files import read_wheel, write_wheel

if TYPE_CHECKING:
    from fmus.wheel.measured import MeasuredWheel


@reads_functions
def measured(
    files: Files,
    choice: Choice,
    like: Annotated[
        str | None,
        typer.Option(help="Wheel whose labels, and areas if it has them, are taken over: class158, CSV or TOML."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="FILE.fmu or modal data FILE.toml; default: none.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit modes of both families to measured point and cross functions; a direction that was not measured is rigid.

    Takes a minute or two for a band of 6 kHz.
    """
    from fmus.measured.selection import files_and_origins  # noqa: PLC0415
    from fmus.wheel import areas  # noqa: PLC0415
    from fmus.wheel.measured import wheel_from_files  # noqa: PLC0415

    with user_mistakes():
        if out is not None:
            require_suffix(out, (".toml", ".fmu"))
            require_free(out, force)
        with messages.status("reading") as status:
            fit = wheel_from_files(files, choice, lambda words: status.update(f"fitting: {words}"))
        modes, own, notes = fit.modes, None, list(fit.notes)
        if like is not None:
            known = read_wheel(like)
            modes = areas.like(fit.modes, known.modes)
            if known.areas is not None:
                own, count = areas.taken_over(modes, known.modes, known.areas)
                notes.append(f"areas of {count} modes are those of {like}, of the other {len(modes) - count} estimates")
        if out is not None:
            names = files_and_origins(files, fit.used)
            source = f"modes fitted to the functions in {names} (fmus.wheel.measured)"
            write_wheel(modes, out, "measured wheel", source, own)
    if json:
        data = {"modes": len(modes), "labels": list(modes.labels), "quality": fit.quality, "notes": notes}
        screen.print_json(data={**data, "used": [dict(row) for row in fit.used]})
        return
    screen.print(_table(fit))
    print_used(fit.used)
    for text in notes:
        notice(text)
    if out is not None:
        screen.print(str(out), highlight=False, markup=False, soft_wrap=True)


def _table(fit: MeasuredWheel) -> Table:
    """Return a table of the quality of a fit, a row per function."""
    title = f"measured wheel, {len(fit.modes)} modes: receptance against the data, medians over the lines"
    table = Table("function", title=title, title_justify="left")
    for heading in ("dB", "degrees", "noise"):
        table.add_column(heading, justify="right")
    for name, q in fit.quality.items():
        table.add_row(name, f"{q['median_db']:.2f}", f"{q['median_degrees']:.2f}", f"{q['noise']:.1%}")
    return table
