"""The command `rail build`: a modal data file in, a rail FMU out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..tools import Force, require_free, require_suffix, screen, user_mistakes
from .rail_files import write_rail


def build(
    modes: Annotated[Path, typer.Argument(help="Modal data file.")],
    out: Annotated[Path, typer.Option(help="FMU to write.")],
    force: Force = False,
) -> None:
    """Build a rail FMU from a modal data file."""
    from fmus.modal.data import read_modal_data  # noqa: PLC0415

    with user_mistakes():
        require_suffix(out, (".fmu",))
        require_free(out, force)
        write_rail(read_modal_data(modes), out, "rail")
    screen.print(str(out), highlight=False, markup=False, soft_wrap=True)
