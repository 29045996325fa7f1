"""What the commands `rail ...` share: tracks by name, rails into files, tables of errors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from ...errors import InputError
from ..tools import screen

if TYPE_CHECKING:
    from fmus.modal.data import ModalData

Track = Annotated[
    str, typer.Argument(metavar="TRACK", help="A track file, or default, soft-pads, rail-dampers, bs113a, slab.")
]

Errors = dict[str, dict[str, float]]


def track_file(track: str) -> Path:
    """Return the file of a track: a shipped one by name, or a path."""
    from fmus.rail.track_data import TRACKS  # noqa: PLC0415

    shipped = {path.stem: path for path in sorted(TRACKS.glob("*.toml"))}
    path = shipped.get(track, Path(track))
    if not path.is_file():
        raise InputError(f"{track}: neither a track file nor one of {', '.join(shipped)}")
    return path


def write_rail(data: ModalData, path: Path, name: str) -> None:
    """Write a modal rail as modal data or as an FMU of the given model name, by the suffix."""
    from fmus.modal.component import structure  # noqa: PLC0415
    from fmus.modal.data import write_modal_data  # noqa: PLC0415
    from fmus.packaging.build import build_fmu  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".toml":
        write_modal_data(path, data)
    else:
        component = structure(name, f"Rail at the contact point: {data.title}", data.modes)
        build_fmu(component, path)


def print_errors(errors: dict[str, Errors], title: str) -> None:
    """Print a table of fit errors, a row per rail and direction."""
    table = Table("rail", "direction", title=title, title_justify="left")
    for heading in ("dB", "degrees", "modes"):
        table.add_column(heading, justify="right")
    for name, of_direction in errors.items():
        for direction, error in of_direction.items():
            numbers = (f"{error['rms_db']:.2f}", f"{error['rms_degrees']:.1f}", f"{error['modes']:.0f}")
            table.add_row(name, direction, *numbers)
    screen.print(table)
