"""The command `friction`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from fmus.contact.friction.named import NAMED
from fmus.contact.friction_parameters import TABLE_OF_VELOCITY

from ...fmi.instance import Value
from ...system.cases import built_ssp
from ...system.friction import friction_values
from ..tools import Json, screen

PAPER = {"constant friction": "constant", "falling friction": "paper"}
"""The curves of the paper's figure 5, and their laws."""


def friction(
    laws: Annotated[
        list[str] | None,
        typer.Argument(metavar="[LAW|FILE.csv]...", help=f"Friction laws: {', '.join(NAMED)}, or files; the paper's."),
    ] = None,
    out: Annotated[Path, typer.Option(help="Picture to write.")] = Path("results/friction.png"),
    contact: Annotated[Path | None, typer.Option(help="Contact FMU; default: the project's own.")] = None,
    json: Json = False,
) -> None:
    """Draw friction curves from the contact FMU: those of the paper, its figure 5, or others.

    A file has a header with `creepage` or `velocity [m/s]`, and `friction`.
    """
    from ...archive import unpack  # noqa: PLC0415
    from ...figures.friction import draw_friction  # noqa: PLC0415
    from ...probing.friction_curve import friction_curve  # noqa: PLC0415

    named = {Path(text).name: friction_values(text) for text in laws} if laws else _of(PAPER)
    fmu = contact or unpack(built_ssp(), "SSP") / "resources" / "contact.fmu"
    creepage = np.concatenate([np.linspace(0.0, 0.006, 61), np.linspace(0.0065, 0.05, 88)])
    curves = {name: friction_curve(fmu, creepage, values) for name, values in named.items()}
    out.parent.mkdir(parents=True, exist_ok=True)
    draw_friction(creepage, curves, out, {name: points for name, v in named.items() if (points := points_of(v))})
    if json:
        screen.print_json(data={"creepage": creepage.tolist(), **{k: v.tolist() for k, v in curves.items()}})
        return
    for text in laws or ():
        if text in NAMED:
            screen.print(f"{text}: {NAMED[text].source}", highlight=False, soft_wrap=True)
    screen.print(str(out), highlight=False)


def _of(laws: dict[str, str]) -> dict[str, dict[str, Value]]:
    return {label: friction_values(law) for label, law in laws.items()}


def points_of(values: dict[str, Any], velocity: float = 10.0) -> list[tuple[float, float]]:
    """Return the points of a friction table as creepage and friction, rolling velocity in m/s."""
    count = int(values.get("friction_points", 0))
    scale = velocity if values.get("friction_law") == TABLE_OF_VELOCITY else 1.0
    names = [(f"friction_abscissa_{i:03d}", f"friction_ordinate_{i:03d}") for i in range(1, count + 1)]
    return [(float(values[x]) / scale, float(values[y])) for x, y in names]
