"""A wheel from measured functions at its contact point: files or arrays in, passive `Modes` of both families out.

Files are read by `fmus.measured`. A direction that was not measured is rigid.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import DataError
from ..interface import DIRECTIONS
from ..measured.choice import Choice
from ..measured.modal_fit import fit_functions
from ..measured.modal_model import LEAST_NOISE, Functions
from ..measured.noise import relative_noise
from ..measured.read import read_measured
from ..measured.selection import Measured
from ..modal.modes import Modes, receptance


@dataclass(frozen=True)
class MeasuredWheel:
    """A wheel from measured functions.

    Attributes
    ----------
    modes : in the contract's axes
    notes : sentences on what was taken as what
    quality : by function: median_db, median_degrees (fit against the data), noise (of a line over its value)
    used : what was taken from the files, by function
    """

    modes: Modes
    notes: tuple[str, ...]
    quality: dict[str, dict[str, float]]
    used: tuple[Mapping[str, str | float], ...]


def wheel_from_frf(
    frequency_hz: ArrayLike,
    functions: Mapping[tuple[str, str], ArrayLike],
    progress: Callable[[str], None] = lambda _: None,
) -> MeasuredWheel:
    """Return the modes that fit receptances of a wheel at its contact point.

    Parameters
    ----------
    frequency_hz : (m,) array_like
        Increasing frequencies > 0 [Hz].
    functions : mapping of (motion, force) to (m,) complex array_like
        Receptances [m/N; rotations rad, moments N m], such as `{("lat", "lat"): ..., ("lat", "ver"): ...}`.
    progress : called with a few words now and then

    Raises
    ------
    DataError
        If a cross function is missing whose sign matters: lat and ver, or lon and spin, without their cross function.
    """
    f = np.asarray(frequency_hz, dtype=float)
    used: dict[str, str | float] = {"set": "measurement"}
    parts = [Measured(*pair, f, np.asarray(values, dtype=complex), None, used) for pair, values in functions.items()]
    return fit_wheel(parts, progress)


def wheel_from_files(
    files: Sequence[Path], choice: Choice | None = None, progress: Callable[[str], None] = lambda _: None
) -> MeasuredWheel:
    """Return the wheel that fits measured functions in files.

    Notes
    -----
    Cross functions in a universal file have the sign of their axes, so these must be said then.
    """
    chosen = choice or Choice()
    parts: list[Measured] = []
    for file in files:
        found = read_measured(file, chosen)
        if not chosen.axes and any(m.response != m.reference and ":" in str(m.used["point"]) for m in found):
            raise DataError(
                f"{file.name}: holds cross functions, whose signs depend on the axes: give the option axis, such as "
                "1=lon, -2=lat, -3=ver"
            )
        parts += found
    return fit_wheel(parts, progress)


def fit_wheel(parts: Sequence[Measured], progress: Callable[[str], None] = lambda _: None) -> MeasuredWheel:
    """Return the modes that fit measured functions."""
    by_pair: dict[tuple[int, int], Measured] = {}
    for measured in parts:
        row, column = sorted((DIRECTIONS.index(measured.response), DIRECTIONS.index(measured.reference)))
        if (row, column) in by_pair:
            raise DataError(f"{measured.used['set']}: a second function of {measured.words}; must be one")
        if not np.array_equal(measured.frequency_hz, parts[0].frequency_hz):
            raise DataError(
                f"{measured.used['set']}: {measured.words} has other frequencies than the first; must agree"
            )
        by_pair[row, column] = measured
    notes = _require_signs(set(by_pair))
    pairs = tuple(sorted(by_pair))
    values = np.array([by_pair[pair].receptance for pair in pairs])
    noise = np.array([np.full(v.size, max(float(np.median(relative_noise(v))), LEAST_NOISE)) for v in values])
    functions = Functions(2 * np.pi * parts[0].frequency_hz, pairs, values, noise)
    fit = fit_functions(functions, progress)
    labels = tuple(
        f"{omega / (2 * np.pi):.5g} Hz" if inside else "outside the band"
        for omega, inside in zip(fit.omega, fit.inside, strict=True)
    )
    modes = Modes(fit.omega, fit.zeta, fit.shape, labels)
    return MeasuredWheel(modes, notes, _quality(functions, modes), tuple(m.used for m in parts))


def _require_signs(pairs: set[tuple[int, int]]) -> tuple[str, ...]:
    """Return what unmeasured functions are taken as; refuse those that matter."""
    points = {row for row, column in pairs if row == column}
    for row, column in sorted(pairs):
        for j in (row, column):
            if j not in points:
                raise DataError(f"measurement: {DIRECTIONS[j]} has no point function; must be measured, too")
    for row, column in ((1, 2), (0, 3)):
        if {row, column} <= points and (row, column) not in pairs:
            a, b = DIRECTIONS[row], DIRECTIONS[column]
            raise DataError(f"measurement: {a} due to {b} is missing; it has the sign between {a} and {b}")
    notes = []
    rigid = [d for j, d in enumerate(DIRECTIONS) if j not in points]
    if rigid:
        notes.append(f"not measured, so the wheel is rigid there: {', '.join(rigid)}")
    if points & {0, 3} and points & {1, 2} and not any((i, j) in pairs for i in (0, 3) for j in (1, 2)):
        notes.append("no function couples lon and spin with lat and ver: taken as 0, as of an axisymmetric wheel")
    return tuple(notes)


def _quality(functions: Functions, modes: Modes) -> dict[str, dict[str, float]]:
    """Return how far the modes are from each function, as medians over the lines, since antiresonances are noise."""
    fitted = receptance(functions.omega, modes)
    quality = {}
    for (row, column), values, noise in zip(functions.pairs, functions.values, functions.noise, strict=True):
        ratio = np.log(fitted[:, row, column] / values)
        name = DIRECTIONS[row] if row == column else f"{DIRECTIONS[row]} due to {DIRECTIONS[column]}"
        quality[name] = {
            "median_db": float(20 / np.log(10) * np.median(np.abs(ratio.real))),
            "median_degrees": float(np.degrees(np.median(np.abs(ratio.imag)))),
            "noise": float(np.median(noise)),
        }
    return quality
