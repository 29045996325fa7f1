"""Rows of a store as a table: a Zarr store in, a Parquet file out."""

from __future__ import annotations

from pathlib import Path

from ...results.formats import require_parquet
from ..store import open_campaign


def write_rows(store: Path, path: Path) -> None:
    """Write one row per run; quantities with several places get a column for each.

    Raises
    ------
    InputError
        If the store is none, or the library that writes Parquet is not installed.
    """
    require_parquet()
    import pyarrow as pa  # noqa: PLC0415 - an optional dependency
    from pyarrow import parquet  # noqa: PLC0415

    data = open_campaign(store)
    columns, fields = [], []
    for name in sorted({*map(str, data.coords), *map(str, data.data_vars)}):
        values = data[name].to_numpy()
        about = {key: str(value) for key, value in data[name].attrs.items()}
        parts = {name: values} if values.ndim == 1 else {f"{name}.{k}": values[:, k] for k in range(values.shape[1])}
        for key, part in parts.items():
            array = pa.array(part.tolist() if part.dtype.kind in "OTU" else part)
            columns.append(array)
            fields.append(pa.field(key, array.type, metadata=about))
    about = {key: str(value) for key, value in data.attrs.items()}
    path.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pa.table(columns, schema=pa.schema(fields, metadata=about)), path)
