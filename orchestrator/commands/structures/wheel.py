"""The commands `curvesqueal wheel ...`: modal data in, wheel FMUs and pictures out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer
from numpy.typing import NDArray

from fmus.wheel.imported import ImportedWheel, ModalChoice, read_modes

from ..tools import Force, Json, notice, require_free, require_suffix, screen, user_mistakes
from .measured_options import reads_shapes

if TYPE_CHECKING:
    from fmus.modal.modes import Modes

Real = NDArray[np.float64]


@reads_shapes
def build(
    files: Annotated[
        list[str],
        typer.Argument(metavar="FILE...", help="class158, or modal data: CSV, TOML, UFF, .frd, .op2, .f06."),
    ],
    choice: ModalChoice,
    out: Annotated[Path, typer.Option(help="FMU (.fmu) or modal data (.toml) to write.")] = Path("wheel-own.fmu"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Build a wheel FMU from modal data, for --replace wheel=FILE.fmu.

    CSV and TOML are in the axes of the contract; others need --node and --axis 1=lon --axis -2=lat --axis -3=ver.
    """
    require_suffix(out, (".fmu", ".toml"))
    require_free(out, force)
    with user_mistakes():
        read = read_wheel("class158") if files == ["class158"] else read_modes([Path(file) for file in files], choice)
        source = "; ".join(["modal data of " + ", ".join(Path(f).name for f in files), *filter(None, [read.origin])])
        write_wheel(read.modes, out, Path(files[0]).stem, source, read.areas)
    if json:
        screen.print_json(data={"file": str(out), "modes": len(read.modes), "notes": list(read.notes)})
        return
    for text in read.notes:
        notice(text)
    screen.print(f"{out}  ({len(read.modes)} modes)", highlight=False)


def read_wheel(text: str) -> ImportedWheel:
    """Return class158, or what a CSV or TOML file says of a wheel."""
    from fmus.wheel.class158 import class158  # noqa: PLC0415

    if text != "class158":
        return read_modes(Path(text))
    known = class158()
    return ImportedWheel(known.modes, areas=np.column_stack([known.area_axial, known.area_radial]))


def write_wheel(modes: Modes, path: Path, title: str, source: str, areas: Real | None = None) -> None:
    """Write a wheel as an FMU or, with areas if they are known, as modal data, by the suffix."""
    from fmus.modal.component import structure  # noqa: PLC0415
    from fmus.modal.data import ModalData, write_modal_data  # noqa: PLC0415
    from fmus.packaging.build import build_fmu  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".toml":
        write_modal_data(path, ModalData(title, source, modes, areas))
    else:
        build_fmu(structure("wheel", f"Wheel at the contact point: {title}", modes), path)


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
