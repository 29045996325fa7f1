"""The commands `curvesqueal wheel ...`: modal data in, wheel FMUs and pictures out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...errors import InputError
from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes

if TYPE_CHECKING:
    from fmus.wheel.imported import UffAxes


def build(
    modes: Annotated[str, typer.Argument(metavar="MODES", help="class158, or modal data: .csv, .toml, .uff, .unv.")],
    out: Annotated[Path, typer.Option(help="FMU to write.")] = Path("wheel-own.fmu"),
    axes: Annotated[
        str | None,
        typer.Option(help="UFF only: node and axes of lon, lat, ver, spin, such as 12,+x,-y,-z,none."),
    ] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Build a wheel FMU from modal data, for --replace wheel=FILE.fmu.

    CSV and TOML are in the axes of the contract; UFF needs --axes.
    """
    from fmus.modal.component import structure  # noqa: PLC0415
    from fmus.packaging.build import build_fmu  # noqa: PLC0415
    from fmus.wheel.class158 import class158  # noqa: PLC0415
    from fmus.wheel.imported import read_modes  # noqa: PLC0415

    require_suffix(out, (".fmu",))
    require_free(out, force)
    with user_mistakes():
        read = class158().modes if modes == "class158" else read_modes(Path(modes), _uff_axes(axes))
        out.parent.mkdir(parents=True, exist_ok=True)
        component = structure("wheel", f"Wheel at the contact point: {Path(modes).stem}", read)
        build_fmu(component, out)
    if json:
        screen.print_json(data={"file": str(out), "modes": len(read)})
    else:
        screen.print(f"{out}  ({len(read)} modes)", highlight=False)


def _uff_axes(text: str | None) -> UffAxes | None:
    """Return the axes that an option such as '12,+x,-y,-z,none' names."""
    from fmus.wheel.imported import UffAxes  # noqa: PLC0415 - loads the UFF library

    if text is None:
        return None
    parts = [part.strip() for part in text.split(",")]
    if len(parts) != 5 or not parts[0].isdigit():
        raise InputError(f"--axes {text}: must be NODE,LON,LAT,VER,SPIN, such as 12,+x,-y,-z,none")
    return UffAxes(int(parts[0]), *parts[1:])


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
