"""The command `rail figures`: a track in, its receptances and those of modal rails as pictures out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..tools import Json, screen, user_mistakes
from .rail_files import Track, print_errors, track_file


def figures(
    track: Track = "default",
    out: Annotated[Path, typer.Option(help="Folder; earlier figures in it are replaced.")] = Path("results/rail"),
    json: Json = False,
) -> None:
    """Draw Figs 3 and 4 of the paper in all four directions: analytical track against modal rails."""
    from fmus.modal.data import read_modal_data  # noqa: PLC0415
    from fmus.rail.component import DATA  # noqa: PLC0415
    from fmus.rail.track_data import read_track  # noqa: PLC0415

    from ...figures.receptance import modal_rails, receptance_errors, write_receptance  # noqa: PLC0415

    with user_mistakes():
        the_track = read_track(track_file(track))
        shipped = read_modal_data(DATA / "rail.toml").modes if track == "default" else None
        rails = modal_rails(the_track, shipped)
        errors = receptance_errors(the_track, rails)
        files = write_receptance(the_track, rails, out)
    if json:
        screen.print_json(data={"errors": errors, "files": [str(path) for path in files]})
        return
    print_errors(errors, f"{the_track.title}: receptance against the analytical track, 30 Hz to 5 kHz, rms")
    for path in files:
        screen.print(str(path), highlight=False, markup=False, soft_wrap=True)
