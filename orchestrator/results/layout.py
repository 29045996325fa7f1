"""How results lie in a file: columns to records, names to names that NetCDF takes, checksums of rows and header.

The last column of each record is the CRC-32 of the others, and the header has one of itself, so that a cut, a hole that
a power cut left, and a flipped bit are all seen.
"""

from __future__ import annotations

import re
import struct
import unicodedata
import zlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

TIME = "time after a step"
"""Description of the first variable."""

CHECKSUM = "row_checksum"
"""Name of the last variable."""

HEADER_CHECKSUM = "header_checksum"
UNKNOWN = "crc32:00000000"
"""The attribute that has the checksum of the header, and what it says while that is computed."""

COUNT_POSITION = 4
"""Position of the number of records in a classic NetCDF file [bytes]."""

_DOUBLE = 6
"""The number that stands for the type of the first variable."""

LONGEST_NAME = 200
"""Longest name of a variable or a file, in letters."""

_REAL = np.dtype(np.float64)
_WIDE = (np.dtype(np.int64), np.dtype(np.uint64))


@dataclass(frozen=True)
class Column:
    """A recorded signal.

    Attributes
    ----------
    name, unit, description : as the results have them
    dtype : type of its values
    """

    name: str
    unit: str
    description: str
    dtype: np.dtype[Any] = _REAL

    @property
    def stored(self) -> np.dtype[Any]:
        """Type of its values in a file: truth values are bytes there."""
        return np.dtype(np.int8) if self.dtype.kind == "b" else self.dtype

    def values(self, rows: NDArray[np.float64], place: int) -> NDArray[Any]:
        """Return the values of this signal in rows of the master, where it is column `place`.

        Notes
        -----
        The rows are doubles, but for whole numbers of 64 bits, which stand there bit by bit.
        """
        if self.dtype in _WIDE:
            return rows.view(self.dtype)[:, place]
        return rows[:, place].astype(self.stored)


def stored_names(names: Iterable[str]) -> list[str]:
    r"""Return the names under which a NetCDF file has signals: without what it does not take, none twice.

    >>> stored_names(["a.y", "a/b.y ", "a\nb"])
    ['a.y', 'a_b.y_', 'a_b']
    """
    found: dict[str, None] = {"time": None, CHECKSUM: None}
    for name in names:
        plain = re.sub(r"[/\x00-\x1f\x7f]|\s$|^(?=[^\w])", "_", unicodedata.normalize("NFC", name)[:LONGEST_NAME])
        stored, number = plain, 1
        while stored in found:
            number += 1
            stored = f"{plain}~{number}"
        found[stored] = None
    return list(found)[2:]


def file_stem(name: str) -> str:
    """Return a system's name as one that a file can have anywhere.

    >>> file_stem("a/b: [red]"), file_stem(".."), file_stem("case1")
    ('a_b_ [red]', '_', 'case1')
    """
    plain = re.sub(r'[/\\:*?"<>|\x00-\x1f\x7f-\x9f\ud800-\udfff]', "_", name).strip(" .")
    while len(plain.encode()) > LONGEST_NAME:
        plain = plain[:-1]
    return plain or "_"


def record_layout(kinds: Sequence[np.dtype[Any]]) -> np.dtype[Any]:
    """Return the data type of a record: the values side by side, each from a whole word on, high bytes first."""
    starts = np.cumsum([0, *(-(-kind.itemsize // 4) * 4 for kind in kinds)])
    return np.dtype(
        {
            "names": [f"f{k}" for k in range(len(kinds))],
            "formats": [kind.newbyteorder(">") for kind in kinds],
            "offsets": starts[:-1].tolist(),
            "itemsize": int(starts[-1]),
        }
    )


def checksums(records: memoryview, size: int) -> NDArray[np.uint32]:
    """Return the checksum of each record of `size` bytes, over all but its last word."""
    return np.array([zlib.crc32(records[k : k + size - 4]) for k in range(0, len(records), size)], dtype=np.uint32)


def whole_rows(records: memoryview, size: int) -> int:
    """Return how many records from the first on agree with their checksums."""
    count = len(records) // size
    own = np.frombuffer(records[: count * size], dtype=np.uint8).reshape(count, size)[:, -4:].copy().view(">u4")[:, 0]
    wrong = np.flatnonzero(own != checksums(records[: count * size], size))
    return int(wrong[0]) if wrong.size else count


def header_checksum(header: bytes) -> tuple[int, str] | None:
    """Return where the checksum of a header stands and what it has to be; None for a header without."""
    place = header.find(UNKNOWN[:6].encode(), max(header.find(HEADER_CHECKSUM.encode()), 0))
    if HEADER_CHECKSUM.encode() not in header or place < 0:
        return None
    bare = bytearray(header)
    width = 8 if header[3] == 5 else 4  # CDF-5 counts in 64 bits
    bare[COUNT_POSITION : COUNT_POSITION + width] = bytes(width)
    bare[place : place + len(UNKNOWN)] = UNKNOWN.encode()
    return place, f"crc32:{zlib.crc32(bare):08x}"


def records_begin(header: bytes, path: Path) -> int:
    """Return where the first record of a file begins [bytes].

    The library leaves a file with a header above 8 kB longer than that. A variable's entry in the header ends with its
    attributes, its type, the size of one record and the place of the first; `time` is the first variable.
    """
    after = header.find(TIME.encode()) + 4 * -(-len(TIME) // 4)
    kind, size, begin = struct.unpack_from(">iqq" if header[3] == 5 else ">iiq", header, after)
    if (kind, size) != (_DOUBLE, 8) or not begin > 0:
        raise RuntimeError(f"{path}: the NetCDF library wrote a header of an unknown form")
    return int(begin)
