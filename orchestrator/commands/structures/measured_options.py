"""The options that say what measured files and files of mode shapes hold: one language for rail and wheel."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...errors import InputError
from ..options import with_options
from ..tools import screen, user_mistakes

if TYPE_CHECKING:
    from fmus.measured.choice import Choice
    from fmus.wheel.imported import ModalChoice

Files = Annotated[list[Path], typer.Argument(help="Universal files (UFF), CSV or NumPy archives.")]
Axis = list[str] | None

_SHARED: dict[str, Any] = {
    "node": Annotated[int | None, typer.Option(help="Node of the contact, or driving point, where there are several.")],
    "axis": Annotated[
        Axis, typer.Option(help="Direction of an axis of the file: 3=lat, or -1=lon for its opposite. Repeatable.")
    ],
    "units": Annotated[
        str | None,
        typer.Option(help="Units of length and force (mm,N), or of functions (mm/s/N), where the file says none."),
    ],
}

FUNCTIONS: dict[str, Any] = {
    "quantity": Annotated[
        str | None, typer.Option(help="receptance, mobility or accelerance, where the file does not say it.")
    ],
    **_SHARED,
    "start": Annotated[float | None, typer.Option("--from", help="Lowest frequency that is used [Hz].")],
    "stop": Annotated[float | None, typer.Option("--to", help="Highest frequency that is used [Hz].")],
}
"""Options on measured functions by name of the argument; the default of each is None."""

SHAPES: dict[str, Any] = {
    **_SHARED,
    "damping": Annotated[
        str | None, typer.Option(help="Damping ratios of n = 0, 1, 2 and more (1e-3,1e-2,1e-4), where files have none.")
    ],
}
"""Options on mode shapes."""


def reads_functions(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that takes `FUNCTIONS` where its argument `choice` stands, and is given a `Choice`."""
    return with_options(command, "choice", FUNCTIONS, _functions)


def reads_shapes(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command that takes `SHAPES` where its argument `choice` stands, and is given a `ModalChoice`."""
    return with_options(command, "choice", SHAPES, _shapes)


def _functions(
    *, quantity: str | None, node: int | None, axis: Axis, units: str | None, start: float | None, stop: float | None
) -> Choice:
    """Return what the options say about measured functions."""
    from fmus.measured.choice import Choice, read_axes  # noqa: PLC0415

    with user_mistakes():
        return Choice(quantity, units, node, read_axes(axis or []), start, stop)


def _shapes(*, node: int | None, axis: Axis, units: str | None, damping: str | None) -> ModalChoice:
    """Return what the options say about mode shapes."""
    from fmus.measured.choice import read_axes  # noqa: PLC0415
    from fmus.wheel.imported import ModalChoice  # noqa: PLC0415

    with user_mistakes():
        return ModalChoice(node, read_axes(axis or []), units, _ratios(damping))


def _ratios(text: str | None) -> tuple[float, ...]:
    """Return the damping ratios of a text such as '1e-3,1e-2,1e-4'."""
    if text is None:
        return ()
    try:
        ratios = tuple(float(part) for part in text.split(","))
    except ValueError:
        ratios = (-1.0,)
    if not all(0 <= ratio < 1 for ratio in ratios):
        raise InputError(f"--damping {text}: must be numbers from 0 to 1, such as 1e-3,1e-2,1e-4")
    return ratios


def print_used(used: Iterable[Mapping[str, Any]]) -> None:
    """Print what was taken from the files, a line per function."""
    for row in used:
        text = (
            f"used: {row['direction']} as {row['quantity']}, {row['point']}, {row['set']}; {row['units']}; "
            f"factor to SI {row['factor']:g}, sign {row['sign']:+g}; {row['from_hz']:g} to {row['to_hz']:g} Hz"
            + (f"; {row['origin']}" if "origin" in row else "")
        )
        screen.print(text, highlight=False, markup=False, soft_wrap=True)
