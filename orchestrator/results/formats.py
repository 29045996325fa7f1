"""Results as CSV and Parquet: a dataset in, a file out."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr


def write_csv(data: xr.Dataset, path: Path, rows_at_once: int = 50_000) -> None:
    """Write results as CSV: a header with name and unit, then a line per row; the shortest exact decimals."""
    names = ["time", *data.data_vars]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow([f"{name} [{data[name].attrs.get('units', '')}]" for name in names])
        for part in _parts(data, rows_at_once):
            writer.writerows(zip(*(_texts(part[name].to_numpy()) for name in names), strict=True))


def _texts(values: NDArray[Any]) -> list[Any]:
    """Return values as a CSV file has them."""
    if values.dtype.kind == "b":
        return list(np.where(values, "true", "false"))
    if values.dtype == np.float32:
        return list(values.astype(str))  # shortest for a single
    return list(values.tolist())


def _parts(data: xr.Dataset, rows: int) -> Iterator[xr.Dataset]:
    for begin in range(0, data.sizes["time"], rows):
        yield data.isel(time=slice(begin, begin + rows)).load()


def require_parquet() -> None:
    """Raise InputError if the library that writes Parquet is not installed."""
    if find_spec("pyarrow") is None:
        raise InputError("Parquet needs the package pyarrow: pip install 'curvesqueal[parquet]'")


def write_parquet(data: xr.Dataset, path: Path, rows_at_once: int = 50_000) -> None:
    """Write results as Parquet: one column per signal, units and descriptions as metadata of the columns.

    Raises
    ------
    InputError
        If the library pyarrow is not installed.
    """
    require_parquet()
    import pyarrow as pa  # noqa: PLC0415 - an optional dependency
    from pyarrow.parquet import ParquetWriter  # noqa: PLC0415

    names = ["time", *map(str, data.data_vars)]
    about = {"unit": "units", "description": "long_name"}
    schema = pa.schema(
        [
            pa.field(
                name,
                pa.from_numpy_dtype(data[name].dtype.newbyteorder("=")),
                metadata={key: str(data[name].attrs.get(attribute, "")) for key, attribute in about.items()},
            )
            for name in names
        ],
        metadata={key: str(value) for key, value in data.attrs.items()},
    )
    with ParquetWriter(path, schema) as writer:
        for part in _parts(data, rows_at_once):
            columns = [part[name].to_numpy().astype(part[name].dtype.newbyteorder("=")) for name in names]
            writer.write_table(pa.table(columns, schema=schema))
