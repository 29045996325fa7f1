"""Treatments named on a run: damping of modes by label, and rails by name; texts in, parameter values and FMUs out."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmus.errors import DataError
from fmus.modal import component as structure_of
from fmus.modal.component import structure
from fmus.modal.layout import DAMPING_RATIO
from fmus.modal.parameters import names_of
from fmus.packaging.build import build_fmu
from fmus.packaging.target import default_target
from fmus.rail import shipped
from fmus.rail.track_data import TRACKS, read_track
from fmus.wheel.treatment import matching, read_rule

from ..archive import cache_folder
from ..coupling.assembly import open_fmus
from ..errors import InputError
from ..fmi.instance import Fmu, Value
from ..system.cases import find_system
from ..system.values import component_values

DEFAULT_COMPONENT = "wheel"
"""Whose labels are meant where a rule names no component."""


def damping_values(
    system: str, sources: Mapping[str, Path], values: Mapping[str, Mapping[str, Value]], rules: Sequence[str]
) -> dict[str, dict[str, Value]]:
    """Return parameter values that damp modes, in addition to others.

    Parameters
    ----------
    system : a case, an .ssp or an .ssd file
    sources : FMUs that take a component's place
    values : parameter values by component and name, of which the result is a copy with damping ratios added
    rules : '(3,0)=1e-3' and '(*,0)=+1e-4' of the wheel's labels, 'rail:lat 1=0.2' of another component's, 'wheel=x2'

    Raises
    ------
    InputError
        For a rule that is none, or means no mode of the system.
    """
    found = find_system(system).with_sources(dict(sources))
    fmus = open_fmus(found)
    result = {name: dict(own) for name, own in values.items()}
    for text in rules:
        try:
            rule = read_rule(text)
            component, _, pattern = rule.target.rpartition(":")
            component = component or (rule.target if rule.target in fmus else DEFAULT_COMPONENT)
            if component not in fmus:
                raise DataError(f"damping {text!r}: there is no component {component}; has {', '.join(sorted(fmus))}")
            names = names_of(DAMPING_RATIO, fmus[component].variables)
            if not names:
                raise DataError(f"damping {text!r}: {component} shows no modes")
            places = range(len(names)) if rule.target == component else matching(labels_of(fmus[component]), pattern)
        except DataError as error:
            raise InputError(str(error)) from None
        own = result.setdefault(component, {})
        before = {**component_values(found.elements[component], fmus[component]).values, **own}
        for place in places:
            name = names[sorted(names)[place]]
            own[name] = rule.of(float(before.get(name, fmus[component].variables[name].start or 0.0)))
    return result


def labels_of(fmu: Fmu) -> list[str]:
    """Return the labels of an FMU's modes, which stand in the descriptions of its damping ratios."""
    names = names_of(DAMPING_RATIO, fmu.variables)
    texts = [str(fmu.variables[name].description or "") for name in names.values()]
    array = {text.partition("one value per mode: ")[2] for text in texts}
    if len(array) == 1 and (labels := array.pop()):
        return labels.split("; ")
    return [text.partition(" of mode ")[2].partition(", ")[2] for text in texts]


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
    tracks = {file.stem: file for file in sorted(TRACKS.glob("*.toml"))}
    track = tracks.get(text, path)
    if not track.is_file():
        raise InputError(f"rail {text}: neither an .fmu, a track file nor one of {', '.join(tracks)}")
    final = cache_folder().parent / "rails" / f"{track.stem}-{rail_key(track)}.fmu"
    if not final.is_file():
        try:
            data = shipped.modal_rail(read_track(track), "accurate")
        except DataError as error:
            raise InputError(str(error)) from None
        final.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=final.parent) as folder:
            temporary = Path(folder) / "rail.fmu"
            build_fmu(structure("rail", f"Rail at the contact point: {data.title}", data.modes), temporary)
            temporary.replace(final)
    return final


def rail_key(track: Path) -> str:
    """Return a name for the rail of a track file that changes with the file and with how rails are made."""
    digest = hashlib.sha256(track.read_bytes() + str(default_target()).encode())
    for folder in (Path(shipped.__file__).parent, Path(structure_of.__file__).parent):
        for source in sorted(folder.glob("*.py")):
            digest.update(source.read_bytes())
    return digest.hexdigest()[:16]
