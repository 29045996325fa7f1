"""Results on disk: NetCDF files that are readable at every moment of a run.

The file is classic NetCDF (64-bit offset): a header, then one record per row with all signals side by side, and the
number of records at a fixed place of the header. Rows are appended and then counted, so that a run that is killed
leaves a file with everything up to the last append. The header is written by the NetCDF library. Signals keep their
types; classic NetCDF has no whole numbers of 64 bits and none without sign, so a file with such signals is of the
variant with 64-bit data. Rows and header have checksums (`layout`). Whoever writes to a file holds a lock on it, which
ends with the process (docs/adr/0021).
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol
from uuid import uuid4

import netCDF4
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .layout import (
    CHECKSUM,
    COUNT_POSITION,
    HEADER_CHECKSUM,
    TIME,
    UNKNOWN,
    Column,
    checksums,
    file_stem,
    header_checksum,
    record_layout,
    records_begin,
    stored_names,
)
from .locks import lock
from .reading import attributes_of, extent, open_results

__all__ = ["Column", "Results", "ResultsFile", "open_results"]

_CLASSIC = frozenset(["f8", "f4", "i4", "i2", "i1"])
"""Types that classic NetCDF has."""

_SUM = np.dtype(np.int32)
"""Type of the checksum of a row; classic NetCDF has none without sign."""


class Results(Protocol):
    """What takes the rows of a run."""

    path: Path
    rows: int

    def append(self, time: NDArray[np.float64], rows: NDArray[np.float64]) -> None:
        """Append rows: times (n,) [s] and values (n, columns) as `Column.values` reads them."""

    def sync(self) -> None:
        """Return when everything that was appended is on the disk."""


class ResultsFile:
    """A results file that is being written; it appears under its name with a whole header.

    Parameters
    ----------
    path : file to create; its folder is created too
    signals : name, unit and description of each column after time
    attributes : what the file says of itself
    replace : whether a file that is there is replaced

    Attributes
    ----------
    rows : number of rows that are in the file
    attributes : what it says of itself, or what it was asked for when it was opened again

    Raises
    ------
    FileExistsError
        If a file is there that is not to be replaced.
    """

    def __init__(
        self, path: Path, signals: Sequence[Column], attributes: Mapping[str, str | float | int], replace: bool = True
    ) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f".{uuid4().hex}.nc")
        try:
            _write_header(partial, signals, attributes)
            self._open(partial, signals)
            if replace:
                partial.replace(path)
            else:
                _appear(partial, path)
        except BaseException:
            with suppress(AttributeError):
                self._file.close()
            raise
        finally:
            partial.unlink(missing_ok=True)
        self.path, self.attributes = path, dict(attributes)
        self.rows = 0

    @classmethod
    def claim(
        cls, folder: Path, name: str, signals: Sequence[Column], attributes: Mapping[str, str | float | int]
    ) -> ResultsFile:
        """Return a new file in `folder`, called after `name`; no other run, earlier or at the same time, gets the same.

        Raises
        ------
        OSError
            If nothing can be written there.
        """
        stem, number = file_stem(name), 1
        while True:
            path = folder / (f"{stem}.nc" if number == 1 else f"{stem}-{number}.nc")
            if not os.path.lexists(path):
                with suppress(FileExistsError):
                    return cls(path, signals, attributes, replace=False)
            number += 1

    _begin = 0
    """Where the rows begin in a file that was opened again [bytes]."""

    def _open(self, path: Path, columns: Sequence[Column]) -> None:
        self._columns = list(columns)
        self._layout = record_layout([np.dtype(np.float64), *(column.stored for column in columns), _SUM])
        self._file = path.open("r+b")
        if not lock(self._file):
            self._file.close()
            raise InputError(f"{path}: another process is writing to these results")

    @classmethod
    def reopen(cls, path: Path, columns: Sequence[Column], own: Mapping[str, str]) -> ResultsFile:
        """Return a file to go on with; nothing in it is changed before `cut` says after which row.

        Parameters
        ----------
        columns : the signals after time
        own : attributes that the file must have

        Raises
        ------
        InputError
            If the file is missing, another process writes to it, or it is not the one.
        """
        file = cls.__new__(cls)
        try:
            file._open(path, columns)
        except OSError as error:
            raise InputError(f"{path}: cannot go on with these results: {error.strerror or error}") from None
        try:
            there = extent(path)
            about = attributes_of(path) if there is not None else {}
            if there is None or any(about.get(name) != value for name, value in own.items()):
                raise InputError(f"{path}: these are the results of another run; nothing was changed")
            wanted = zip(["time", *stored_names(c.name for c in columns), CHECKSUM], file._types(), strict=True)
            if about["columns"] != [(name, kind.str[1:]) for name, kind in wanted]:
                raise InputError(f"{path}: these results have other columns than the run; nothing was changed")
        except BaseException:
            file.close()
            raise
        file.path, file.rows, file.attributes = path, there.whole, dict(own)
        file._begin = there.begin
        return file

    def cut(self, rows: int) -> None:
        """Leave the first `rows` rows of a file that was opened again, to go on after them.

        Raises
        ------
        InputError
            If it has not so many whole ones.
        """
        if not 0 <= rows <= self.rows:
            raise InputError(f"{self.path}: does not hold the {rows} rows that the checkpoint goes on from")
        self.rows = rows
        self._count()
        self._file.truncate(self._begin + rows * self._layout.itemsize)

    def _types(self) -> list[np.dtype[Any]]:
        return [self._layout[name] for name in self._layout.names or ()]

    def append(self, time: NDArray[np.float64], rows: NDArray[np.float64]) -> None:
        """Append rows: times (n,) [s] and values (n, columns) as `Column.values` reads them."""
        records = np.zeros(time.size, self._layout)
        records["f0"] = time
        for place, column in enumerate(self._columns):
            records[f"f{place + 1}"] = column.values(rows, place)
        size = self._layout.itemsize
        raw: Any = records.view(np.uint8)
        records[f"f{len(self._columns) + 1}"] = checksums(memoryview(raw), size).view(np.int32)
        self._file.seek(0, 2)
        self._file.write(raw.tobytes())
        self._file.flush()
        self.rows += time.size
        self._count()

    def _count(self) -> None:
        """Write the number of rows into the header."""
        self._file.seek(0)
        form = ">q" if self._file.read(4)[3] == 5 else ">i"
        self._file.seek(COUNT_POSITION)
        self._file.write(struct.pack(form, self.rows))
        self._file.flush()

    def sync(self) -> None:
        """Return when everything that was appended is on the disk."""
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __enter__(self) -> ResultsFile:
        """Return the file itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the file."""
        self.close()


def _write_header(path: Path, signals: Sequence[Column], attributes: Mapping[str, str | float | int]) -> None:
    """Write a file without rows."""
    classic = all(column.stored.str[1:] in _CLASSIC for column in signals)
    with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_OFFSET" if classic else "NETCDF3_64BIT_DATA") as data:
        data.createDimension("time", None)
        time = data.createVariable("time", "f8", ("time",))
        time.units, time.long_name = "s", TIME
        for column, name in zip(signals, stored_names(c.name for c in signals), strict=True):
            variable = data.createVariable(name, column.stored, ("time",))
            variable.units, variable.long_name = column.unit, column.description
            if name != column.name:
                variable.variable = column.name
            if column.dtype.kind == "b":
                variable.setncattr("dtype", "bool")  # as xarray writes and reads it
        check = data.createVariable(CHECKSUM, _SUM, ("time",))
        check.long_name = "CRC-32 of the other values of the row"
        data.setncatts({**attributes, HEADER_CHECKSUM: UNKNOWN})
    header = path.read_bytes()
    begin = records_begin(header, path)
    os.truncate(path, begin)
    found = header_checksum(header[:begin])
    if found is None:
        raise RuntimeError(f"{path}: the NetCDF library wrote a header without its checksum")
    with path.open("r+b") as file:
        file.seek(found[0])
        file.write(found[1].encode())


def _appear(partial: Path, path: Path) -> None:
    """Give a file a name that nobody else has.

    Raises
    ------
    FileExistsError
        If somebody has it.
    """
    try:
        os.link(partial, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without second names: two moves, a kill between which leaves an empty file
        path.touch(exist_ok=False)
        partial.replace(path)
