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
from .model import System
from .reader import read_system


def find_system(text: str) -> System:
    """Return the system of a case name or a file."""
    path = Path(text)
    if path.suffix in (".ssp", ".ssd") or ".ssp#" in path.name:
        return read_system(path)
    names = [case.name for case in read_cases()]
    if text not in names:
        raise InputError(f"{text}: neither a case ({', '.join(names)}) nor an .ssp or .ssd file")
    return read_system(built_ssp(), variant=text)


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
