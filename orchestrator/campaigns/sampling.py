"""The points of a plan: factors and a method in, one column of values per factor out."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite, prod
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from ..errors import InputError
from .factors import SEED, Column, Factor, Listed, Value, Whole
from .plan import MOST_RUNS, Plan

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Points:
    """Where a campaign computes.

    Attributes
    ----------
    columns : (n,) values by factor
    """

    columns: Mapping[str, Column]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(next(iter(self.columns.values())))

    def __getitem__(self, row: int) -> dict[str, Value]:
        """Return the value of each factor at one point."""
        return {name: _plain(column[row]) for name, column in self.columns.items()}


def _plain(value: object) -> Value:
    """Return a value of an array as Python has it."""
    return value.item() if isinstance(value, np.generic) else value  # type: ignore[return-value]


def points(plan: Plan) -> Points:
    """Return the points of a plan, the same ones every time.

    Raises
    ------
    InputError
        For more than `MOST_RUNS` points, or a table that does not fit the factors.
    """
    sample, factors = plan.sample, plan.factors
    if sample.method == "table" and sample.file is not None:
        return _table(sample.file, factors)
    if sample.method == "grid":
        return _grid(factors)
    count = (sample.n or 0) * (len(factors) + 2 if sample.method == "saltelli" else 1)
    _limit(count)
    unit = _unit(sample.method, len(factors), sample.n or 0, sample.seed)
    return Points({name: factor.at(u) for (name, factor), u in zip(factors.items(), unit.T, strict=True)})


def _limit(count: int) -> None:
    if count > MOST_RUNS:
        raise InputError(f"the plan has {count:,} runs; at most {MOST_RUNS:,} are allowed")


def _grid(factors: Mapping[str, Factor]) -> Points:
    """Return all combinations, the last factor fastest."""
    levels = [factor.levels() for factor in factors.values()]
    known = [level for level in levels if level is not None]
    _limit(prod(len(level) for level in known))
    mesh = np.meshgrid(*known, indexing="ij")
    return Points({name: each.ravel() for name, each in zip(factors, mesh, strict=True)})


def _unit(method: str, d: int, n: int, seed: int) -> Real:
    """Return points in the unit cube, (count, d).

    Notes
    -----
    Saltelli's scheme: two independent samples A and B of n points each, and for each factor A with its column taken
    from B; the order is A, B, AB_1 ... AB_d.
    """
    random = np.random.default_rng(seed)
    if method == "latin":
        return np.asarray(qmc.LatinHypercube(d, rng=random).random(n))
    if method == "sobol":
        return _sobol(d, n, random)
    both = _sobol(2 * d, n, random)
    A, B = both[:, :d], both[:, d:]
    mixed = [np.where(np.arange(d) == k, B, A) for k in range(d)]
    return np.vstack([A, B, *mixed])


def _sobol(d: int, n: int, random: np.random.Generator) -> Real:
    """Return the first n points of a scrambled Sobol sequence."""
    exponent = max(0, int(np.ceil(np.log2(n))))
    return np.asarray(qmc.Sobol(d, rng=random).random_base2(exponent)[:n])


def _table(file: Path, factors: Mapping[str, Factor]) -> Points:
    """Return the points of a CSV file with one column per factor."""
    with file.open(newline="", encoding="utf-8") as stream:
        rows = list(csv.reader(stream))
    heading = [name.strip() for name in rows[0]] if rows else []
    if sorted(heading) != sorted(factors):
        raise InputError(f"{file}: has the columns {', '.join(heading) or 'none'}; wanted are {', '.join(factors)}")
    if len(rows) < 2:
        raise InputError(f"{file}: has no points")
    _limit(len(rows) - 1)
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(heading):
            raise InputError(f"{file}, line {number}: has {len(row)} values; wanted are {len(heading)}")
    places = {name: heading.index(name) for name in factors}
    texts = {name: [row[k].strip() for row in rows[1:]] for name, k in places.items()}
    return Points({name: _column(file, name, factor, texts[name]) for name, factor in factors.items()})


def _column(file: Path, name: str, factor: Factor, texts: list[str]) -> Column:
    """Return a column of a table as the factor has its values."""
    if isinstance(factor, Listed) and isinstance(factor.values[0], str):
        for number, text in enumerate(texts, 2):
            if text not in factor.values:
                raise InputError(f"{file}, line {number}: {name} = {text}: is not in the list of the plan")
        return np.array(texts, dtype=object)
    numbers = []
    for number, text in enumerate(texts, 2):
        try:
            value = float(text)
        except ValueError:
            value = float("nan")
        if not isfinite(value):
            raise InputError(f"{file}, line {number}: {name} = {text}: must be a finite number")
        numbers.append(value)
    whole = name == SEED or isinstance(factor, Whole)
    if whole and not all(v.is_integer() and v >= 0 for v in numbers):
        raise InputError(f"{file}: {name} must be whole numbers >= 0")
    return np.array(numbers, dtype=int if whole else float)
