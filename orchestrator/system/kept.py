"""Structures by name: a track in, the FMU of its rail out; fitted and built once and kept."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

from fmus.cache import cache_folder, mark_used
from fmus.component import Component
from fmus.errors import DataError
from fmus.modal import component as structure_of
from fmus.modal.component import structure
from fmus.packaging.build import build_fmu
from fmus.packaging.target import default_target
from fmus.rail.track_data import TRACKS, read_track

from ..errors import InputError


def rail_named(text: str) -> Path:
    """Return the FMU of a rail: a file, or a track by name or file, fitted and built when this was not done before.

    Raises
    ------
    InputError
        If it is none of them.
    """
    path = Path(text)
    if path.suffix == ".fmu":
        return path
    track = track_file(text)
    if track is None:
        raise InputError(f"rail {text}: neither an .fmu, a track file nor one of {', '.join(track_names())}")

    def fitted() -> Component:
        from fmus.rail import shipped  # noqa: PLC0415 - loads scipy.optimize and scikit-fem

        data = shipped.modal_rail(read_track(track), "accurate")
        return structure("rail", f"Rail at the contact point: {data.title}", data.modes)

    return kept_fmu("rails", f"{track.stem}-{rail_key(track)}", fitted)


def track_names() -> list[str]:
    """Return the names of the tracks that are shipped."""
    return sorted(file.stem for file in TRACKS.glob("*.toml"))


def track_file(text: str) -> Path | None:
    """Return the file of a track by its name or path, None if there is none."""
    file = TRACKS / f"{text}.toml" if text in track_names() else Path(text)
    return file if file.is_file() and file.suffix == ".toml" else None


def rail_key(track: Path) -> str:
    """Return a name for the rail of a track file that changes with the file and with how rails are made."""
    digest = hashlib.sha256(track.read_bytes() + str(default_target()).encode() + structure_key().encode())
    for source in sorted(TRACKS.parents[1].glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def structure_key() -> str:
    """Return what changes with the code of wheels and rails."""
    digest = hashlib.sha256()
    for source in sorted(Path(structure_of.__file__).parent.glob("*.py")):
        digest.update(source.read_bytes())
    return digest.hexdigest()


def kept_fmu(kind: str, name: str, make: Callable[[], Component]) -> Path:
    """Return the FMU of a component, built unless it was before under the same name.

    Raises
    ------
    InputError
        If the component cannot be made of its data.
    """
    final = cache_folder(kind) / f"{name}.fmu"
    if not final.is_file():
        try:
            component = make()
        except DataError as error:
            raise InputError(str(error)) from None
        with tempfile.TemporaryDirectory(dir=final.parent) as folder:
            temporary = Path(folder) / f"{component.name}.fmu"
            build_fmu(component, temporary)
            temporary.replace(final)
    mark_used(final)
    return final
