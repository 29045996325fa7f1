"""The commands `curvesqueal wheel ...`: modal data in, wheel FMUs and pictures out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...errors import InputError
from ..tools import Force, Json, notice, require_free, require_suffix, screen, user_mistakes
from .measured_options import Axis, signed_axes

if TYPE_CHECKING:
    from fmus.modal.modes import Modes


def build(  # noqa: PLR0913, PLR0917 - one argument per option
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="class158, or modal data: CSV, TOML, UFF, .frd (one for each part)."),
    ],
    node: Annotated[int | None, typer.Option(help="Number of the node at the contact.")] = None,
    axis: Axis = None,
    units: Annotated[str | None, typer.Option(help="Units of length and force (mm,N), where files say none.")] = None,
    damping: Annotated[
        str | None, typer.Option(help="Damping ratios of n = 0, 1, 2 and more (1e-3,1e-2,1e-4), where files have none.")
    ] = None,
    out: Annotated[Path, typer.Option(help="FMU (.fmu) or modal data (.toml) to write.")] = Path("wheel-own.fmu"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Build a wheel FMU from modal data, for --replace wheel=FILE.fmu.

    CSV and TOML are in the axes of the contract; others need --node and --axis 1=lon --axis -2=lat --axis -3=ver.
    """
    from fmus.wheel.class158 import class158  # noqa: PLC0415
    from fmus.wheel.imported import ImportedWheel, ModalChoice, read_modes  # noqa: PLC0415

    require_suffix(out, (".fmu", ".toml"))
    require_free(out, force)
    with user_mistakes():
        if files == ["class158"]:
            read = ImportedWheel(class158().modes)
        else:
            choice = ModalChoice(node, signed_axes(axis), units, _ratios(damping))
            read = read_modes([Path(file) for file in files], choice)
        name = Path(files[0]).stem
        write_wheel(read.modes, out, name, f"modal data of {', '.join(Path(f).name for f in files)}")
    if json:
        screen.print_json(data={"file": str(out), "modes": len(read.modes), "notes": list(read.notes)})
        return
    for text in read.notes:
        notice(text)
    screen.print(f"{out}  ({len(read.modes)} modes)", highlight=False)


def read_wheel(text: str) -> Modes:
    """Return the modes of class158 or of a CSV or TOML file."""
    from fmus.wheel.class158 import class158  # noqa: PLC0415
    from fmus.wheel.imported import read_modes  # noqa: PLC0415

    return class158().modes if text == "class158" else read_modes(Path(text)).modes


def write_wheel(modes: Modes, path: Path, title: str, source: str) -> None:
    """Write a wheel as an FMU or as modal data, by the suffix."""
    from fmus.modal.component import structure  # noqa: PLC0415
    from fmus.modal.data import ModalData, write_modal_data  # noqa: PLC0415
    from fmus.packaging.build import build_fmu  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".toml":
        write_modal_data(path, ModalData(title, source, modes))
    else:
        build_fmu(structure("wheel", f"Wheel at the contact point: {title}", modes), path)


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
