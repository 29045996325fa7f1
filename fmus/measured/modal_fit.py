"""Real modes from measured point and cross functions of a lightly damped structure: receptances in, `Modes` out.

H_jk = sum psi_j psi_k / (omega_i^2 - omega^2 + 2 j zeta_i omega_i omega) with the poles shared by all functions. Two
modes may share one pole, as the two families of an axisymmetric wheel do. Every mode has a positive modal mass and
damping ratio, so the result is passive whatever the data. Deterministic: no random starts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks

from .function import Complex, Real

Pair = tuple[int, int]

LEAST_NOISE = 2e-3
"""Noise below which the data are not weighted further: no modal model is nearer."""

_BELOW, _ABOVE = 0.1, 2.5
"""Poles for all that lies below and above the band, in ends of the band."""

_DAMPING_RATIO = (1e-6, 0.5)
_SWEEPS = 6
_HALF_WINDOW = 30
"""Lines on each side of a pole that its frequency and damping are found from, at least."""


@dataclass(frozen=True)
class Functions:
    """Receptances of one contact point over one set of frequencies.

    Attributes
    ----------
    omega : (m,) increasing angular frequencies [rad/s]
    pairs : directions (row, column) of each function, row <= column
    values : (p, m) complex receptances
    noise : (p, m) standard deviation over magnitude, >= LEAST_NOISE
    """

    omega: Real
    pairs: tuple[Pair, ...]
    values: Complex
    noise: Real

    @property
    def weight(self) -> Real:
        """Return one over the standard deviation of each value, (p, m)."""
        return 1.0 / (np.abs(self.values) * self.noise)


@dataclass(frozen=True)
class Poles:
    """Poles and the residues of every function.

    Attributes
    ----------
    omega, zeta : (n,) natural angular frequencies [rad/s] and damping ratios; the first and last stand for what lies
        outside the band
    residue : (n, p) products of the two amplitudes [1/kg]
    """

    omega: Real
    zeta: Real
    residue: Real

    def fitted(self, omega: Real) -> Complex:
        """Return the functions, (p, m)."""
        return self.residue.T @ modal(omega, self.omega, self.zeta)


def modal(omega: Real, natural: Real, zeta: Real) -> Complex:
    """Return the receptance of each mode with unit amplitude, (n, m)."""
    bottom = natural[:, None] ** 2 - omega**2 + 2j * (zeta * natural)[:, None] * omega
    return np.asarray(1.0 / bottom)


def fit_poles(functions: Functions, most_poles: int = 150) -> Poles:
    """Return the poles and residues that are nearest to the functions.

    Notes
    -----
    Poles start where point functions peak. In turn, all residues are found by linear least squares over all lines, and
    each pole with its residues by Gauss-Newton steps over the lines around it, the others held. Poles are added where
    the rest peaks, as long as this makes it smaller by more than chance would.
    """
    starts = _starts(functions)
    if not starts.size:
        raise ValueError("no resonance in the data")
    found = _refined(functions, _with_ends(functions, starts, np.full(starts.size, 1e-3)))
    for _ in range(4):
        more = _missed(functions, found)[: most_poles - found.omega.size]
        if not more.size:
            break
        natural = np.concatenate([found.omega[1:-1], more])
        zeta = np.concatenate([found.zeta[1:-1], np.full(more.size, 1e-3)])
        order = np.argsort(natural)
        richer = _refined(functions, _with_ends(functions, natural[order], zeta[order]))
        if _cost(functions, richer) > 0.98 * _cost(functions, found):
            break
        found = richer
    return found


def amplitudes(poles: Poles, pairs: tuple[Pair, ...], most: int = 2) -> tuple[NDArray[np.int64], Real]:
    """Return the pole and the shape, (r,) and (r, 4), of each mode: at most `most` for a pole, four for the ends.

    Notes
    -----
    The matrix of residues of a pole is a sum of psi psi^T; its largest eigenvalues and their vectors, after scaling the
    directions to alike sizes, give the shapes. What would be a negative modal mass is noise and is left out.
    """
    rows, columns = np.array(pairs).T
    matrices = np.zeros((poles.omega.size, 4, 4))
    matrices[:, rows, columns] = matrices[:, columns, rows] = poles.residue
    inside = slice(1, -1)
    scale = np.sqrt(np.abs(np.diagonal(matrices[inside], axis1=1, axis2=2)).max(axis=0))
    scale = np.where(scale > 0, scale, 1.0)
    index, shapes = [], []
    for k, matrix in enumerate(matrices):
        values, vectors = np.linalg.eigh(matrix / np.outer(scale, scale))
        limit = 4 if k in (0, len(matrices) - 1) else most
        for value, vector in list(zip(values, vectors.T, strict=True))[::-1][:limit]:
            if value > 1e-5 * values[-1] > 0:
                index.append(k)
                shapes.append(vector * np.sqrt(value) * scale)
    return np.array(index, dtype=np.int64), np.array(shapes).reshape(-1, 4)


def rest(functions: Functions, poles: Poles) -> Complex:
    """Return what the fit leaves of each function over its standard deviation, (p, m)."""
    return (functions.values - poles.fitted(functions.omega)) * functions.weight


def _cost(functions: Functions, poles: Poles) -> float:
    """Return the sum of squares of the rest, where large parts count linearly."""
    size = np.abs(rest(functions, poles))
    return float(np.where(size < 4, size**2, 8 * size - 16).sum())


def _starts(functions: Functions) -> Real:
    """Return the frequencies at which point functions peak."""
    found: list[float] = []
    w = functions.omega
    for (row, column), values, noise in zip(functions.pairs, functions.values, functions.noise, strict=True):
        if row != column:
            continue
        level = np.log(np.abs(w * values))
        peaks, _ = find_peaks(level, prominence=max(0.15, 8 * float(np.median(noise))))
        found += [float(_parabola(w, level, i)) for i in peaks]
    return _distinct(np.array(sorted(found)), w)


def _parabola(w: Real, level: Real, i: int) -> float:
    """Return the abscissa of the parabola's top through three neighbouring values."""
    a, b, c = level[i - 1 : i + 2]
    shift = 0.5 * (a - c) / (a - 2 * b + c) if a - 2 * b + c < 0 else 0.0
    return float(w[i] + shift * (w[i + 1] - w[i - 1]) / 2)


