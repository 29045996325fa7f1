"""Maps of a campaign: a store's dataset and two factors in, one value per cell out. No files, no drawing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

from ...errors import InputError
from ...signals.tones import Tone, tones_of_runs
from ..rows import DONE

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

Real = NDArray[np.float64]

PROBABILITY = "probability"
CONFIDENCE = 0.95

_MOST_LEVELS = 400
_BINS = 12
"""Cells along an axis that was sampled at random, so that each has several runs."""


@dataclass(frozen=True)
class Axis:
    """One axis of a map.

    Attributes
    ----------
    name : of the factor
    values : (n,) levels, or the middles of bins
    binned : whether the runs of a cell lie about its value, not at it
    texts : names of the levels of a factor that is no number
    """

    name: str
    values: Real
    binned: bool
    texts: tuple[str, ...] = ()


@dataclass(frozen=True)
class Map:
    """A quantity over two factors.

    Attributes
    ----------
    x, y : axes
    name, unit, words : of the quantity
    value : (y, x) of each cell, the median of its runs; a probability is their share; NaN without runs
    low, high : (y, x) 95 % confidence interval of a probability (Clopper and Pearson); None for others
    runs : (y, x) number of runs that count
    """

    x: Axis
    y: Axis
    name: str
    unit: str
    words: str
    value: Real
    low: Real | None
    high: Real | None
    runs: NDArray[np.int64]

    def as_json(self) -> dict[str, Any]:
        """Return it as plain data; None where there are no runs."""
        data: dict[str, Any] = {"colour": self.name, "unit": self.unit, "description": self.words}
        for key, axis in (("x", self.x), ("y", self.y)):
            data[key] = {"name": axis.name, "values": list(axis.texts) or axis.values.tolist(), "binned": axis.binned}
        for key in ("value", "low", "high"):
            table = getattr(self, key)
            if table is not None:
                data[key] = [[float(v) if np.isfinite(v) else None for v in row] for row in table]
        data["runs"] = self.runs.tolist()
        return data


def make_map(data: xr.Dataset, x: str, y: str, colour: str) -> Map:
    """Return the map of a quantity.

    Parameters
    ----------
    x, y : names of factors
    colour : name of a quantity of the store, or 'probability' of squeal

    Raises
    ------
    InputError
        For a name that is not in the store, or no finished run.
    """
    factors = [str(name) for name in data.attrs["factors"]]
    for name in (x, y):
        if name not in factors:
            raise InputError(f"{name}: the campaign does not vary it; it varies {', '.join(factors)}")
    if x == y:
        raise InputError(f"{x}: the two axes of a map must differ")
    values, unit, words = quantity(data, colour)
    done = data["status"].to_numpy() == DONE
    if not done.any():
        raise InputError("the store holds no finished run yet")
    axes, places = zip(*(_axis(data, name) for name in (x, y)), strict=True)
    shape = (len(axes[1].values), len(axes[0].values))
    cell = np.ravel_multi_index((places[1], places[0]), shape)
    keep = done & np.isfinite(values)
    table, low, high = _cells(values[keep], cell[keep], shape, colour == PROBABILITY)
    runs = np.bincount(cell[keep], minlength=shape[0] * shape[1]).reshape(shape)
    return Map(axes[0], axes[1], colour, unit, words, table, low, high, runs)


def quantity(data: xr.Dataset, name: str) -> tuple[Real, str, str]:
    """Return the values, unit and words of a quantity of a store; squeal as 1 or 0 for the probability.

    Raises
    ------
    InputError
        If the store has no such numbers.
    """
    if name == PROBABILITY:
        return _squeals(data), "1", "probability of squeal"
    numbers = [str(n) for n in data.data_vars if data[n].dims == ("run",) and data[n].dtype.kind == "f"]
    if name not in numbers:
        known = ", ".join(sorted({*numbers, PROBABILITY} - {"seconds"}))
        raise InputError(f"{name}: the store has no such quantity; it has {known}")
    about = data[name].attrs
    return data[name].to_numpy().astype(float), str(about.get("units", "")), str(about.get("long_name", name))


def _squeals(data: xr.Dataset) -> Real:
    """Return 1 for runs that squeal, 0 for others; the last stage that a run came to decides."""
    squeals = np.full(data.sizes["run"], np.nan)
    for name in ("growth_rate", "squeals"):
        if name in data:
            own = data[name].to_numpy().astype(float)
            squeals = np.where(np.isfinite(own), (own > 0).astype(float), squeals)
    return squeals


def _axis(data: xr.Dataset, name: str) -> tuple[Axis, NDArray[np.int64]]:
    """Return the axis of a factor and the place of each run on it."""
    column = data[name].to_numpy()
    if column.dtype.kind in "OTUS":
        texts, place = np.unique(column.astype(str), return_inverse=True)
        return Axis(name, np.arange(len(texts), dtype=float), False, tuple(texts.tolist())), place
    levels, place = np.unique(column.astype(float), return_inverse=True)
    if len(levels) <= min(_MOST_LEVELS, max(_BINS, len(column) // 2)):
        return Axis(name, levels, False), place
    edges = np.linspace(levels[0], levels[-1], _BINS + 1)
    place = np.clip(np.searchsorted(edges, column, side="right") - 1, 0, _BINS - 1)
    return Axis(name, (edges[1:] + edges[:-1]) / 2, True), place


def _cells(
    values: Real, cell: NDArray[np.int64], shape: tuple[int, int], share: bool
) -> tuple[Real, Real | None, Real | None]:
    """Return the median of each cell, or share and confidence interval."""
    tables = np.full((3, shape[0] * shape[1]), np.nan)
    order = np.argsort(cell, kind="stable")
    found, begin = np.unique(cell[order], return_index=True)
    for k, part in zip(found, np.split(values[order], begin[1:]), strict=True):
        if share:
            interval = binomtest(int(part.sum()), len(part)).proportion_ci(CONFIDENCE, method="exact")
            tables[:, k] = part.mean(), interval.low, interval.high
        else:
            tables[0, k] = np.median(part)
    value, low, high = tables.reshape(3, *shape)
    return (value, low, high) if share else (value, None, None)


def ended_tones(data: xr.Dataset) -> list[Tone]:
    """Return how often each tone came out of the finished runs, with confidence intervals.

    Raises
    ------
    InputError
        If the campaign has no tones, or no finished run.
    """
    if "tone" not in data:
        raise InputError('tone: the store has none; give [compute] stage = "time"')
    done = data["status"].to_numpy() == DONE
    if not done.any():
        raise InputError("the store holds no finished run yet")
    found = data["tone"].to_numpy()
    irregular = data["irregular"].to_numpy() if "irregular" in data else np.zeros(len(found))
    return tones_of_runs(found[done], irregular[done])
