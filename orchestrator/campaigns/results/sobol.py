"""Sobol indices of a campaign that was sampled for them: a store's dataset in, indices with intervals out."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import sobol_indices

from ...errors import InputError
from ..rows import DONE
from .maps import quantity

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

CONFIDENCE = 0.95
RESAMPLES = 999


@dataclass(frozen=True)
class Index:
    """What one factor has to do with the variance of a quantity.

    Attributes
    ----------
    factor : its name
    first, total : first-order and total index [-]
    first_low, first_high, total_low, total_high : 95 % bootstrap intervals
    """

    factor: str
    first: float
    first_low: float
    first_high: float
    total: float
    total_low: float
    total_high: float

    def as_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


def indices(data: xr.Dataset, name: str, seed: int = 0) -> list[Index]:
    """Return the Sobol indices of a quantity of a store.

    Parameters
    ----------
    name : of the quantity, or 'probability'
    seed : of the bootstrap

    Raises
    ------
    InputError
        If the campaign was not sampled by the method saltelli, or runs are missing.
    """
    plan = json.loads(data.attrs["plan"])
    factors = [str(factor) for factor in data.attrs["factors"]]
    if plan.get("sample", {}).get("method") != "saltelli":
        raise InputError('Sobol indices need [sample] method = "saltelli"')
    values, _, _ = quantity(data, name)
    missing = int(((data["status"].to_numpy() != DONE) | ~np.isfinite(values)).sum())
    if missing:
        raise InputError(f"Sobol indices of {name} need every run; {missing} of {len(values)} have no number")
    return of_values(values.reshape(len(factors) + 2, -1), factors, seed)


def of_values(values: NDArray[np.float64], factors: list[str], seed: int = 0) -> list[Index]:
    """Return the indices of values in Saltelli's order.

    Parameters
    ----------
    values : (d + 2, n) at A, B and AB_1 to AB_d
    factors : (d,) names
    """
    if np.ptp(values) == 0:
        raise InputError("the quantity is the same in every run, so no factor has a share in its variance")
    blocks = {"f_A": values[None, 0], "f_B": values[None, 1], "f_AB": values[2:, None]}
    found = sobol_indices(func=blocks, n=values.shape[1], rng=np.random.default_rng(seed))
    spread = found.bootstrap(confidence_level=CONFIDENCE, n_resamples=RESAMPLES)
    first, total = spread.first_order.confidence_interval, spread.total_order.confidence_interval
    columns = (found.first_order, first.low, first.high, found.total_order, total.low, total.high)
    table = np.array([np.ravel(column) for column in columns]).T
    return [Index(factor, *(float(v) for v in row)) for factor, row in zip(factors, table, strict=True)]
