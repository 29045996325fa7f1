"""Passive modal fit in one direction: point receptance in, frequencies, damping ratios and masses out. No files.

Modes are (3, n) arrays of ln omega, ln zeta and ln psi^2, so that every real array is a passive rail: whatever the
optimiser does, masses and damping ratios are positive. Deterministic: no random starts.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares, nnls
from scipy.special import expit

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SOFTEST = 3.0
"""Static receptance over the largest in the data: more than this is penalised. Below the band
the fit is free, and a soft mode there would let the rail sag under the load."""

_NEPER = np.array([20 / np.log(10), 180 / np.pi])
"""dB per neper and degrees per radian: what the real and imaginary part of a complex logarithm become."""

_DAMPING_RATIO = (5e-3, 0.5, 300.0)
"""Bounds of the fitted damping ratios: least within the band, least outside, largest. The component takes more.
A sharper mode within the band would be a resonance that an infinite track does not have."""

_UNUSED = 1e-9
"""Share of the largest amount below which least squares did not take a mode of the dictionary, but for rounding."""

_APART = (0.5, 1.0)
"""Distances in ln omega and ln zeta, either of which makes two starts of a mode different ones."""

_CONVERGED = 1e-9
"""Relative change of cost and variables at which a fit has ended; far below what 0.5 dB and 3 degrees can tell."""


@dataclass(frozen=True)
class Goal:
    """Errors at which a fit takes no further mode: half of what is promised (0.5 dB, 3 degrees), to have room."""

    rms_db: float = 0.25
    rms_degrees: float = 1.5


def fit_direction(w: Real, target: Complex, most_modes: int, goal: Goal) -> Real:
    """Return the variables of the modes of one direction, as few as reach the goal.

    Notes
    -----
    Grown mode by mode. Where that does not reach the goal, a second start is a non-negative least squares fit over the
    whole dictionary, pruned and polished down to `most_modes`; the better one is taken.
    """
    grown = _improved(w, target, np.zeros((3, 0)), most_modes, goal)
    if _reached(w, target, grown, goal):
        return grown
    pruned = _improved(w, target, _pruned(w, target, most_modes), most_modes, goal)
    return min((grown, pruned), key=lambda p: _cost(w, target, p))


def _improved(w: Real, target: Complex, start: Real, most_modes: int, goal: Goal) -> Real:
    """Return the modes after growing to `most_modes` and exchanging the least useful ones, as long as this helps."""
    best, cost = start, _cost(w, target, start) if start.size else np.inf
    for _ in range(2 * most_modes):
        if _reached(w, target, best, goal):
            break
        if best.shape[1] < most_modes:
            candidate, new_cost = _grow(w, target, best, cost)
        else:
            candidate, new_cost = _grow(w, target, *_polish(w, target, _without_least(w, target, best)))
        if new_cost > 0.99 * cost:
            break
        best, cost = candidate, new_cost
    return best


def _pruned(w: Real, target: Complex, most_modes: int) -> Real:
    """Return `most_modes` modes or fewer from a non-negative least squares fit over the dictionary."""
    atoms = _dictionary(w)
    columns = _parted(_modal(w, atoms) / target[:, None], w)
    norm = np.linalg.norm(columns, axis=0)
    amounts, _ = nnls(columns / norm, _parted(np.ones((w.size, 1)), w)[:, 0], maxiter=50 * atoms.shape[1])
    active = np.flatnonzero(amounts > _UNUSED * amounts.max())
    p = np.vstack([atoms[:2, active], np.log(amounts[active] / norm[active])])
    while p.shape[1] > most_modes:
        p, _ = _polish(w, target, _without_least(w, target, p), 20 if p.shape[1] > most_modes + 4 else 200)
    return p


def _without_least(w: Real, target: Complex, p: Real) -> Real:
    """Return the modes without the one whose loss costs least."""
    return min((np.delete(p, i, axis=1) for i in range(p.shape[1])), key=lambda fewer: _cost(w, target, fewer))


def _dictionary(w: Real) -> Real:
    """Return ln omega, ln zeta and ln psi^2 = 0 of the modes that fits start from."""
    f, z = np.meshgrid(np.linspace(np.log(w[0] / 1.4), np.log(10 * w[-1]), 48), np.log(np.geomspace(0.01, 100.0, 24)))
    atoms = np.stack([f.ravel(), z.ravel(), np.zeros(f.size)])
    return np.asarray(atoms[:, _excess(w, atoms)[0].reshape(4, -1).sum(axis=0) == 0])


def _grow(w: Real, target: Complex, p: Real, cost: float) -> tuple[Real, float]:
    """Return the modes with the most useful further one, polished, and their cost; unchanged if none helps."""
    best = p
    for start in _candidates(w, target, p):
        polished, new_cost = _polish(w, target, np.hstack([p, start]))
        if new_cost < cost:
            best, cost = polished, new_cost
    return best, cost


def _candidates(w: Real, target: Complex, p: Real, count: int = 4) -> list[Real]:
    """Return the starts of a further mode that promise most, different ones."""
    atoms = _dictionary(w)
    columns = _parted(_modal(w, atoms) / target[:, None], w)
    norm = np.linalg.norm(columns, axis=0)
    at_hand = _parted(_modal(w, p) / target[:, None], w)
    rest = _parted(np.ones((w.size, 1)), w)[:, 0] - at_hand.sum(axis=1)
    basis, _ = np.linalg.qr(at_hand)
    apart = columns / norm - basis @ (basis.T @ (columns / norm))
    gain = apart.T @ rest / np.linalg.norm(apart, axis=0)
    chosen: list[int] = []
    for i in np.argsort(-gain, kind="stable"):
        if all((np.abs(atoms[:2, i] - atoms[:2, c]) > _APART).any() for c in chosen):
            chosen.append(int(i))
        if len(chosen) == count:
            break
    size = np.log(np.maximum(gain, 1e-3) / norm)
    return [np.array([[atoms[0, i]], [atoms[1, i]], [size[i]]]) for i in chosen]


def _excess(w: Real, p: Real) -> tuple[Real, Real, Real]:
    """Return by how much modes leave their bounds, (4 n,), and the slopes of this over ln omega and ln zeta.

    Notes
    -----
    Natural frequencies from 1/1.4 of the first frequency to ten times the last. Outside the data nothing would stop
    a resonance, so that there the damping ratio has to be larger.
    """
    low, high = np.log(w[0] / 1.4), np.log(10 * w[-1])
    least, least_outside, largest = np.log(_DAMPING_RATIO)
    sharp = 20.0
    above = expit(sharp * (p[0] - np.log(w[-1])))
    below = expit(-sharp * (p[0] - np.log(w[0])))
    bound = least + (least_outside - least) * (above + below)
    slope = sharp * (above * (1 - above) - below * (1 - below)) * (least_outside - least)
    beyond = np.concatenate([low - p[0], p[0] - high, bound - p[1], p[1] - largest])
    active = (beyond > 0).astype(float)
    one, zero = np.ones(p.shape[1]), np.zeros(p.shape[1])
    by_natural = np.concatenate([-one, one, slope, zero]) * active
    by_damping = np.concatenate([zero, zero, -one, one]) * active
    return beyond * active, by_natural, by_damping


def _static_excess(target: Complex, p: Real) -> tuple[float, Real]:
    """Return by how much the logarithm of the static receptance is too large, and its slopes over the variables.

    Notes
    -----
    Data begin somewhere; below them a slow mode could make the rail many times too soft. So at rest it is to be no
    softer than `_SOFTEST` times the largest receptance in the data.
    """
    share = np.exp(p[2] - 2 * p[0])
    beyond = float(np.log(share.sum() / (_SOFTEST * np.abs(target).max())))
    if beyond <= 0:
        return 0.0, np.zeros(p.size)
    share = share / share.sum()
    return beyond, np.concatenate([-2 * share, 0 * share, share])


def _modal(w: Real, logarithms: Real) -> Complex:
    """Return the receptance of each mode, (m, n)."""
    natural, zeta, squared = np.exp(logarithms)
    own: Complex = squared / (natural**2 - w[:, None] ** 2 + 2j * zeta * natural * w[:, None])
    return own


def _weights(w: Real) -> Real:
    """Return the root of each frequency's share of the logarithmic axis, so that any spacing counts alike."""
    share: Real = np.gradient(np.log(w))
    root: Real = np.sqrt(share / share.mean())
    return root


