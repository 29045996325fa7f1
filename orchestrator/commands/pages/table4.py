"""The command `table4`."""

from __future__ import annotations

from typing import Annotated

import typer
from rich.table import Table

from ...paper.table4 import Cell, find_table4
from ..analysis.stability import RailOption
from ..options import WheelOption
from ..tools import Json, screen

CasesOption = Annotated[
    str, typer.Option("--cases", help="printed: case1 to case4; inferred: inferred1 to inferred4.", metavar="FAMILY")
]


def table4(
    json: Json = False, rail: RailOption = None, wheel: WheelOption = None, cases: CasesOption = "printed"
) -> None:
    """Print Table 4 of the paper next to ours: frequency and loop gain, cell by cell."""
    result = find_table4(rail, wheel, cases)
    if json:
        screen.print_json(data=result.as_json())
        return
    table = Table(
        title=f"Table 4: {result.right} of {len(result.cells)} cells right, rms ln(gain) error {result.log_error:.3f}",
        title_justify="left",
    )
    for heading in ("case", "mode", "paper [Hz]", "ours [Hz]", "paper gain", "our gain", ""):
        table.add_column(heading, justify="right")
    for cell in result.cells:
        table.add_row(*_row(cell))
    screen.print(table)
    for case, crossing in result.extra:
        screen.print(f"case {case}: further crossing at {crossing.frequency_hz:.1f} Hz with gain {crossing.gain:.3f}")


def _row(cell: Cell) -> tuple[str, ...]:
    """Return a cell as a row of text."""
    numbers = (
        ("-" if value is None else f"{value:.{digits}f}")
        for value, digits in (
            (cell.paper_frequency_hz, 1), (cell.frequency_hz, 1), (cell.paper_gain, 3), (cell.gain, 3),
        )
    )  # fmt: skip
    return (str(cell.case), cell.mode, *numbers, "" if cell.agrees else "!")
