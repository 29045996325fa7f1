"""The command `build`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fmus.errors import DataError

from ...errors import InputError, SimulationError
from ..tools import Json, say, screen


def build(
    out: Annotated[Path, typer.Option(help="Folder for the FMUs and the SSP.")] = Path("build"),
    flavour: Annotated[
        str | None,
        typer.Option(help="native, python or all (one folder each); default: native if a C compiler is there."),
    ] = None,
    fmi: Annotated[int, typer.Option(help="Version of FMI: 2 or 3.")] = 2,
    platforms: Annotated[
        str, typer.Option(help="Native FMUs: x86_64-linux,aarch64-linux,x86_64-windows,... Default: this one.")
    ] = "",
    scalars: Annotated[bool, typer.Option("--scalars", help="FMI 3 without arrays, for hosts that know none.")] = False,
    json: Json = False,
) -> None:
    """Build the FMUs (wheel, rails, contact, system) and the SSP that couples them."""
    from fmus.packaging import build as building  # noqa: PLC0415 - compiles kernels
    from fmus.packaging.target import targets  # noqa: PLC0415

    files: list[Path] = []

    def report(path: Path) -> None:
        files.append(path)
        if not json:
            screen.print(f"{path}  ({path.stat().st_size / 1000:.0f} kB)", highlight=False)

    try:
        chosen = targets(flavour, fmi, [name for name in platforms.split(",") if name], scalars)
        for target in chosen:
            say(str(target))
            building.build(out / target.flavour if len(chosen) > 1 else out, target, report)
    except DataError as error:
        raise InputError(str(error)) from None
    except RuntimeError as error:
        raise SimulationError(f"build: {error}") from None
    except OSError as error:
        raise InputError(f"{out}: cannot write there: {error.strerror or error}") from None
    if json:
        screen.print_json(data={"files": [str(path) for path in files]})
