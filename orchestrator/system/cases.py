"""The systems that the project ships: a case or a file by its name in, a system out."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from pathlib import Path

import fmus as components
from fmus.cache import cache_folder, mark_used
from fmus.cases import SSP_FOLDER, read_cases
from fmus.errors import DataError
from fmus.packaging.build import SSP_NAME, build
from fmus.packaging.target import default_target

from ..errors import InputError
from ..fmi.instance import open_fmu
from .model import Element, System
from .reader import read_system

SYSTEM_FILES = (".ssp", ".ssd", ".fmu")
"""What files that are a system end with."""


def find_system(text: str) -> System:
    """Return the system of a case name or a file."""
    path = Path(text)
    if path.suffix == ".fmu":
        return _alone(path)
    if path.suffix in (".ssp", ".ssd") or ".ssp#" in path.name:
        return read_system(path)
    names = [case.name for case in read_cases()]
    if text not in names:
        raise InputError(f"{text}: neither a case ({', '.join(names)}) nor an .ssp, .ssd or .fmu file")
    return read_system(built_ssp(), variant=text)


def _alone(path: Path) -> System:
    """Return the system that one FMU is: its inputs stay at their start values, step and stop time are its own."""
    experiment = open_fmu(path).description.defaultExperiment
    texts = [getattr(experiment, name, None) for name in ("startTime", "stopTime", "stepSize")]
    start, stop, step = (None if text is None else float(text) for text in texts)
    name = path.stem.replace(".", "_")  # a dot would be a system in the system
    return System(
        name, path, {name: Element(name, path)}, (), start=start or 0.0, stop=stop, step_size=step, variants=(name,)
    )


def built_ssp() -> Path:
    """Return the project's own SSP, built when its sources have changed since the last time."""
    digest = hashlib.sha256()
    package = Path(components.__file__).parent
    for folder, pattern in ((package, "*"), (SSP_FOLDER, "*.toml")):
        for path in sorted(folder.rglob(pattern)):
            if path.is_file() and "__pycache__" not in path.parts:
                digest.update(path.name.encode() + path.read_bytes())
    try:
        target = default_target()
    except DataError as error:
        raise InputError(f"the FMUs of the cases cannot be built here: {error}") from None
    digest.update(str(target).encode())
    folder = cache_folder("built")
    final = folder / digest.hexdigest()[:32]
    if not final.is_dir():
        temporary = Path(tempfile.mkdtemp(dir=folder, prefix="building-"))
        try:
            build(temporary, target, only_cases=True)
            temporary.replace(final)
        except OSError:  # somebody else was faster
            if not final.is_dir():
                raise
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    mark_used(final)
    return final / SSP_NAME
