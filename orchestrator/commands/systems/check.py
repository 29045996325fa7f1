"""The command `check`: does an FMU fulfil the contract of a rail."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.table import Table

from fmus.interface import DIRECTIONS

from ...errors import InputError
from ...figures.rail_check import FREQUENCIES
from ...probing.rail_check import RailReport
from ..tools import Json, screen, user_mistakes


def check(
    file: Annotated[Path, typer.Argument(metavar="FILE.fmu", help="The FMU to test.")],
    kind: Annotated[str, typer.Option("--as", help="The contract to test against: rail.")] = "rail",
    mapping: Annotated[
        list[str] | None,
        typer.Option(help="v_lat=mySpeedY, v_lat=-0.001*mySpeedY, or an .ssd file that connects it. Repeatable."),
    ] = None,
    step: Annotated[float, typer.Option(help="Communication step of the tests, in seconds.")] = 5e-6,
    out: Annotated[Path, typer.Option(help="Folder for the mobility figure, FILE-mobility.png.")] = Path("results"),
    json: Json = False,
) -> None:
    """Test an FMU against the contract of a rail, by what it declares and by running it, which runs its code.

    Prints pass, fail or not offered for each demand and draws the mobility; fails if one fails.
    """
    from ...figures.rail_check import write_mobility  # noqa: PLC0415
    from ...probing.rail_check import check_rail  # noqa: PLC0415

    if kind != "rail":
        raise InputError(f"--as {kind}: must be rail")
    with user_mistakes():
        report = check_rail(file, mapping or [], step)
        picture = write_mobility(report, out)
    if json:
        screen.print_json(data={**as_data(report), "figure": None if picture is None else str(picture)})
    else:
        screen.print(table(report))
        if picture is not None:
            screen.print(str(picture), highlight=False, markup=False, soft_wrap=True)
    if report.failed:
        raise InputError(f"{file}: is no rail: {'; '.join(f'{c.name}: {c.detail}' for c in report.failed)}")


COLOUR = {"pass": "green", "fail": "bold red"}


def table(report: RailReport) -> Table:
    """Return the table of the checks."""
    rows = Table(
        "check", "result", "what was found", title=f"{report.file} as a rail, {report.step:g} s", title_justify="left"
    )
    for check in report.checks:
        rows.add_row(check.name, check.status, check.detail, style=COLOUR.get(check.status, ""))
    return rows


def as_data(report: RailReport) -> dict[str, Any]:
    """Return the report as one JSON object; the mobility at 200 logarithmically spaced frequencies."""
    data: dict[str, Any] = {
        "file": str(report.file),
        "as": "rail",
        "step_s": report.step,
        "passed": not report.failed,
        "checks": [{"name": c.name, "status": c.status, "detail": c.detail} for c in report.checks],
        "mobility": None,
    }
    if report.mobility is not None:
        f, Y = report.mobility.frequency_hz, report.mobility.values
        wanted = np.unique(np.searchsorted(f, np.geomspace(f[0], f[-1], FREQUENCIES)))
        data["mobility"] = {"frequency_hz": f[wanted].tolist()}
        for j, direction in enumerate(DIRECTIONS):
            own = Y[wanted, j, j]
            data["mobility"][direction] = {"real": own.real.tolist(), "imag": own.imag.tolist()}
    return data
