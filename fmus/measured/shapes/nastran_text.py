"""Normal modes in Nastran's printed results (.f06): text in, mass-normalised shapes and coordinates in SI out.

Read are the pages REAL EIGENVALUES (frequency, generalised mass), REAL EIGENVECTOR NO. and, for coordinates, the GRID
entries of the sorted bulk data echo (ECHO=SORT): without these nobody can say what part of a wheelset a model is.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ...errors import DataError
from ..function import Real
from ..tables import read_text
from ..units import UnitSystem
from .nastran import Grid, Nastran, shapes
from .nodal import NodalModes
from .raw import needed

_VALUES, _VECTOR = "R E A L   E I G E N V A L U E S", "R E A L   E I G E N V E C T O R   N O ."
_ECHO, _END = re.compile(r"^\s+\d+-\s{8}(GRID[* ].*|\*.*)$"), "END OF JOB"
_FORTRAN = re.compile(r"^([-+]?\d*\.\d*)(?:[EDed]?([-+]\d+)|[EDed](\d+))?$")


def is_nastran_text(head: bytes) -> bool:
    """Return whether a file that begins so is one of Nastran's printed results: a page, and its name on it."""
    return head.startswith((b"1", b"0")) and b"NASTRAN" in head.upper().replace(b" ", b"")


def read_nastran_text(path: Path, units: UnitSystem | None) -> NodalModes:
    """Return the normal modes of a file.

    Parameters
    ----------
    units : what the deck was written in; the file does not say it

    Raises
    ------
    DataError
        For a file without modes or coordinates, or one that is cut off, with its line.
    """
    system = needed(path.name, units)
    reader = _Reader(path.name)
    text = read_text(path)
    for number, line in enumerate(text.splitlines(), start=1):
        reader.take(line, number)
    if _END not in text:
        raise DataError(f"{path.name}: does not end with {_END}; the file is cut off")
    return shapes(reader.found, system)


def number(text: str) -> float:
    """Return a number as Nastran writes it.

    >>> number("1.5-3"), number("7."), number("2.5E+02")
    (0.0015, 7.0, 250.0)
    """
    match = _FORTRAN.match(text.strip())
    if match is None or not match[1].strip("+-."):
        raise DataError(f"{text.strip()!r} is no number")
    return float(f"{match[1]}e{match[2] or match[3] or 0}")


class _Reader:
    """What has been read of a file, line by line.

    Attributes
    ----------
    found : eigenvalues, vectors and grids
    """

    def __init__(self, name: str) -> None:
        self.found = Nastran(name, "ask for the sorted bulk data (ECHO=SORT), or read the .op2")
        self._name = name
        self._page = ""
        self._mode = 0
        self._large = ""

    def take(self, line: str, number: int) -> None:
        """Take the next line."""
        where = f"{self._name}, line {number}"
        if line.startswith("1"):
            self._page = ""
        elif _VALUES in line:
            self._page = "values"
        elif _VECTOR in line:
            self._page, self._mode = "vector", _whole(line.rsplit(".", 1)[1], where, "the number of the eigenvector")
        elif self._page == "values":
            self._eigenvalue(line.split(), where)
        elif self._page == "vector":
            self._row(line.split(), where)
        elif (card := _ECHO.match(line)) is not None:
            self._echo(card[1], where)

    def _eigenvalue(self, words: list[str], where: str) -> None:
        """Take a row of the table of eigenvalues: mode, order, eigenvalue, radians, cycles, mass, stiffness."""
        if len(words) != 7 or not words[0].isdigit():
            return
        try:
            eigenvalue, mass = number(words[2]), number(words[5])
        except ValueError:
            raise DataError(
                f"{where}: must be mode, order, eigenvalue, radians, cycles, mass, stiffness; got {words}"
            ) from None
        self.found.add_value(int(words[0]), eigenvalue, mass, where)

    def _row(self, words: list[str], where: str) -> None:
        """Take a row of an eigenvector: point, G, T1, T2, T3 and, unless blank, R1, R2, R3."""
        if len(words) < 2 or not words[0].isdigit() or words[1] != "G":
            return
        try:
            values = np.array([number(word) for word in words[2:]])
        except ValueError:
            values = np.zeros(0)
        if values.size not in (3, 6):
            raise DataError(f"{where}: must be a point, G and three or six numbers; got {' '.join(words)!r}")
        self.found.add_vector(self._mode, int(words[0]), values, where)

    def _echo(self, card: str, where: str) -> None:
        """Take a line of the sorted echo, of fields of 8 or, with GRID* and the line below it, 16 characters."""
        if card.startswith("GRID*"):
            self._large = card[8:72].ljust(64)
            return
        if card.startswith("*") and not self._large:
            return  # of another entry
        fields = _fields(self._large + card[8:72], 16) if self._large else _fields(card[8:72], 8)
        self._large = ""
        try:
            xyz: Real = np.array([number(field) if field else 0.0 for field in fields[2:5]])
            grid = Grid(int(fields[0]), int(fields[1] or 0), xyz, int(fields[5] or 0))
        except ValueError:
            raise DataError(f"{where}: must be a GRID entry; got {card.strip()!r}") from None
        self.found.add_grid(grid)


def _fields(text: str, width: int) -> list[str]:
    """Return the fields of an entry."""
    return [text.ljust(8 * width)[i * width : (i + 1) * width].strip() for i in range(8)]


def _whole(text: str, where: str, what: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise DataError(f"{where}: {what} must be a number; got {text.strip()!r}") from None
