"""Passive modal fit: receptance over frequency in, `Modes` and their errors out. No files.

Every mode has a positive modal mass, a positive damping ratio and one direction, so that the fitted rail is passive at
all frequencies whatever the data. Deterministic: no random starts.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import DataError
from ..interface import DIRECTIONS
from ..modal.modes import Modes, receptance
from .direction_fit import Goal, fit_direction, rms_error
from .track import track_receptance
from .track_data import Track

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

BAND_HZ = (30.0, 5000.0)
"""The band of the goal: errors are taken at `error_frequencies`."""

FIT_BAND_HZ = (28.0, 5500.0)
"""A little wider than the goal's, so that the fit does not run away at its ends."""

MOST_MODES = 8
FEWEST_FREQUENCIES = 20


def error_frequencies() -> Real:
    """Return the 200 frequencies that errors are given for [Hz]."""
    return np.geomspace(*BAND_HZ, 200)


def fit_errors(omega: ArrayLike, target: Complex, modes: Modes) -> dict[str, dict[str, float]]:
    """Return how far the modal receptance is from the target in each direction.

    Parameters
    ----------
    omega : (m,) array_like
        Angular frequencies [rad/s].
    target : (m, 4, 4) complex array
        Receptance that was to be matched.

    Returns
    -------
    dict
        `{direction: {"rms_db", "rms_degrees", "modes"}}`, root mean squares over the given frequencies.
    """
    fitted = receptance(omega, modes)
    errors = {}
    for j, direction in enumerate(DIRECTIONS):
        count = int(np.count_nonzero(modes.shape[:, j]))
        db, degrees = rms_error(np.log(fitted[:, j, j] / target[:, j, j])) if count else (np.inf, np.inf)
        errors[direction] = {"rms_db": float(db), "rms_degrees": float(degrees), "modes": count}
    return errors


def accurate_modes(track: Track, most_modes: int = MOST_MODES) -> Modes:
    """Return the accurate modal rail of a track: at most `most_modes` in each direction."""
    omega = 2 * np.pi * np.geomspace(*FIT_BAND_HZ, 240)
    return fit_modes(omega, track_receptance(omega, track), most_modes)


def fit_modes(omega: ArrayLike, target: Complex, most_modes: int = MOST_MODES, goal: Goal | None = None) -> Modes:
    """Return modes of one direction each whose receptance is nearest to the diagonal of `target`.

    Parameters
    ----------
    omega : (m,) array_like
        Increasing angular frequencies [rad/s].
    target : (m, 4, 4) complex array
        Receptance; a direction whose diagonal is zero throughout gets no mode.
    most_modes : int
        Largest number of modes in each direction, >= 1.

    Raises
    ------
    DataError
        For too few, unsorted or not positive frequencies, or values that are not finite.
    """
    w = _checked(omega, target, most_modes)
    rows: list[list[float]] = []
    labels: list[str] = []
    for j, direction in enumerate(DIRECTIONS):
        if not target[:, j, j].any():
            continue
        p = fit_direction(w, target[:, j, j], most_modes, goal or Goal())
        for i, (natural, zeta, squared) in enumerate(sorted(np.exp(p).T.tolist()), start=1):
            rows.append([natural, zeta, *(np.sqrt(squared) if k == j else 0.0 for k in range(4))])
            labels.append(f"{direction} {i}")
    table = np.array(rows).reshape(-1, 6)
    return Modes(table[:, 0], table[:, 1], table[:, 2:], tuple(labels))


def check_frequencies(frequency_hz: Real, what: str) -> None:
    """Raise ValueError unless frequencies are finite, positive and increasing; `what` begins the message."""
    f = frequency_hz
    bad = np.flatnonzero(~np.isfinite(f) | (f <= 0))
    if bad.size:
        raise DataError(f"{what}: frequency {bad[0] + 1} is {f[bad[0]]:g} Hz; must be finite and > 0")
    bad = np.flatnonzero(np.diff(f) <= 0)
    if bad.size:
        raise DataError(f"{what}: {f[bad[0] + 1]:g} Hz comes after {f[bad[0]]:g} Hz; frequencies must increase")


def _checked(omega: ArrayLike, target: Complex, most_modes: int) -> Real:
    """Return the frequencies as an array if data and settings can be fitted."""
    w = np.asarray(omega, dtype=float)
    if w.ndim != 1 or w.size < FEWEST_FREQUENCIES:
        raise DataError(f"fit: {w.size} frequencies; must be at least {FEWEST_FREQUENCIES}")
    check_frequencies(w / (2 * np.pi), "fit")
    if target.shape != (w.size, 4, 4):
        raise DataError(f"fit: receptance has the shape {target.shape}; must be {(w.size, 4, 4)}")
    for j, direction in enumerate(DIRECTIONS):
        values = target[:, j, j]
        bad = np.flatnonzero(~np.isfinite(values) | ((values == 0) & values.any()))
        if bad.size:
            f = w[bad[0]] / (2 * np.pi)
            raise DataError(f"fit: {direction} receptance at {f:g} Hz is {values[bad[0]]}; must be finite and not 0")
    if most_modes < 1:
        raise DataError(f"fit: most_modes = {most_modes}; must be at least 1")
    return w
