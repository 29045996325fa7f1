"""Files of measured functions by their content: the one way in. The suffix of a name is a hint to people only."""

from __future__ import annotations

from pathlib import Path

from ..errors import DataError
from .choice import Choice
from .function import Contents
from .selection import Measured, select
from .tables import read_archive, read_csv
from .universal import is_universal, read_universal

_HEAD = 4096


def read_contents(path: Path) -> Contents:
    """Return what a file of measured functions holds: a universal file, CSV or a NumPy archive.

    Raises
    ------
    DataError
        For a file that is none of them, or is broken; says where.
    """
    if not path.is_file():
        raise DataError(f"{path}: no such file")
    with path.open("rb") as file:
        head = file.read(_HEAD)
    if not head.strip():
        raise DataError(f"{path.name}: is empty")
    if head.startswith(b"PK\x03\x04"):
        return read_archive(path)
    return read_universal(path) if is_universal(head) else read_csv(path)


def read_measured(path: Path, choice: Choice | None = None) -> list[Measured]:
    """Return the measured functions of a file, in SI and the contract's axes.

    Parameters
    ----------
    path : Path
    choice : Choice, optional
        What the file does not say itself.
    """
    return select(read_contents(path), choice or Choice())