def _parted(values: ArrayLike, w: Real) -> Real:
    """Return weighted real and imaginary parts below each other."""
    weighted = np.asarray(values) * _weights(w)[:, None]
    return np.vstack([weighted.real, weighted.imag])


def _polish(w: Real, target: Complex, p: Real, evaluations: int = 200) -> tuple[Real, float]:
    """Return the variables at the nearest minimum of |ln(fitted / target)|^2, and this cost."""

    def residual(x: Real) -> Real:
        q = np.clip(x.reshape(p.shape), -60, 60)
        fitted = _modal(w, q).sum(axis=1)
        beyond = [_excess(w, q)[0], [_static_excess(target, q)[0]]]
        return np.concatenate([_parted(np.log(fitted / target)[:, None], w)[:, 0], *beyond])

    def jacobian(x: Real) -> Real:
        q = np.clip(x.reshape(p.shape), -60, 60)
        modal = _modal(w, q)
        natural, zeta, squared = np.exp(q)
        by_damping = -modal * (modal / squared) * (2j * zeta * natural * w[:, None])
        by_natural = -modal * (modal / squared) * 2 * natural**2 + by_damping
        slopes = np.hstack([by_natural, by_damping, modal]) / modal.sum(axis=1)[:, None]
        own = np.tile(np.eye(p.shape[1]), (4, 1))
        bounds = [own * slope[:, None] for slope in _excess(w, q)[1:]]
        return np.vstack([_parted(slopes, w), np.hstack([*bounds, 0 * own]), _static_excess(target, q)[1]])

    found = least_squares(
        residual, p.ravel(), jac=jacobian, method="lm", max_nfev=evaluations, xtol=_CONVERGED, ftol=_CONVERGED
    )
    return found.x.reshape(p.shape), 2 * float(found.cost)


def _cost(w: Real, target: Complex, p: Real) -> float:
    """Return the weighted sum of squares of ln(fitted / target)."""
    fitted = _modal(w, p).sum(axis=1)
    return float((_parted(np.log(fitted / target)[:, None], w) ** 2).sum())


def rms_error(logarithm: Complex) -> Real:
    """Return the root mean squares of a complex logarithm in dB and degrees."""
    parts = np.array([logarithm.real, logarithm.imag])
    return np.asarray(_NEPER * np.sqrt((parts**2).mean(axis=1)))


def _reached(w: Real, target: Complex, p: Real, goal: Goal) -> bool:
    """Return whether the modes are as near as the goal asks for."""
    if not p.shape[1]:
        return False
    fitted = _modal(w, p).sum(axis=1)
    db, degrees = rms_error(np.log(fitted / target) * _weights(w))
    return bool(db <= goal.rms_db and degrees <= goal.rms_degrees)
