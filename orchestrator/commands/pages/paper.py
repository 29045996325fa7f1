"""The command `paper`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ...paper.page import PARTS, PICTURES, Item, write_page
from ..tools import Json, screen


def paper(
    out: Annotated[Path, typer.Option(help="Folder of paper.md; pictures go to its folder paper.")] = Path("docs"),
    only: Annotated[str | None, typer.Option(help="Write this part alone: stability or time.")] = None,
    results: Annotated[Path, typer.Option(help="Folder with the results of the four cases.")] = Path("results"),
    json: Json = False,
) -> None:
    """Write the page that sets every table, figure and claim of the paper next to ours.

    The part about the time domain needs the results of the four cases (`curvesqueal run case1` to `case4`); with
    those of `inferred1` to `inferred4` it has a column for them.
    """
    figures = out / PICTURES
    figures.mkdir(parents=True, exist_ok=True)
    makers = _makers(results, only)
    parts = {name: make(figures) for name, make in makers.items()}
    page = write_page(parts, out)
    if json:
        pictures = [str(figure) for items in parts.values() for item in items for figure in item.figures]
        screen.print_json(data={"file": str(page), "parts": list(parts), "figures": pictures})
        return
    screen.print(str(page), highlight=False, markup=False, soft_wrap=True)


def _makers(results: Path, only: str | None) -> dict[str, Callable[[Path], Sequence[Item]]]:
    """Return what makes each part that is asked for.

    Raises
    ------
    InputError
        For an unknown part, or the time domain without its results.
    """
    from ...paper import frequency_domain, time_domain  # noqa: PLC0415 - load matplotlib and finite elements

    if only is not None and only not in PARTS:
        raise InputError(f"--only {only}: must be one of {', '.join(PARTS)}")
    makers: dict[str, Callable[[Path], Sequence[Item]]] = {"stability": frequency_domain.items}
    if results.is_dir():
        makers["time"] = lambda figures: time_domain.items(results, figures)
    elif only == "time":
        raise InputError(f"--results {results}: has no results of the four cases; run case1 to case4 first")
    return makers if only is None else {only: makers[only]}
