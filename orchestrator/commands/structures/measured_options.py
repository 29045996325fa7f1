"""The options that say what a measured file holds: the same for rail and wheel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..tools import screen

if TYPE_CHECKING:
    from fmus.measured.choice import Choice

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


def signed_axes(axis: list[str] | None) -> dict[int, str]:
    """Return the directions by signed code that options such as --axis -1=lon give."""
    from fmus.measured.choice import read_axes  # noqa: PLC0415

    return read_axes(axis or [])


def choice(
    quantity: str | None,
    units: str | None,
    node: int | None,
    axis: list[str] | None,
    band: tuple[float | None, float | None],
) -> Choice:
    """Return what the options say about measured files."""
    from fmus.measured.choice import Choice  # noqa: PLC0415

    return Choice(quantity, units, node, signed_axes(axis), *band)


def print_used(used: Iterable[Mapping[str, Any]]) -> None:
    """Print what was taken from the files, a line per function."""
    for row in used:
        text = (
            f"used: {row['direction']} as {row['quantity']}, {row['point']}, {row['set']}; {row['units']}; "
            f"factor to SI {row['factor']:g}, sign {row['sign']:+g}; {row['from_hz']:g} to {row['to_hz']:g} Hz"
        )
        screen.print(text, highlight=False, markup=False, soft_wrap=True)
