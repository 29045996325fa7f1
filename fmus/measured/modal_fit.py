"""Real modes from measured point and cross functions of a lightly damped structure: receptances in, modes out.

H_jk = sum psi_j psi_k / (omega_i^2 - omega^2 + 2 j zeta_i omega_i omega), fitted in omega, zeta and psi themselves, so
that every mode has a positive modal mass and damping ratio and the result is passive whatever the data. Directions that
no measured function couples are fitted apart: the two families of an axisymmetric wheel. No random starts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from ..errors import DataError
from .function import Real
from .modal_model import Fit, Functions, Pair
from .modal_starts import LEAST_EFFECT, MOST_NEW, missed, peaks, started
from .resonance import modal

_BELOW, _ABOVE = 0.1, 2.5
"""Poles for all that lies below and above the band, in ends of the band."""

_LN_ZETA = (np.log(1e-6), np.log(0.5))
_ROUNDS = 25
_AT_ONCE = 6
"""Modes that are fitted at one time, with their neighbours held."""

_NEAR = 40
"""Lines on each side of a pole that are all used; further away every fourth."""


def coupled(pairs: tuple[Pair, ...]) -> list[list[int]]:
    """Return the groups of directions that functions couple, each in order.

    >>> coupled(((0, 0), (0, 3), (1, 1), (2, 2), (1, 2), (3, 3)))
    [[0, 3], [1, 2]]
    """
    groups: list[set[int]] = []
    for pair in pairs:
        joined = set(pair).union(*(g for g in groups if g & set(pair)))
        groups = [g for g in groups if not g & set(pair)] + [joined]
    return sorted(sorted(group) for group in groups)


def fit_functions(functions: Functions, progress: Callable[[str], None] = lambda _: None) -> Fit:
    """Return the modes over four directions that are nearest to the functions.

    Parameters
    ----------
    progress : called with a few words now and then
    """
    whole = Fit(np.zeros(0), np.zeros(0), np.zeros((0, 4)), np.zeros(0, dtype=bool))
    for group in coupled(functions.pairs):
        with threadpool_limits(1, "blas"):  # matrices of this size are slower on several threads
            found = _fit_group(functions.of(group), len(group), progress)
        shape = np.zeros((found.omega.size, 4))
        shape[:, group] = found.shape
        whole = whole.joined(replace(found, shape=shape))
    return whole


def _fit_group(functions: Functions, size: int, progress: Callable[[str], None]) -> Fit:
    """Return the modes over directions that belong together.

    Notes
    -----
    Modes start where point functions peak, then where the rest peaks, each from the lines around it alone. After each
    round all are fitted again, few at a time with the others held. A round that finds nothing, or modes without effect,
    is the last.
    """
    ends = _ends(functions, size)
    fit = ends.joined(started(functions, functions.values, peaks(functions), size))
    if fit.inside.sum() == 0:
        raise DataError("no resonance in the data; a wheel has some")
    fit = _refined(functions, fit, 4)
    in_vain = 0
    for _ in range(_ROUNDS):
        progress(f"{int(fit.inside.sum())} modes")
        left = functions.values - fit.fitted(functions)
        new = started(functions, left, missed(functions, fit), size, MOST_NEW)
        if not new.omega.size:
            break
        richer = _effective(functions, _refined(functions, fit.joined(new), 4))
        cost, before = _cost(functions, richer), _cost(functions, fit)
        in_vain = in_vain + 1 if cost > 0.99 * before else 0
        fit = richer if cost < before else fit
        if in_vain == 3:
            break
    return _refined(functions, fit, 8)


def _ends(functions: Functions, size: int) -> Fit:
    """Return modes for what lies below and above the band: one in each direction, small."""
    w = functions.omega
    point = {
        pair[0]: values for pair, values in zip(functions.pairs, functions.values, strict=True) if pair[0] == pair[1]
    }
    low = [np.sqrt(abs(point[j][0]) * 0.1) * w[0] if j in point else 0.0 for j in range(size)]
    high = [np.sqrt(np.median(np.abs(point[j])) * 0.01) * w[-1] if j in point else 0.0 for j in range(size)]
    return Fit(
        np.repeat([_BELOW * w[0], _ABOVE * w[-1]], size),
        np.repeat([0.5, 0.05], size),
        np.vstack([np.diag(low), np.diag(high)]),
        np.zeros(2 * size, dtype=bool),
    )


def _cost(functions: Functions, fit: Fit) -> float:
    """Return a sum over the rest in which a line far off counts little more than one a little off."""
    return float(np.log1p(np.abs(fit.rest(functions)) ** 2).sum())


def _refined(functions: Functions, fit: Fit, sweeps: int) -> Fit:
    """Return the modes after fitting all again, few at a time, and the ends."""
    cost = np.inf
    for _ in range(sweeps):
        fit = _with_ends_fitted(functions, fit)
        inside = np.flatnonzero(fit.inside)
        for start in range(0, inside.size, _AT_ONCE // 2):
            chunk = inside[start : start + _AT_ONCE]
            fit = _fitted(functions.on(_lines(functions.omega, fit, chunk)), fit, chunk)
        fit = fit.keep(np.argsort(fit.omega, kind="stable"))
        before, cost = cost, _cost(functions, fit)
        if cost > 0.997 * before:
            break
    return fit


def _with_ends_fitted(functions: Functions, fit: Fit) -> Fit:
    """Return the modes with the amplitudes of those outside the band fitted over all lines, thinly."""
    lines = np.unique(np.searchsorted(functions.omega, np.geomspace(functions.omega[0], functions.omega[-1], 600)))
    return _fitted(functions.on(lines[lines < functions.omega.size]), fit, np.flatnonzero(~fit.inside))


def _lines(w: Real, fit: Fit, chunk: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the lines that some modes are fitted over: half-way to their neighbours, dense near the poles."""
    inside = fit.omega[fit.inside]
    lowest, highest = fit.omega[chunk].min(), fit.omega[chunk].max()
    below, above = inside[inside < lowest], inside[inside > highest]
    low = 0.5 * (below.max() + lowest) if below.size else w[0]
    high = 0.5 * (above.min() + highest) if above.size else w[-1]
    width = 3 * (fit.zeta[chunk] * fit.omega[chunk]).max()
    low, high = min(low, lowest - width), max(high, highest + width)
    centres = np.sort(np.searchsorted(w, fit.omega[chunk]))
    first = min(int(np.searchsorted(w, low)), int(centres[0]) - _NEAR // 4)
    last = max(int(np.searchsorted(w, high)), int(centres[-1]) + _NEAR // 4)
    lines = np.arange(max(first, 0), min(last, w.size))
    distance = np.abs(lines[:, None] - centres).min(axis=1)
    chosen: NDArray[np.int64] = lines[(distance <= _NEAR) | (lines % max(4, lines.size // 400) == 0)]
    return chosen


def _fitted(functions: Functions, fit: Fit, free: NDArray[np.int64]) -> Fit:
    """Return the modes with some of them fitted to the functions; of those outside the band only the shapes."""
    rows, columns = np.array(functions.pairs).T
    moving = fit.keep(free)
    held = fit.keep(np.setdiff1d(np.arange(fit.omega.size), free))
    target = functions.values - held.fitted(functions)
    poles = moving.inside
    n, count = free.size, int(poles.sum())
    scale = np.abs(moving.shape).max(axis=1, keepdims=True) + 1e-30

    def unpacked(x: Real) -> Fit:
        omega, zeta = moving.omega.copy(), moving.zeta.copy()
        omega[poles] = moving.omega[poles] * np.exp(x[:count])
        zeta[poles] = np.exp(x[count : 2 * count])
        return Fit(omega, zeta, x[2 * count :].reshape(moving.shape.shape) * scale, poles)

    def residual(x: Real) -> Real:
        rest = ((unpacked(x).fitted(functions) - target) * functions.weight).ravel()
        return np.concatenate([rest.real, rest.imag])

    def jacobian(x: Real) -> Real:
        now = unpacked(x)
        w = functions.omega
        g = modal(w, now.omega, now.zeta)  # (n, m)
        products = now.shape[:, rows] * now.shape[:, columns]  # (n, p)
        damping = -(g**2) * 2j * (now.zeta * now.omega)[:, None] * w
        natural = -(g**2) * 2 * now.omega[:, None] ** 2 + damping
        parts = [products[poles][:, :, None] * part[poles][:, None, :] for part in (natural, damping)]
        by_shape = np.zeros((n, now.shape.shape[1], rows.size, w.size), dtype=complex)
        for i, (row, column) in enumerate(functions.pairs):
            by_shape[:, row, i] += now.shape[:, column, None] * g * scale
            by_shape[:, column, i] += now.shape[:, row, None] * g * scale
        parts.append(by_shape.reshape(-1, rows.size, w.size))
        slopes = (np.concatenate(parts) * functions.weight).reshape(2 * count + moving.shape.size, -1)
        return np.hstack([slopes.real, slopes.imag]).T

    start = np.concatenate([np.zeros(count), np.log(moving.zeta[poles]), (moving.shape / scale).ravel()])
    low = np.concatenate([np.full(count, -0.02), np.full(count, _LN_ZETA[0]), np.full(moving.shape.size, -np.inf)])
    high = np.concatenate([np.full(count, 0.02), np.full(count, _LN_ZETA[1]), np.full(moving.shape.size, np.inf)])
    start = np.clip(start, low + 1e-9, high - 1e-9)
    found = unpacked(
        least_squares(residual, start, jacobian, bounds=(low, high), x_scale="jac", max_nfev=12, xtol=1e-8, ftol=1e-6).x
    )
    omega, zeta, shape = fit.omega.copy(), fit.zeta.copy(), fit.shape.copy()
    omega[free], zeta[free], shape[free] = found.omega, found.zeta, found.shape
    return Fit(omega, zeta, shape, fit.inside)


def _effective(functions: Functions, fit: Fit) -> Fit:
    """Return the modes without those whose loss would hardly be seen."""
    rows, columns = np.array(functions.pairs).T
    square = functions.weight**2
    kept = fit.inside.copy()
    for k in np.flatnonzero(fit.inside):
        g = np.abs(modal(functions.omega, fit.omega[k : k + 1], fit.zeta[k : k + 1])[0]) ** 2
        products = (fit.shape[k, rows] * fit.shape[k, columns]) ** 2
        kept[k] = float(products @ (square @ g)) > LEAST_EFFECT
    return fit.keep(kept | ~fit.inside)
