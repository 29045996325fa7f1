"""The command `friction`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from ...system.cases import built_ssp
from ..tools import Json, screen


def friction(
    out: Annotated[Path, typer.Option(help="Picture to write.")] = Path("results/friction.png"),
    contact: Annotated[Path | None, typer.Option(help="Contact FMU; default: the project's own.")] = None,
    json: Json = False,
) -> None:
    """Draw the two friction curves of the paper, its figure 5, from the contact FMU."""
    from ...archive import unpack  # noqa: PLC0415
    from ...figures.friction import draw_friction  # noqa: PLC0415
    from ...probing.friction_curve import friction_curve  # noqa: PLC0415

    fmu = contact or unpack(built_ssp(), "SSP") / "resources" / "contact.fmu"
    creepage = np.concatenate([np.linspace(0.0, 0.006, 61), np.linspace(0.0065, 0.05, 88)])
    curves = {
        "constant friction": friction_curve(fmu, creepage, {"falling_ratio": 0.0}),
        "falling friction": friction_curve(fmu, creepage),
    }
    out.parent.mkdir(parents=True, exist_ok=True)
    draw_friction(creepage, curves, out)
    if json:
        screen.print_json(data={"creepage": creepage.tolist(), **{k: v.tolist() for k, v in curves.items()}})
    else:
        screen.print(str(out), highlight=False)
