"""Normal modes in Nastran's binary results (.op2): tables of Fortran records in, shapes and coordinates in SI out.

Read are the tables of eigenvalues (LAMA), eigenvectors (OUGV1 and its like) and grid points (GEOM1) that PARAM,POST,-1
writes, of either byte order and word length.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import DataError
from ..units import UnitSystem
from .nastran import Grid, Nastran, shapes
from .nodal import NodalModes
from .raw import needed

_VECTORS = ("OUGV1", "OUG1", "OPHIG", "BOUGV1", "BOPHIG", "OUGV1PAT")
_VALUES = ("LAMA", "LAMAS")
_GRID = (4501, 45)
_REAL_EIGENVALUES, _GRID_POINT = 2, 1


@dataclass(frozen=True)
class _Words:
    """How a file writes numbers: byte order '<' or '>', and the length of a word in bytes."""

    order: str
    size: int

    def integers(self, data: bytes) -> NDArray[np.int64]:
        """Return the words as integers."""
        return np.frombuffer(data, dtype=f"{self.order}i{self.size}").astype(np.int64)

    def reals(self, data: bytes) -> NDArray[np.float64]:
        """Return the words as numbers."""
        return np.frombuffer(data, dtype=f"{self.order}f{self.size}").astype(float)


def is_nastran_binary(head: bytes) -> bool:
    """Return whether a file that begins so is one of Nastran's binary results."""
    return _words(head) is not None


def _words(head: bytes) -> _Words | None:
    """Return how a file writes numbers by its first record, one word: 3 (a date follows) or 2 (a table's name)."""
    for order in "<>":
        for size, code in ((4, "i"), (8, "q")):
            if len(head) >= 8 + size:
                first, value, last = struct.unpack_from(f"{order}i{code}i", head)
                if first == last == size and value in (2, 3):
                    return _Words(order, size)
    return None


def read_nastran_binary(path: Path, units: UnitSystem | None) -> NodalModes:
    """Return the normal modes of a file.

    Parameters
    ----------
    units : what the deck was written in; the file does not say it

    Raises
    ------
    DataError
        For a file without modes or coordinates, or one that is cut off, with the table.
    """
    system = needed(path.name, units)
    data = path.read_bytes()
    words = _words(data)
    if words is None:
        raise DataError(f"{path.name}: does not begin as a binary result of Nastran")
    found = Nastran(path.name, "write GEOM1, too (PARAM,POST,-1)")
    vectors = ""
    for name, records in _tables(path.name, data, words):
        where = f"{path.name}, table {name}"
        if name.startswith("GEOM1"):
            _grids(found, words, records)
        elif name in _VALUES:
            _eigenvalues(found, words, records[4::2], where)
        elif name in _VECTORS and vectors in ("", name):
            _eigenvectors(found, words, records, where)
            vectors = name if found.vectors else ""  # the same in other systems may follow
    return shapes(found, system)


def _tables(where: str, data: bytes, words: _Words) -> Iterator[tuple[str, list[bytes]]]:
    """Yield name and records of each table; a record is what stands between two markers below 0.

    Notes
    -----
    A marker is a Fortran record of one word. One above 0 is followed by a Fortran record of as many words, one of 0
    ends the table. From the third on, a record begins with a word that says what it is, which is left out.
    """
    records: list[bytes] = []
    parts: list[bytes] = []
    at, table = 0, "the header"
    try:
        while at < len(data):
            marker, at = _fortran(data, at, words)
            count = int(words.integers(marker)[0]) if len(marker) == words.size else 0
            if count > 0:
                part, at = _fortran(data, at, words)
                parts.append(part)
                continue
            records.append(b"".join(parts[1:] if len(records) > 1 else parts))
            parts = []
            if len(records) == 1:
                table = records[0][: 2 * words.size].decode("latin-1").replace("\0", " ").strip()
            if count == 0:
                if len(records) > 2:
                    yield table, records
                records = []
    except struct.error:
        raise DataError(f"{where}: ends within {table}; the file is cut off") from None
    if records or parts:
        raise DataError(f"{where}: ends within {table}; the file is cut off")


def _fortran(data: bytes, at: int, words: _Words) -> tuple[bytes, int]:
    """Return a Fortran record and where the next begins; its length stands before and after it."""
    (size,) = struct.unpack_from(f"{words.order}i", data, at)
    end = at + 4 + size
    (again,) = struct.unpack_from(f"{words.order}i", data, end) if size >= 0 else (None,)
    if again != size:
        raise struct.error
    return data[at + 4 : end], end + 4


def _grids(found: Nastran, words: _Words, records: list[bytes]) -> None:
    """Take the GRID entries: number, CP, x, y, z, CD, PS, SEID, with coordinates of one word or, in some, two."""
    for record in records[3:]:
        if tuple(words.integers(record[: 2 * words.size])) != _GRID:
            continue
        body = record[3 * words.size :]
        for real in (f"f{words.size}", "f8"):
            integer = f"{words.order}i{words.size}"
            row = np.dtype([("head", integer, 2), ("xyz", words.order + real, 3), ("tail", integer, 3)])
            if len(body) % row.itemsize == 0:
                table: Any = np.frombuffer(body, dtype=row)
                if (np.diff(table["head"][:, 0]) > 0).all() and (table["tail"][:, 2] == 0).all():
                    break
        else:
            raise DataError(f"{found.where}, table GEOM1: its GRID entries are of no known length")
        for (node, system), xyz, (output, _, _) in zip(table["head"], table["xyz"], table["tail"], strict=True):
            found.add_grid(Grid(int(node), int(system), xyz.astype(float), int(output)))


def _eigenvalues(found: Nastran, words: _Words, records: list[bytes], where: str) -> None:
    """Take the eigenvalues: mode, order, eigenvalue, radians, cycles, generalised mass and stiffness."""
    for record in records:
        if len(record) % (7 * words.size):
            raise DataError(f"{where}: has {len(record) // words.size} words; must be seven for each mode")
        numbers, reals = words.integers(record).reshape(-1, 7), words.reals(record).reshape(-1, 7)
        for (mode, *_), real in zip(numbers.tolist(), reals.tolist(), strict=True):
            found.add_value(mode, real[2], real[5], where)


def _eigenvectors(found: Nastran, words: _Words, records: list[bytes], where: str) -> None:
    """Take the eigenvectors: a record that says which mode, and one of eight words for each grid point."""
    for ident, record in zip(records[3::2], records[4::2], strict=False):
        said = words.integers(ident)
        if said[0] // 10 != _REAL_EIGENVALUES or said[1] % 1000 not in (1, 7):
            continue
        mode = int(said[4])
        if said[1] // 1000 or said[8] != 1 or said[9] != 8:
            raise DataError(f"{where}, mode {mode}: must be real eigenvectors sorted by mode (SORT1, REAL)")
        if len(record) % (8 * words.size):
            raise DataError(
                f"{where}, mode {mode}: has {len(record) // words.size} words; must be eight for each point"
            )
        numbers, reals = words.integers(record).reshape(-1, 8), words.reals(record).reshape(-1, 8)
        for (key, kind, *_), values in zip(numbers.tolist(), reals[:, 2:], strict=True):
            if kind == _GRID_POINT:
                found.add_vector(mode, key // 10, values, where)
