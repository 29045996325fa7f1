"""Where the modes of a fit start from: resonances of point functions, and of what a fit leaves."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.signal import find_peaks

from .function import Complex, Real
from .modal_model import Fit, Functions
from .resonance import one_resonance

LEAST_EFFECT = 25.0
"""What a mode must take from the sum of squares to count: by chance its four unknowns take so much 5 times in 1e5."""

_ABOVE_CHANCE = 1.6
"""The rest over its standard deviation, as an average over ten lines, from which a mode is looked for."""

_SPANS = (40, 160, 640)
"""Lines that a mode is looked for in: sharp ones need few, broad ones many."""

MOST_NEW = 12
"""Modes that one look at the rest finds."""


def peaks(functions: Functions) -> Real:
    """Return the frequencies at which the mobilities of point functions peak."""
    found: list[float] = []
    for (row, column), values, noise in zip(functions.pairs, functions.values, functions.noise, strict=True):
        if row == column:
            level = np.log(np.abs(functions.omega * values))
            peaks, _ = find_peaks(level, prominence=max(0.15, 8 * float(np.median(noise))))
            found += functions.omega[peaks].tolist()
    return _apart(np.array(sorted(found)), functions.omega, 2)


def missed(functions: Functions, fit: Fit) -> Real:
    """Return where the rest peaks above chance, over few lines or many, the largest."""
    square = (np.abs(fit.rest(functions)) ** 2).mean(axis=0)
    found: list[tuple[float, float]] = []
    for lines in _SPANS:
        size = np.sqrt(uniform_filter1d(square, lines // 4 + 1))
        peaks, _ = find_peaks(size, height=1 + (_ABOVE_CHANCE - 1) * (_SPANS[0] / lines) ** 0.5, distance=lines // 2)
        found += [(float(size[i]), float(functions.omega[i])) for i in peaks]
    return np.array([omega for _, omega in sorted(found, reverse=True)[: 10 * MOST_NEW]])


def started(functions: Functions, values: Complex, natural: Real, size: int, most: int = 1000) -> Fit:
    """Return modes near the given frequencies, each from as many lines around it as explain most."""
    w, weight = functions.omega, functions.weight
    fit = Fit(np.zeros(0), np.zeros(0), np.zeros((0, size)), np.zeros(0, dtype=bool))
    for start in natural:
        if fit.omega.size >= most:
            break
        best, largest = None, LEAST_EFFECT
        centre = int(np.searchsorted(w, start))
        for span in _SPANS:
            lines = slice(max(centre - span // 2, 0), min(centre + span // 2, w.size))
            part = Functions(w[lines], functions.pairs, values[:, lines], functions.noise[:, lines])
            zeta = 0.1 * (part.omega[-1] - part.omega[0]) / start
            near = weight[:, lines]
            omega, zeta, residue = one_resonance(part.omega, part.values, near, float(start), zeta)
            found = _split(functions, omega, zeta, residue, size)
            gain = _size(part.values * near) - _size((part.values - found.fitted(part)) * near)
            if gain > largest:
                best, largest = found, float(gain)
        if best is not None:
            values = values - best.fitted(functions)
            fit = fit.joined(best)
    return fit


def _size(values: Complex) -> float:
    """Return the sum of squares."""
    return float((np.abs(values) ** 2).sum())


def _split(functions: Functions, omega: float, zeta: float, residue: Real, size: int) -> Fit:
    """Return the modes that share a pole: one, or of three directions and more two, by the residues' eigenvectors."""
    matrix = np.zeros((size, size))
    for (row, column), amount in zip(functions.pairs, residue, strict=True):
        matrix[row, column] = matrix[column, row] = amount
    scale = _scale(functions, size)
    amounts, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
    kept = [i for i in range(size)[::-1][: 1 if size < 3 else 2] if amounts[i] > 0.02 * amounts[-1] > 0]
    shape = np.array([vectors[:, i] * np.sqrt(amounts[i]) * scale for i in kept]).reshape(-1, size)
    return Fit(np.full(len(kept), omega), np.full(len(kept), zeta), shape, np.ones(len(kept), dtype=bool))


def _apart(natural: Real, w: Real, lines: int) -> Real:
    """Return frequencies, in order, without those that lie within some lines of the one before."""
    kept: list[float] = []
    for value in natural:
        if not kept or np.searchsorted(w, value) - np.searchsorted(w, kept[-1]) > lines:
            kept.append(float(value))
    return np.array(kept)


def _scale(functions: Functions, size: int) -> Real:
    """Return amplitudes of alike weight in every direction."""
    scale = np.ones(size)
    for (row, column), values in zip(functions.pairs, functions.values, strict=True):
        if row == column:
            scale[row] = np.sqrt(np.median(np.abs(functions.omega**2 * values)))
    return scale