def _distinct(natural: Real, w: Real) -> Real:
    """Return frequencies without those that lie within a line and a half of the one before."""
    kept: list[float] = []
    for value in natural:
        i = int(np.clip(np.searchsorted(w, value), 1, w.size - 1))
        if not kept or value - kept[-1] > 1.5 * (w[i] - w[i - 1]):
            kept.append(float(value))
    return np.array(kept)


def _with_ends(functions: Functions, natural: Real, zeta: Real) -> Poles:
    """Return poles with one below and one above the band for all that lies there."""
    w = functions.omega
    natural = np.concatenate([[_BELOW * w[0]], natural, [_ABOVE * w[-1]]])
    zeta = np.concatenate([[0.5], zeta, [0.05]])
    return _linear(functions, natural, zeta)


def _linear(functions: Functions, natural: Real, zeta: Real) -> Poles:
    """Return the residues of given poles by linear least squares, function by function."""
    basis = modal(functions.omega, natural, zeta)
    norm = np.abs(basis).max(axis=1)
    residues = []
    for values, weight in zip(functions.values, functions.weight, strict=True):
        columns = (basis / norm[:, None] * weight).T
        normal = (columns.conj().T @ columns).real
        right = (columns.conj().T @ (values * weight)).real
        size = np.sqrt(np.diag(normal))
        solved = np.linalg.lstsq(normal / np.outer(size, size), right / size, rcond=1e-13)[0]
        residues.append(solved / size / norm)
    return Poles(natural, zeta, np.array(residues).T)


