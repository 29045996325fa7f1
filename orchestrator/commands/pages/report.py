"""The command `curvesqueal report`: results in, one HTML page out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..tools import Json, screen


def report(
    results: Annotated[list[Path], typer.Argument(metavar="RESULTS...", help="Results files of runs (.nc).")],
    out: Annotated[Path, typer.Option(help="Folder for report.html.")] = Path("results"),
    json: Json = False,
) -> None:
    """Write one self-contained HTML page about runs: words, the paper's numbers next to ours, figures, sound."""
    from ...report.page import write_report  # noqa: PLC0415 - loads scipy, xarray and the stability analysis

    page = write_report(results, out)
    if json:
        screen.print_json(data={"file": str(page), "bytes": page.stat().st_size, "runs": len(results)})
    else:
        screen.print(f"{page}  ({page.stat().st_size / 1e6:.2f} MB)", highlight=False, soft_wrap=True)
