"""The command `wheel figures`: pictures of the shipped wheels."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..tools import Json, screen


def figures(
    out: Annotated[Path, typer.Option(help="Folder for the pictures; those there are replaced.")] = Path("results"),
    json: Json = False,
) -> None:
    """Draw cross-sections and mode shapes of the shipped wheels (Fig. 6)."""
    from ...figures.wheel import write_figures  # noqa: PLC0415

    out.mkdir(parents=True, exist_ok=True)
    written = [str(path) for path in write_figures(out)]
    if json:
        screen.print_json(data={"files": written})
    else:
        for path in written:
            screen.print(path, highlight=False)
