"""Files of mode shapes at nodes by their content: the one way in."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ...errors import DataError
from ..units import UnitSystem, read_system
from ..universal import is_universal
from .frd import is_frd, read_frd
from .nastran_binary import is_nastran_binary, read_nastran_binary
from .nastran_text import is_nastran_text, read_nastran_text
from .nodal import NodalModes
from .universal_modes import read_universal_modes

_FORMATS: tuple[tuple[Callable[[bytes], bool], Callable[[Path, UnitSystem | None], NodalModes]], ...] = (
    (is_frd, read_frd),
    (is_universal, read_universal_modes),
    (is_nastran_binary, read_nastran_binary),
    (is_nastran_text, read_nastran_text),
)


def is_shapes(head: bytes) -> bool:
    """Return whether a file that begins so has mode shapes at nodes."""
    return any(is_it(head) for is_it, _ in _FORMATS)


def read_shapes(path: Path, head: bytes, units: str | None) -> NodalModes:
    """Return the mode shapes of a universal file or of results of CalculiX or Nastran.

    Parameters
    ----------
    head : what the file begins with
    units : of length and force, 'mm,N', where the file does not say them
    """
    system = None if units is None else read_system(units)
    for is_it, read in _FORMATS:
        if is_it(head):
            return read(path, system)
    raise DataError(f"{path.name}: only universal files, .frd, .f06 and .op2 can be parts of one wheelset")
