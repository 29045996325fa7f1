"""A rail from measurement: receptance or mobility in CSV or UFF (data set 58) in, passive `Modes` and fit quality out.

CSV: a column `frequency_hz` and, for each measured direction d, `d_real` and `d_imag`. UFF: data sets 58 of point
functions, abscissa in Hz. Spin is the rotation about the vertical axis per moment about it.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..interface import DIRECTIONS
from ..modal.modes import Modes
from .fit import MOST_MODES, check_frequencies, fit_errors, fit_modes

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

QUANTITIES = {"receptance": 1, "mobility": 0, "accelerance": -1}
"""What may be given per unit force, and the power of j omega that it lacks to be a mobility."""

LARGEST_ACTIVE_DEGREES = 5.0
"""How far the phase of a mobility may leave +-90 degrees before the data count as active: what a careful measurement's
phase and noise may do, and more than a passive structure with exact data does (0)."""

_UFF_QUANTITY = {8: "receptance", 11: "mobility", 12: "accelerance"}
"""Ordinate types of data set 58: displacement, velocity, acceleration; 0 and others say nothing."""

_UFF_DIRECTION = {1: "lon", 2: "lat", 3: "ver", 6: "spin"}
"""Direction codes of data set 58: +-1, 2, 3 are translations along x, y, z, +-4, 5, 6 rotations about them."""


@dataclass(frozen=True)
class Measurement:
    """Point receptances of a rail.

    Attributes
    ----------
    frequency_hz : (m,) increasing frequencies [Hz]
    receptance : by direction, (m,) complex [m/N; spin rad/(N m)]
    """

    frequency_hz: Real
    receptance: dict[str, Complex]

    def __post_init__(self) -> None:
        """Check that there is something, finite, over increasing frequencies."""
        f = self.frequency_hz
        if not self.receptance:
            raise ValueError(f"measurement: no direction; must be at least one of {', '.join(DIRECTIONS)}")
        unknown = sorted(set(self.receptance) - set(DIRECTIONS))
        if unknown:
            raise ValueError(f"measurement: direction {unknown[0]!r}; must be one of {', '.join(DIRECTIONS)}")
        check_frequencies(f, "measurement")
        for direction, values in self.receptance.items():
            if values.shape != f.shape:
                raise ValueError(f"measurement: {values.size} values in {direction} for {f.size} frequencies")
            bad = np.flatnonzero(~np.isfinite(values) | (values == 0))
            if bad.size:
                raise ValueError(
                    f"measurement: {direction} at {f[bad[0]]:g} Hz is {values[bad[0]]}; must be finite and not 0"
                )


def read_csv(path: Path, quantity: str) -> Measurement:
    """Return the measurement in a CSV file.

    Parameters
    ----------
    quantity : {'receptance', 'mobility', 'accelerance'}
        What the file holds, SI units.
    """
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        names = reader.fieldnames or ()
        directions = [d for d in DIRECTIONS if f"{d}_real" in names or f"{d}_imag" in names]
        wanted = ["frequency_hz", *(f"{d}_{part}" for d in directions for part in ("real", "imag"))]
        missing = [name for name in wanted if name not in names]
        if missing:
            raise ValueError(f"{path.name}: column {missing[0]!r} is missing")
        rows = []
        for line, row in enumerate(reader, start=2):
            try:
                rows.append([float(row[name]) for name in wanted])
            except (TypeError, ValueError):
                raise ValueError(f"{path.name}, line {line}: every value must be a number; got {row}") from None
    table = np.array(rows).reshape(-1, len(wanted))
    values = {d: table[:, 1 + 2 * i] + 1j * table[:, 2 + 2 * i] for i, d in enumerate(directions)}
    return _named(path, table[:, 0], values, quantity)


def read_uff(path: Path, quantity: str, axes: dict[int, str] | None = None) -> Measurement:
    """Return the measurement in a universal file: data sets 58 with equal response and reference direction.

    Parameters
    ----------
    quantity : {'receptance', 'mobility', 'accelerance'}
        What the file holds, SI units.
    axes : dict, optional
        Direction of each of UFF's direction codes; by default 1: lon, 2: lat, 3: ver, 6: spin, whatever their signs,
        since those cancel at one point.
    """
    import pyuff  # noqa: PLC0415 - only who reads such files needs it

    of_code = _UFF_DIRECTION if axes is None else axes
    try:
        sets = pyuff.UFF(str(path)).read_sets()
    except Exception as error:  # pyuff raises nothing more special
        raise ValueError(f"{path.name}: not a universal file: {error}") from None
    values: dict[str, Complex] = {}
    frequency_hz = np.zeros(0)
    for number, data in enumerate(sets if isinstance(sets, list) else [sets], start=1):
        direction = _point_direction(data, of_code)
        if direction is None:
            continue
        found = _UFF_QUANTITY.get(int(data.get("ordinate_spec_data_type") or 0), quantity)
        if found != quantity:
            raise ValueError(f"{path.name}, data set {number}: holds {found}; must be {quantity}, as asked for")
        if direction in values:
            raise ValueError(f"{path.name}, data set {number}: a second function in {direction}; must be one")
        x = np.asarray(data["x"], dtype=float)
        if frequency_hz.size and not np.array_equal(x, frequency_hz):
            raise ValueError(f"{path.name}, data set {number}: other frequencies than before; must be the same")
        frequency_hz, values[direction] = x, np.asarray(data["data"], dtype=complex)
    if frequency_hz.size and frequency_hz[0] == 0:  # a spectrum from 0 Hz: mobility says nothing there
        frequency_hz, values = frequency_hz[1:], {d: v[1:] for d, v in values.items()}
    return _named(path, frequency_hz, values, quantity)


def require_passive(measurement: Measurement, largest_degrees: float = LARGEST_ACTIVE_DEGREES) -> dict[str, float]:
    """Return how far the phase of the mobility leaves +-90 degrees in each direction, 0 where it does not.

    Raises
    ------
    ValueError
        If that is more than `largest_degrees`; says at which frequency it is worst.
    """
    active = {}
    for direction, alpha in measurement.receptance.items():
        phase = np.degrees(np.angle(1j * alpha))
        beyond = np.maximum(np.abs(phase) - 90.0, 0.0)
        worst = int(np.argmax(beyond))
        if beyond[worst] > largest_degrees:
            raise ValueError(
                f"measurement: {direction} mobility at {measurement.frequency_hz[worst]:g} Hz has a phase of "
                f"{phase[worst]:.1f} degrees; must be within +-90, as a passive rail's is, or {largest_degrees:g} more"
            )
        active[direction] = float(beyond[worst])
    return active


def measured_modes(
    measurement: Measurement, most_modes: int = MOST_MODES, largest_active_degrees: float = LARGEST_ACTIVE_DEGREES
) -> tuple[Modes, dict[str, dict[str, float]]]:
    """Return a passive modal rail and the quality of its fit.

    Returns
    -------
    modes : Modes
        At most `most_modes` in each measured direction, none in the others: the rail is rigid there.
    quality : dict
        `{direction: {rms_db, rms_degrees, modes, active_degrees}}` for the measured directions; the last is the largest
        phase beyond +-90 degrees that was in the data.

    Raises
    ------
    ValueError
        For data that are too few or not passive enough.
    """
    active = require_passive(measurement, largest_active_degrees)
    omega = 2 * np.pi * measurement.frequency_hz
    target = np.zeros((omega.size, 4, 4), dtype=complex)
    for direction, values in measurement.receptance.items():
        j = DIRECTIONS.index(direction)
        target[:, j, j] = values
    modes = fit_modes(omega, target, most_modes)
    with np.errstate(invalid="ignore", divide="ignore"):
        errors = fit_errors(omega, target, modes)
    return modes, {d: {**errors[d], "active_degrees": active[d]} for d in DIRECTIONS if d in active}


def _point_direction(data: dict[str, Any], of_code: dict[int, str]) -> str | None:
    """Return the direction of a data set 58 that is a point function in a known direction, else None."""
    if data.get("type") != 58:
        return None
    response, reference = abs(int(data["rsp_dir"])), abs(int(data["ref_dir"]))
    same_node = data.get("rsp_node") == data.get("ref_node")
    return of_code.get(response) if response == reference and same_node else None


def _named(path: Path, frequency_hz: Real, values: dict[str, Complex], quantity: str) -> Measurement:
    """Return the measurement as receptance; messages name the file."""
    if quantity not in QUANTITIES:
        raise ValueError(f"quantity is {quantity!r}; must be one of {', '.join(QUANTITIES)}")
    try:
        factor = (2j * np.pi * frequency_hz) ** (QUANTITIES[quantity] - 1.0)
        return Measurement(frequency_hz, {d: v * factor for d, v in values.items()})
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from None
