"""What a modal fit is made of: functions over their lines, and modes over their directions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .function import Complex, Real
from .resonance import modal

Pair = tuple[int, int]

LEAST_NOISE = 2e-3
"""Noise below which the data are not weighted further: no modal model is nearer."""

_LEAST_CROSS = 1e-3
"""A cross function over the geometric mean of its point functions below which it is lost in their noise."""


@dataclass(frozen=True)
class Functions:
    """Receptances of one contact point over one set of frequencies.

    Attributes
    ----------
    omega : (m,) increasing angular frequencies [rad/s]
    pairs : (row, column) of each function, row <= column, as indices of directions
    values : (p, m) complex receptances
    noise : (p, m) standard deviation over magnitude
    """

    omega: Real
    pairs: tuple[Pair, ...]
    values: Complex
    noise: Real

    @property
    def weight(self) -> Real:
        """Return one over the standard deviation of each value, (p, m).

        A cross function far below its two point functions is no better known than they are.
        """
        point = {row: np.abs(v) for (row, column), v in zip(self.pairs, self.values, strict=True) if row == column}
        size = np.abs(self.values)
        for i, (row, column) in enumerate(self.pairs):
            if row in point and column in point:
                size[i] = np.maximum(size[i], _LEAST_CROSS * np.sqrt(point[row] * point[column]))
        return np.asarray(1.0 / (size * np.maximum(self.noise, LEAST_NOISE)))

    def of(self, directions: list[int]) -> Functions:
        """Return the functions between some directions, which count from 0 then."""
        kept = [i for i, pair in enumerate(self.pairs) if set(pair) <= set(directions)]
        pairs = tuple((directions.index(self.pairs[i][0]), directions.index(self.pairs[i][1])) for i in kept)
        return Functions(self.omega, pairs, self.values[kept], self.noise[kept])

    def on(self, lines: NDArray[np.int64]) -> Functions:
        """Return the functions on some lines."""
        return Functions(self.omega[lines], self.pairs, self.values[:, lines], self.noise[:, lines])


@dataclass(frozen=True)
class Fit:
    """Modes over some directions.

    Attributes
    ----------
    omega, zeta : (n,) natural angular frequencies [rad/s] and damping ratios
    shape : (n, d) mass-normalised amplitudes
    inside : (n,) whether the mode lies in the band; the others stand for all that is below or above
    """

    omega: Real
    zeta: Real
    shape: Real
    inside: NDArray[np.bool_]

    def fitted(self, functions: Functions) -> Complex:
        """Return the functions of these modes, (p, m)."""
        rows, columns = np.array(functions.pairs).T
        products = self.shape[:, rows] * self.shape[:, columns]
        return np.asarray(products.T @ modal(functions.omega, self.omega, self.zeta))

    def rest(self, functions: Functions) -> Complex:
        """Return what is left of each function over its standard deviation, (p, m)."""
        return np.asarray((functions.values - self.fitted(functions)) * functions.weight)

    def keep(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> Fit:
        """Return some of the modes."""
        return Fit(self.omega[kept], self.zeta[kept], self.shape[kept], self.inside[kept])

    def joined(self, other: Fit) -> Fit:
        """Return the modes of both by frequency."""
        both = Fit(
            np.concatenate([self.omega, other.omega]),
            np.concatenate([self.zeta, other.zeta]),
            np.concatenate([self.shape, other.shape]),
            np.concatenate([self.inside, other.inside]),
        )
        return both.keep(np.argsort(both.omega, kind="stable"))