def _refined(functions: Functions, poles: Poles) -> Poles:
    """Return the poles after sweeps over them, with the residues that belong to them."""
    for _ in range(_SWEEPS):
        natural, zeta, residue = poles.omega.copy(), poles.zeta.copy(), poles.residue.copy()
        left = functions.values - poles.fitted(functions.omega)
        for k in range(1, natural.size - 1):
            lines = _window(functions.omega, natural[k], zeta[k])
            own = residue[k][:, None] * modal(functions.omega[lines], natural[k : k + 1], zeta[k : k + 1])
            target = left[:, lines] + own
            natural[k], zeta[k], residue[k] = _one_pole(
                functions.omega[lines], target, functions.weight[:, lines], natural[k], zeta[k]
            )
            new = residue[k][:, None] * modal(functions.omega[lines], natural[k : k + 1], zeta[k : k + 1])
            left[:, lines] = target - new
        order = np.argsort(natural)
        poles = _linear(functions, natural[order], zeta[order])
    return poles


def _window(w: Real, natural: float, zeta: float) -> slice:
    """Return the lines around a pole: a number of them, or four bandwidths."""
    centre = int(np.searchsorted(w, natural))
    low = min(int(np.searchsorted(w, natural * (1 - 4 * zeta))), centre - _HALF_WINDOW)
    high = max(int(np.searchsorted(w, natural * (1 + 4 * zeta))), centre + _HALF_WINDOW)
    return slice(max(low, 0), min(high, w.size))


def _one_pole(w: Real, target: Complex, weight: Real, natural: float, zeta: float) -> tuple[float, float, Real]:
    """Return one pole and its residues by Gauss-Newton steps; (p, m) target and weight.

    Each function has a constant besides, for what other poles that are not yet right leave.
    """
    for _ in range(3):
        g = modal(w, np.array([natural]), np.array([zeta]))[0]
        residue, background = _amounts(g, target, weight)
        rest_now = (target - residue[:, None] * g - background[:, None]) * weight
        by_natural = -(g**2) * 2 * natural * (natural + 1j * zeta * w)  # over ln omega
        by_damping = -(g**2) * 2j * zeta * natural * w  # over ln zeta
        slopes = [(residue[:, None] * s * weight).ravel() for s in (by_natural, by_damping)]
        normal = np.array([[np.vdot(a, b).real for b in slopes] for a in slopes])
        right = np.array([np.vdot(a, rest_now.ravel()).real for a in slopes])
        normal[0, 0] += 1e-300
        normal[1, 1] += 1e-300
        step = np.linalg.lstsq(normal, right, rcond=1e-14)[0]
        spacing = (w[-1] - w[0]) / (w.size - 1)
        natural *= float(np.exp(np.clip(step[0], -2 * spacing / natural, 2 * spacing / natural)))
        zeta = float(np.clip(zeta * np.exp(np.clip(step[1], -1.5, 1.5)), *_DAMPING_RATIO))
        natural = float(np.clip(natural, w[0], w[-1]))
    g = modal(w, np.array([natural]), np.array([zeta]))[0]
    return natural, zeta, _amounts(g, target, weight)[0]


def _amounts(g: Complex, target: Complex, weight: Real) -> tuple[Real, Real]:
    """Return the residue and a real constant of each function by weighted least squares, (p,) each."""
    square = weight**2
    gg, g1, one = square @ np.abs(g) ** 2, square @ g.real, square.sum(axis=1)
    gt, t1 = (square * target) @ g.conj(), (square * target.real).sum(axis=1)
    determinant = gg * one - g1**2
    return (gt.real * one - t1 * g1) / determinant, (t1 * gg - gt.real * g1) / determinant


def _missed(functions: Functions, poles: Poles) -> Real:
    """Return where the rest peaks far above chance, the largest first."""
    size = np.sqrt((np.abs(rest(functions, poles)) ** 2).mean(axis=0))
    typical = float(np.median(size))
    peaks, _ = find_peaks(size, height=4 * typical, distance=3)
    return functions.omega[peaks[np.argsort(-size[peaks])]][:20]
