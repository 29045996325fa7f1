"""The command `wheel measured`: point and cross functions at the contact in, a wheel out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from ..tools import Force, Json, messages, notice, require_free, require_suffix, screen, user_mistakes
from .measured_options import Axis, Files, From, Node, Quantity, To, Units, choice, print_used
from .wheel import read_wheel, write_wheel

if TYPE_CHECKING:
    from fmus.wheel.measured import MeasuredWheel


def measured(  # noqa: PLR0913, PLR0917 - one argument per option
    files: Files,
    quantity: Quantity = None,
    units: Units = None,
    node: Node = None,
    axis: Axis = None,
    start: From = None,
    stop: To = None,
    labels: Annotated[
        str | None,
        typer.Option("--like", help="Wheel whose labels are taken over: class158, CSV or TOML."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="FILE.fmu or modal data FILE.toml; default: none.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit modes of both families to measured point and cross functions; a direction that was not measured is rigid.

    Takes a minute or two for a band of 6 kHz.
    """
    from fmus.wheel.areas import like  # noqa: PLC0415
    from fmus.wheel.measured import wheel_from_files  # noqa: PLC0415

    with user_mistakes():
        if out is not None:
            require_suffix(out, (".toml", ".fmu"))
            require_free(out, force)
        chosen = choice(quantity, units, node, axis, (start, stop))
        with messages.status("reading") as status:
            fit = wheel_from_files(files, chosen, lambda words: status.update(f"fitting: {words}"))
        modes = fit.modes if labels is None else like(fit.modes, read_wheel(labels))
        if out is not None:
            names = ", ".join(file.name for file in files)
            source = f"modes fitted to the functions in {names} (fmus.wheel.measured)"
            write_wheel(modes, out, "measured wheel", source)
    if json:
        data = {"modes": len(modes), "labels": list(modes.labels), "quality": fit.quality, "notes": list(fit.notes)}
        screen.print_json(data={**data, "used": [dict(row) for row in fit.used]})
        return
    screen.print(_table(fit))
    print_used(fit.used)
    for text in fit.notes:
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
