"""FMUs that are shipped, by name: built when a plan asks for them and kept until the sources change."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from fmus.packaging.build import build_fmus
from fmus.packaging.catalogue import components
from fmus.packaging.target import default_target

from ..errors import InputError
from ..system.cases import built_ssp


def shipped_fmu(name: str) -> Path:
    """Return the FMU of a shipped component, such as wheel-generic840.

    Raises
    ------
    InputError
        If there is no such component, or FMUs cannot be built here.
    """
    known = components()
    if name not in known:
        raise InputError(f"{name}: neither an .fmu file nor one of {', '.join(known)}")
    final = built_ssp().parent / f"{name}.fmu"
    if not final.is_file():
        temporary = Path(tempfile.mkdtemp(dir=final.parent, prefix="building-"))
        try:
            build_fmus({name: known[name]}, temporary, default_target())[name].replace(final)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    return final
