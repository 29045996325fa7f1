"""The command `rail fit`: a track in, its modal rail out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes
from .rail_files import Track, print_errors, track_file


def fit(
    track: Track,
    method: Annotated[str, typer.Option(help="accurate, or paper: the paper's cut-on method.")] = "accurate",
    out: Annotated[Path | None, typer.Option(help="Modal data file; default rail-TRACK-METHOD.toml here.")] = None,
    modes: Annotated[int | None, typer.Option(help="Most modes in each direction, accurate only; default 8.")] = None,
    force: Force = False,
    json: Json = False,
) -> None:
    """Fit a modal rail to the analytical track and write its modal data file.

    The errors are root mean squares over 200 frequencies, 30 Hz to 5 kHz. Takes up to a minute.
    """
    import numpy as np  # noqa: PLC0415

    from fmus.modal.data import write_modal_data  # noqa: PLC0415
    from fmus.rail.fit import error_frequencies, fit_errors  # noqa: PLC0415
    from fmus.rail.shipped import modal_rail  # noqa: PLC0415
    from fmus.rail.track import track_receptance  # noqa: PLC0415
    from fmus.rail.track_data import read_track  # noqa: PLC0415

    with user_mistakes():
        path = track_file(track)
        target = out or Path(f"rail-{path.stem}-{method}.toml")
        require_suffix(target, (".toml",))
        require_free(target, force)
        the_track = read_track(path)
        data = modal_rail(the_track, method, modes)
        target.parent.mkdir(parents=True, exist_ok=True)
        write_modal_data(target, data)
        omega = 2 * np.pi * error_frequencies()
        errors = fit_errors(omega, track_receptance(omega, the_track), data.modes)
    if json:
        screen.print_json(data=errors)
        return
    print_errors({method: errors}, f"{the_track.title}: receptance against the analytical track, 30 Hz to 5 kHz, rms")
    screen.print(str(target), highlight=False, markup=False, soft_wrap=True)
