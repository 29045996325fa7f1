"""Results on disk: NetCDF files that are readable at every moment of a run.

The file is classic NetCDF (64-bit offset): a header, then one record per row with all signals side by side, and the
number of records at a fixed place of the header. Rows are appended and then counted, so that a run that is killed
leaves a file with everything up to the last append. The header is written by the NetCDF library. Signals keep their
types; classic NetCDF has no whole numbers of 64 bits and none without sign, so a file with such signals is of the
variant with 64-bit data.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Protocol

import netCDF4
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

_COUNT_POSITION = 4
"""Position of the number of records in a classic NetCDF file [bytes]."""

_TIME = "time after a step"
_DOUBLE = 6
"""Description of the first variable, and the number that stands for its type."""

_CLASSIC = frozenset(["f8", "f4", "i4", "i2", "i1"])
"""Types that classic NetCDF has."""

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


class Results(Protocol):
    """What takes the rows of a run."""

    path: Path
    rows: int

    def append(self, time: NDArray[np.float64], rows: NDArray[np.float64]) -> None:
        """Append rows: times (n,) [s] and values (n, columns) as `Column.values` reads them."""

    def sync(self) -> None:
        """Return when everything that was appended is on the disk."""


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

    def __init__(self, path: Path, signals: Sequence[Column], attributes: Mapping[str, str | float | int]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        classic = all(column.stored.str[1:] in _CLASSIC for column in signals)
        with netCDF4.Dataset(path, "w", format="NETCDF3_64BIT_OFFSET" if classic else "NETCDF3_64BIT_DATA") as data:
            data.createDimension("time", None)
            time = data.createVariable("time", "f8", ("time",))
            time.units, time.long_name = "s", _TIME
            for column in signals:
                variable = data.createVariable(column.name, column.stored, ("time",))
                variable.units, variable.long_name = column.unit, column.description
                if column.dtype.kind == "b":
                    variable.setncattr("dtype", "bool")  # as xarray writes and reads it
            data.setncatts(dict(attributes))
        os.truncate(path, _records_begin(path))
        self._open(path, signals)
        self.rows = 0
        self.header = self._file.seek(0, 2)

    def _open(self, path: Path, columns: Sequence[Column]) -> None:
        self.path = path
        self._columns = list(columns)
        kinds = [np.dtype(np.float64), *(column.stored for column in columns)]
        starts = np.cumsum([0, *(-(-kind.itemsize // 4) * 4 for kind in kinds)])  # each value fills whole words
        self._layout = np.dtype(
            {
                "names": [f"f{k}" for k in range(len(kinds))],
                "formats": [kind.newbyteorder(">") for kind in kinds],
                "offsets": starts[:-1].tolist(),
                "itemsize": int(starts[-1]),
            }
        )
        self._file = path.open("r+b")

    @classmethod
    def reopen(cls, path: Path, columns: Sequence[Column], header: int, rows: int) -> ResultsFile:
        """Return a file to go on with after its first `rows` rows; what came after them is cut off.

        Parameters
        ----------
        columns : the signals after time
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

    def append(self, time: NDArray[np.float64], rows: NDArray[np.float64]) -> None:
        """Append rows: times (n,) [s] and values (n, columns) as `Column.values` reads them."""
        records = np.zeros(time.size, self._layout)
        records["f0"] = time
        for place, column in enumerate(self._columns):
            records[f"f{place + 1}"] = column.values(rows, place)
        self._file.seek(0, 2)
        self._file.write(records.tobytes())
        self._file.flush()
        self.rows += time.size
        self._count()

    def _count(self) -> None:
        """Write the number of rows into the header."""
        self._file.seek(0)
        form = ">q" if self._file.read(4)[3] == 5 else ">i"
        self._file.seek(_COUNT_POSITION)
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


def _records_begin(path: Path) -> int:
    """Return where the first record of a new file begins [bytes].

    The library leaves a file with a header above 8 kB longer than that. A variable's entry in the header ends with its
    attributes, its type, the size of one record and the place of the first; `time` is the first variable.
    """
    header = path.read_bytes()
    after = header.find(_TIME.encode()) + 4 * -(-len(_TIME) // 4)
    kind, size, begin = struct.unpack_from(">iqq" if header[3] == 5 else ">iiq", header, after)
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
        with path.open("rb") as file:
            engine = "netcdf4" if file.read(4)[3:] == b"\x05" else "scipy"  # this maps the file: faster by column
        data = xr.open_dataset(path, engine=engine, decode_times=False)
    except (OSError, ValueError, TypeError, IndexError) as error:
        raise InputError(_unreadable(path, error)) from None
    if "time" not in data.dims:
        raise InputError(f"{path}: holds no time axis, so it is not a results file of curvesqueal")
    return data


def _unreadable(path: Path, error: Exception) -> str:
    """Return the sentence that says why a file cannot be opened: cut short, or no results file at all."""
    try:
        with netCDF4.Dataset(path) as data:
            rows = data.dimensions["time"].size
            row = sum(-(-v.dtype.itemsize // 4) * 4 for v in data.variables.values())
        begin = _records_begin(path)
    except (OSError, KeyError, RuntimeError, struct.error):
        return f"{path}: is not a results file: {str(error).splitlines()[0]}"
    there = max(0, path.stat().st_size - begin) // row
    return f"{path}: is cut short: its header says {rows} rows, {there} are there; copy it again or run again"
