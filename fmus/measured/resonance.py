"""One resonance in a few lines of several functions: where modes of a fit start from."""

from __future__ import annotations

import numpy as np

from .function import Complex, Real

_DAMPING_RATIO = (1e-6, 0.5)


def modal(omega: Real, natural: Real, zeta: Real) -> Complex:
    """Return the receptance of each mode with unit amplitude, (n, m)."""
    bottom = natural[:, None] ** 2 - omega**2 + 2j * (zeta * natural)[:, None] * omega
    return np.asarray(1.0 / bottom)


def one_resonance(
    w: Real, values: Complex, weight: Real, natural: float, zeta: float = 1e-3, steps: int = 8
) -> tuple[float, float, Real]:
    """Return natural angular frequency, damping ratio and residues [1/kg], (p,), of the resonance in some lines.

    Parameters
    ----------
    w : (m,) angular frequencies [rad/s]
    values, weight : (p, m) functions, and one over the standard deviation of each value
    natural, zeta : where to begin

    Notes
    -----
    Gauss-Newton steps in ln omega and ln zeta; in each, every function has its own residue and a constant for
    all that is not this resonance, by linear least squares.
    """
    spacing = (w[-1] - w[0]) / (w.size - 1)
    for _ in range(steps):
        g = modal(w, np.array([natural]), np.array([zeta]))[0]
        residue, background = _amounts(g, values, weight)
        rest = ((values - residue[:, None] * g - background[:, None]) * weight).ravel()
        slopes = [
            (residue[:, None] * slope * weight).ravel()
            for slope in (-(g**2) * 2 * natural * (natural + 1j * zeta * w), -(g**2) * 2j * zeta * natural * w)
        ]
        normal = np.array([[np.vdot(a, b).real for b in slopes] for a in slopes])
        right = np.array([np.vdot(a, rest).real for a in slopes])
        step = np.linalg.lstsq(normal, right, rcond=1e-14)[0]
        most = 2 * spacing / natural
        natural = float(np.clip(natural * np.exp(np.clip(step[0], -most, most)), w[0], w[-1]))
        zeta = float(np.clip(zeta * np.exp(np.clip(step[1], -1.5, 1.5)), *_DAMPING_RATIO))
    return natural, zeta, _amounts(modal(w, np.array([natural]), np.array([zeta]))[0], values, weight)[0]


def _amounts(g: Complex, values: Complex, weight: Real) -> tuple[Real, Complex]:
    """Return the residue, real, and a complex constant of each function by weighted least squares, (p,) each."""
    square = weight**2
    total = square.sum(axis=1)
    mean_g, mean_v = (square @ g) / total, (square * values).sum(axis=1) / total
    apart = g - mean_g[:, None]
    residue = (square * (apart.conj() * (values - mean_v[:, None])).real).sum(axis=1) / (
        (square * np.abs(apart) ** 2).sum(axis=1) + 1e-300
    )
    return residue, mean_v - residue * mean_g
