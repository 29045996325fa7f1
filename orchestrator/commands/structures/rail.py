"""The commands `rail ...`: options in, files and tables out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from ...errors import InputError
from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes

if TYPE_CHECKING:
    from fmus.modal.data import ModalData


Track = Annotated[
    str, typer.Argument(metavar="TRACK", help="A track file, or default, soft-pads, rail-dampers, bs113a, slab.")
]

Errors = dict[str, dict[str, float]]


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
    _print_errors({method: errors}, f"{the_track.title}: receptance against the analytical track, 30 Hz to 5 kHz, rms")
    screen.print(str(target), highlight=False, markup=False, soft_wrap=True)


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
    _print_errors(errors, f"{the_track.title}: receptance against the analytical track, 30 Hz to 5 kHz, rms")
    for path in files:
        screen.print(str(path), highlight=False, markup=False, soft_wrap=True)


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


def regenerate(
    check: Annotated[bool, typer.Option("--check", help="Write nothing; fail where the files differ.")] = False,
) -> None:
    """Make the modal data files that the project ships anew. Takes minutes."""
    from fmus.rail import shipped as making  # noqa: PLC0415

    with user_mistakes():
        if not check:
            making.regenerate()
            return
        found = making.differences()
    if found:
        raise InputError("; ".join(found))
    screen.print("the shipped modal rails are what their methods make", highlight=False)


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


def _print_errors(errors: dict[str, Errors], title: str) -> None:
    """Print a table of fit errors, a row per rail and direction."""
    table = Table("rail", "direction", title=title, title_justify="left")
    for heading in ("dB", "degrees", "modes"):
        table.add_column(heading, justify="right")
    for name, of_direction in errors.items():
        for direction, error in of_direction.items():
            numbers = (f"{error['rms_db']:.2f}", f"{error['rms_degrees']:.1f}", f"{error['modes']:.0f}")
            table.add_row(name, direction, *numbers)
    screen.print(table)
