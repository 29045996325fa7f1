"""Results files, whole or damaged, in; datasets out. A damaged one is read up to its last whole row, with a warning."""

from __future__ import annotations

import io
import mmap
import os
import struct
import warnings
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4
import numpy as np

from ..errors import DamageWarning, InputError
from .layout import CHECKSUM, COUNT_POSITION, HEADER_CHECKSUM, header_checksum, records_begin, whole_rows

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

_LARGEST_HEADER = 64 << 20
"""Where a header is looked for [bytes]."""


@dataclass(frozen=True)
class Extent:
    """What a file has.

    Attributes
    ----------
    begin : size of its header [bytes]
    row : size of a row [bytes]
    count : number of rows that the header says
    whole : number of rows from the first on that agree with their checksums
    """

    begin: int
    row: int
    count: int
    whole: int


def extent(path: Path) -> Extent | None:
    """Return what a results file has, checked against its checksums; None for a file without checksums.

    Raises
    ------
    InputError
        If the header is damaged.
    OSError
        If the file cannot be read.
    """
    known = path.stat()
    return _extent(path.absolute(), known.st_size, known.st_mtime_ns)


@lru_cache(16)
def _extent(path: Path, size: int, _changed: int) -> Extent | None:
    if size < 32:
        return None
    with path.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        ours = any(data.find(name.encode(), 0, _LARGEST_HEADER) >= 0 for name in (HEADER_CHECKSUM, CHECKSUM))
        if data[:3] != b"CDF" or not ours:
            return None
        try:
            begin = records_begin(data[: min(_LARGEST_HEADER, size)], path)
            if begin > size:
                raise InputError(f"{path}: is cut short in its header, so that nothing of it can be read")
            header = data[:begin]
            found = header_checksum(header)
            if found is None or header[found[0] : found[0] + len(found[1])] != found[1].encode():
                raise InputError(f"{path}: its header is damaged, so that its rows cannot be read")
            with netCDF4.Dataset(path) as known:
                row = sum(-(-v.dtype.itemsize // 4) * 4 for v in known.variables.values())
        except (RuntimeError, OSError, struct.error):
            raise InputError(f"{path}: its header is damaged, so that its rows cannot be read") from None
        (count,) = struct.unpack_from(">q" if header[3] == 5 else ">i", header, COUNT_POSITION)
        with memoryview(data) as view, view[begin:] as records:
            return Extent(begin, row, count, whole_rows(records, row))


def open_results(path: Path) -> xr.Dataset:
    """Return the results in a file, loaded lazily; of a damaged file what comes before the damage, with a warning.

    Raises
    ------
    InputError
        If the file is missing or holds no results.

    Warns
    -----
    DamageWarning
        If rows are missing or damaged.
    """
    import xarray as xr  # noqa: PLC0415

    if not path.is_file():
        raise InputError(f"{path}: no such results file")
    try:
        there = extent(path)
        with path.open("rb") as file:
            wide = file.read(4)[3:] == b"\x05"
        engine: Any = "netcdf4" if wide else "scipy"  # this maps the file: faster by column
        source: Any = path
        if there is not None and there.whole != there.count:
            source = _whole_part(path, there, wide)
            engine = None if wide else "scipy"
        data = xr.open_dataset(source, engine=engine, decode_times=False, drop_variables=[CHECKSUM])
    except InputError:
        raise
    except (OSError, ValueError, TypeError, IndexError, KeyError, OverflowError, MemoryError, AttributeError) as error:
        raise InputError(_unreadable(path, error)) from None
    if "time" not in data.dims:
        raise InputError(f"{path}: holds no time axis, so it is not a results file of curvesqueal")
    data.attrs.pop(HEADER_CHECKSUM, None)
    if there is not None and there.whole < there.count:
        until = f" to t = {float(data['time'][-1]):.9g} s" if there.whole else ""
        warnings.warn(
            f"{path}: is cut short or damaged: its header says {there.count} rows, the first {there.whole}{until} are "
            "whole; the rest is left out",
            DamageWarning,
            stacklevel=2,
        )
    return data


def _whole_part(path: Path, there: Extent, wide: bool) -> Any:
    """Return what xarray opens for a file whose header does not say how many whole rows there are."""
    import xarray as xr  # noqa: PLC0415

    with path.open("rb") as file:
        data = bytearray(file.read(there.begin + there.whole * there.row))
    struct.pack_into(">q" if wide else ">i", data, COUNT_POSITION, there.whole)
    if not wide:
        return io.BytesIO(bytes(data))
    store: Any = xr.backends.NetCDF4DataStore
    return store(netCDF4.Dataset(os.fspath(path), memory=bytes(data)))


def _unreadable(path: Path, error: Exception) -> str:
    """Return the sentence that says why a file without checksums cannot be opened."""
    said = (str(error).splitlines() or [type(error).__name__])[0]
    return f"{path}: is not a results file, or a damaged one: {said}"


def named(data: xr.Dataset) -> dict[str, str]:
    """Return the names of signals as their FMUs have them, by the names that the file has them under."""
    return {str(name): str(column.attrs.get("variable", name)) for name, column in data.data_vars.items()}


def attributes_of(path: Path) -> dict[str, Any]:
    """Return what a results file says of itself, and its columns' names and types under `columns`."""
    with netCDF4.Dataset(path) as data:
        columns = [(name, np.dtype(v.dtype).str[1:]) for name, v in data.variables.items()]
        return {**{name: data.getncattr(name) for name in data.ncattrs()}, "columns": columns}
