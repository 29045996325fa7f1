"""Results as plain arrays: what the summary of a run needs, without xarray, whose import takes longer than a short run.

It has the part of `xarray.Dataset` that the signals use, so that they take either.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray

from .layout import CHECKSUM, HEADER_CHECKSUM, record_layout
from .reading import extent


@dataclass(frozen=True)
class Samples(Mapping[str, NDArray[Any]]):
    """The rows of a results file.

    Attributes
    ----------
    columns : (rows,) by name, the time included
    attrs : what the file says of itself
    encoding : `source`, the file
    """

    columns: Mapping[str, NDArray[Any]]
    attrs: Mapping[str, Any]
    encoding: Mapping[str, Any]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the values of a column."""
        return self.columns[name]

    def __iter__(self) -> Iterator[str]:
        """Return the names of the columns, one after the other."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self.columns)

    @property
    def sizes(self) -> Mapping[str, int]:
        """Number of rows, under the name of their dimension."""
        return {"time": len(self.columns["time"])}

    def isel(self, time: slice) -> Samples:
        """Return some of the rows."""
        return Samples({name: values[time] for name, values in self.columns.items()}, self.attrs, self.encoding)


def read_samples(path: Path) -> Samples:
    """Return the whole rows of a file that `ResultsFile` wrote; the values are read when they are used.

    Raises
    ------
    InputError
        If its header is damaged.
    ValueError
        If it is not such a file.
    """
    there = extent(path)
    if there is None:
        raise ValueError(f"{path}: has no checksums, so it was not written here")
    with netCDF4.Dataset(path) as file:
        names = list(file.variables)
        layout = record_layout([variable.dtype for variable in file.variables.values()])
        attributes = {name: file.getncattr(name) for name in file.ncattrs() if name != HEADER_CHECKSUM}
    rows = np.zeros(0, layout)
    if there.whole:  # an empty part of a file cannot be mapped
        rows = np.memmap(path, layout, "r", there.begin, (there.whole,))
    columns = {name: rows[field] for name, field in zip(names, layout.names or (), strict=True) if name != CHECKSUM}
    return Samples(columns, attributes, {"source": str(path)})
