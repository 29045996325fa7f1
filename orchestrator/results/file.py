"""Results on disk: NetCDF files that are readable at every moment of a run.

The file is classic NetCDF (64-bit offset): a header, then one record per row with all signals side by side, and the
number of records at a fixed place of the header. Rows are appended and then counted, so that a run that is killed
leaves a file with everything up to the last append. The header is written by the NetCDF library.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import netCDF4
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

_COUNT_POSITION = 4
"""Position of the number of records in a classic NetCDF file [bytes]."""

_TIME = "time at the end of a step"
_DOUBLE = 6
"""Description of the first variable, and the number that stands for its type."""


class ResultsFile:
    """A results file that is being written.

    Parameters
    ----------
    path : file to create; its folder is created too
    signals : name, unit and description of each column after time
    attributes : what the file says of itself

    Attributes
    ----------
    rows : number of rows that are in the file
    header : size of what comes before them [bytes]
    """

    def __init__(
        self, path: Path, signals: Sequence[tuple[str, str, str]], attributes: Mapping[str, str | float | int]
    ) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_OFFSET") as data:
            data.createDimension("time", None)
            time = data.createVariable("time", "f8", ("time",))
            time.units, time.long_name = "s", _TIME
            for name, unit, description in signals:
                variable = data.createVariable(name, "f4", ("time",))
                variable.units, variable.long_name = unit, description
            data.setncatts(dict(attributes))
        os.truncate(path, _records_begin(path))
        self._open(path, len(signals))
        self.rows = 0
        self.header = self._file.seek(0, 2)

    def _open(self, path: Path, columns: int) -> None:
        self.path = path
        self._layout = np.dtype([("time", ">f8"), ("signals", ">f4", (columns,))])
        self._file = path.open("r+b")

    @classmethod
    def reopen(cls, path: Path, columns: int, header: int, rows: int) -> ResultsFile:
        """Return a file to go on with after its first `rows` rows; what came after them is cut off.

        Parameters
        ----------
        columns : number of columns after time
        header : size of the header [bytes]

        Raises
        ------
        InputError
            If the file is missing or shorter than that.
        """
        file = cls.__new__(cls)
        try:
            file._open(path, columns)
        except OSError as error:
            raise InputError(f"{path}: cannot go on with these results: {error.strerror or error}") from None
        file.header, file.rows = header, rows
        end = header + rows * file._layout.itemsize
        if file._file.read(3) != b"CDF" or file._file.seek(0, 2) < end:
            file.close()
            raise InputError(f"{path}: does not hold the {rows} rows that the checkpoint goes on from")
        file._count()
        file._file.truncate(end)
        return file

    def append(self, time: NDArray[np.float64], signals: NDArray[np.float64]) -> None:
        """Append rows: times (n,) [s] and signals (n, columns)."""
        rows = np.empty(time.size, self._layout)
        rows["time"] = time
        rows["signals"] = signals
        self._file.seek(0, 2)
        self._file.write(rows.tobytes())
        self._file.flush()
        self.rows += time.size
        self._count()

    def _count(self) -> None:
        """Write the number of rows into the header."""
        self._file.seek(_COUNT_POSITION)
        self._file.write(struct.pack(">i", self.rows))
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


def _records_begin(path: Path) -> int:
    """Return where the first record of a new file begins [bytes].

    The library leaves a file with a header above 8 kB longer than that. A variable's entry in the header ends with its
    attributes, its type, the size of one record and the place of the first; `time` is the first variable.
    """
    header = path.read_bytes()
    after = header.find(_TIME.encode()) + 4 * -(-len(_TIME) // 4)
    kind, size, begin = struct.unpack_from(">iiq", header, after)
    if (kind, size) != (_DOUBLE, 8) or begin > len(header):
        raise RuntimeError(f"{path}: the NetCDF library wrote a header of an unknown form")
    return int(begin)


def open_results(path: Path) -> xr.Dataset:
    """Return the results in a file, loaded lazily.

    Raises
    ------
    InputError
        If the file is missing or holds no results.
    """
    import xarray as xr  # noqa: PLC0415

    if not path.is_file():
        raise InputError(f"{path}: no such results file")
    try:
        data = xr.open_dataset(path, engine="scipy", decode_times=False)  # maps the file: ten times faster by column
    except (OSError, ValueError, TypeError, IndexError) as error:
        raise InputError(_unreadable(path, error)) from None
    if "time" not in data.dims:
        raise InputError(f"{path}: holds no time axis, so it is not a results file of curvesqueal")
    return data


def _unreadable(path: Path, error: Exception) -> str:
    """Return the sentence that says why a file cannot be opened: cut short, or no results file at all."""
    try:
        with netCDF4.Dataset(path) as data:
            rows, row = data.dimensions["time"].size, 8 + 4 * (len(data.variables) - 1)
        begin = _records_begin(path)
    except (OSError, KeyError, RuntimeError, struct.error):
        return f"{path}: is not a results file: {str(error).splitlines()[0]}"
    there = max(0, path.stat().st_size - begin) // row
    return f"{path}: is cut short: its header says {rows} rows, {there} are there; copy it again or run again"
