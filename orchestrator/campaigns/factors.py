"""What a plan varies: one entry of its table [vary] in, the values that the factor can take out.

A factor turns a number u between 0 and 1 into a value, so that every sampling method treats all factors alike; those
with levels can make a grid, too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ..errors import InputError

Value = float | int | bool | str
Column = NDArray[Any]

SEED = "seed"
START_HZ = "start_hz"


class Factor(Protocol):
    """Something that varies."""

    def levels(self) -> Column | None:
        """Return the values of a grid; None for a distribution without a number of levels."""

    def at(self, u: NDArray[np.float64]) -> Column:
        """Return the values whose cumulative probability is u."""


@dataclass(frozen=True)
class Listed:
    """A list of values, all alike probable.

    Attributes
    ----------
    values : numbers or texts
    """

    values: tuple[Value, ...]

    def levels(self) -> Column:
        """Return the values."""
        kind = object if any(isinstance(v, str) for v in self.values) else None
        return np.array(self.values, dtype=kind)

    def at(self, u: NDArray[np.float64]) -> Column:
        """Return the value in whose share of the interval from 0 to 1 each u lies."""
        n = len(self.values)
        return np.asarray(self.levels()[np.minimum((u * n).astype(int), n - 1)])


@dataclass(frozen=True)
class Whole:
    """All whole numbers of a range, such as seeds."""

    low: int
    high: int

    def levels(self) -> Column:
        """Return the numbers."""
        return np.arange(self.low, self.high + 1)

    def at(self, u: NDArray[np.float64]) -> Column:
        """Return the number in whose share of the interval from 0 to 1 each u lies."""
        n = self.high - self.low + 1
        return np.asarray(self.low + np.minimum((u * n).astype(int), n - 1))


@dataclass(frozen=True)
class Range:
    """An interval, in equal steps or, with `log`, in equal ratios.

    Attributes
    ----------
    n : number of levels of a grid, both ends among them; None: not for a grid
    """

    low: float
    high: float
    n: int | None
    log: bool = False

    def levels(self) -> Column | None:
        """Return the levels."""
        return None if self.n is None else self.at(np.linspace(0.0, 1.0, self.n) if self.n > 1 else np.zeros(1))

    def at(self, u: NDArray[np.float64]) -> Column:
        """Return the value at the part u of the interval."""
        if self.log:
            return np.asarray(self.low * (self.high / self.low) ** u)
        return np.asarray(self.low * (1 - u) + self.high * u)


@dataclass(frozen=True)
class Distributed:
    """A random number.

    Attributes
    ----------
    kind : name of the distribution
    law : of scipy.stats, frozen
    """

    kind: str
    law: Any

    def levels(self) -> None:
        """Return None: a distribution has no levels."""

    def at(self, u: NDArray[np.float64]) -> Column:
        """Return the quantiles."""
        return np.asarray(self.law.ppf(u))


LAWS: Mapping[str, tuple[str, ...]] = {
    "uniform": ("from", "to"),
    "normal": ("mean", "std"),
    "lognormal": ("median", "sigma"),
    "truncated_normal": ("mean", "std", "from", "to"),
    "triangular": ("from", "mode", "to"),
}
"""Distributions and the numbers that each needs; `sigma` is the standard deviation of the logarithm."""


def read_factor(name: str, entry: object) -> Factor:
    """Return the factor of an entry of [vary]: a list, a range, a distribution.

    Raises
    ------
    InputError
        For an entry that is none of these, an empty list or range, or numbers that make no distribution.
    """
    where = f"[vary] {name}"
    if isinstance(entry, list):
        return _listed(where, entry)
    if not isinstance(entry, dict):
        raise InputError(f"{where} = {entry}: must be a list, a range {{ from, to, n }} or a {{ distribution, ... }}")
    if "values" in entry:
        _only(where, entry, {"values"})
        return _listed(where, entry["values"])
    if "distribution" in entry:
        return _distributed(where, entry)
    _only(where, entry, {"from", "to", "n", "spacing"})
    low, high = _number(where, entry, "from"), _number(where, entry, "to")
    if high < low:
        raise InputError(f"{where}: is empty, from {low:g} to {high:g}")
    if name == SEED:
        return _seeds(where, entry, low, high)
    n = entry.get("n")
    if n is not None and (not isinstance(n, int) or isinstance(n, bool) or n < 1):
        raise InputError(f"{where}: n = {n}: must be a whole number >= 1")
    spacing = entry.get("spacing", "linear")
    if spacing not in ("linear", "log"):
        raise InputError(f"{where}: spacing = {spacing}: must be linear or log")
    if spacing == "log" and low <= 0:
        raise InputError(f"{where}: from = {low:g}: must be > 0 for spacing log")
    return Range(low, high, n, spacing == "log")


def _seeds(where: str, entry: Mapping[str, Any], low: float, high: float) -> Whole:
    if not (low.is_integer() and high.is_integer() and low >= 0) or "n" in entry or "spacing" in entry:
        raise InputError(f"{where}: a range of seeds is {{ from, to }} in whole numbers >= 0")
    return Whole(int(low), int(high))


def _listed(where: str, values: Any) -> Listed:
    if not isinstance(values, list) or not values:
        raise InputError(f"{where}: is empty; give at least one value")
    if len(set(map(str, values))) < len(values):
        raise InputError(f"{where}: has a value twice")
    for value in values:
        if not isinstance(value, float | int | str) or (isinstance(value, float) and not isfinite(value)):
            raise InputError(f"{where}: {value} is neither a finite number nor a text")
    if len({isinstance(v, str) for v in values}) > 1:
        raise InputError(f"{where}: numbers and texts in one list")
    return Listed(tuple(values))


def _distributed(where: str, entry: Mapping[str, Any]) -> Distributed:
    kind = entry["distribution"]
    if kind not in LAWS:
        raise InputError(f"{where}: distribution = {kind}: must be one of {', '.join(LAWS)}")
    _only(where, entry, {"distribution", *LAWS[kind]})
    p = {key: _number(where, entry, key) for key in LAWS[kind]}
    positive = {"std", "sigma", "median"} & p.keys()
    for key in sorted(positive):
        if p[key] <= 0:
            raise InputError(f"{where}: {key} = {p[key]:g}: must be > 0")
    if ("to" in p and not p["from"] <= p.get("mode", p["from"]) <= p["to"]) or p.get("from") == p.get("to", np.nan):
        raise InputError(f"{where}: is empty, from {p['from']:g} to {p['to']:g}")
    return Distributed(kind, _law(kind, p))


def _law(kind: str, p: Mapping[str, float]) -> Any:
    """Return the distribution of scipy.stats."""
    if kind == "uniform":
        return stats.uniform(p["from"], p["to"] - p["from"])
    if kind == "normal":
        return stats.norm(p["mean"], p["std"])
    if kind == "lognormal":
        return stats.lognorm(p["sigma"], scale=p["median"])
    if kind == "truncated_normal":
        ends = [(p[key] - p["mean"]) / p["std"] for key in ("from", "to")]
        return stats.truncnorm(*ends, loc=p["mean"], scale=p["std"])
    width = p["to"] - p["from"]
    return stats.triang((p["mode"] - p["from"]) / width, loc=p["from"], scale=width)


def _number(where: str, entry: Mapping[str, Any], key: str) -> float:
    value = entry.get(key)
    if not isinstance(value, float | int) or isinstance(value, bool) or not isfinite(value):
        got = "nothing" if value is None else value
        raise InputError(f"{where}: {key} must be a finite number, got {got}")
    return float(value)


def _only(where: str, entry: Mapping[str, Any], known: set[str]) -> None:
    """Raise InputError for a key that means nothing."""
    unknown = sorted(entry.keys() - known)
    if unknown:
        raise InputError(f"{where}: {unknown[0]} means nothing here; known are {', '.join(sorted(known))}")
