"""The command `curvesqueal picture`: results in, a picture of histories and spectra out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...errors import SimulationError
from ..tools import Force, require_free, require_suffix, screen


def picture(
    results: Annotated[Path, typer.Argument(help="Results of a run (.nc).")],
    out: Annotated[Path | None, typer.Option(help="Picture to write, .png, .pdf or .svg; default: beside it.")] = None,
    force: Force = False,
) -> None:
    """Draw velocity histories, their last periods and spectra of wheel and rail, as in figures 8 to 11 of the paper."""
    from ...figures.run import draw_run  # noqa: PLC0415
    from ...results.file import open_results  # noqa: PLC0415

    path = results.with_suffix(".png") if out is None else out
    require_suffix(path, (".png", ".pdf", ".svg"))
    with open_results(results) as data:
        require_free(path, force)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            draw_run(data, path)
        except OSError as failure:
            raise SimulationError(f"{path}: cannot write the picture: {failure.strerror or failure}") from None
    screen.print(str(path), highlight=False, markup=False, soft_wrap=True)
