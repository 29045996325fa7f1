"""The command `wheel build`: modal data in, a wheel FMU out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fmus.wheel.imported import ModalChoice, read_modes

from ..tools import Force, Json, notice, require_free, require_suffix, screen, user_mistakes
from .measured_options import reads_shapes
from .wheel_files import read_wheel, write_wheel


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
