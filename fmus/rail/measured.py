"""A rail from measured point functions: receptances in, passive `Modes` and what they rest on out.

Files are read by `fmus.measured`. A direction that was not measured is rigid. Spin is the rotation about the vertical
axis per moment about it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import DataError
from ..interface import DIRECTIONS
from ..measured.choice import Choice
from ..measured.noise import LARGEST_NOISE, Averaged, averaged, good_band, relative_noise
from ..measured.read import read_measured
from ..measured.selection import Measured, files_and_origins
from ..measured.units import QUANTITIES, TRANSLATIONS
from ..modal.data import ModalData
from ..modal.modes import Modes
from .fit import FEWEST_FREQUENCIES, MOST_MODES, fit_errors, fit_modes

LARGEST_ACTIVE_DEGREES = 5.0
"""How far the phase of a mobility may leave +-90 degrees before the data count as active: what a careful measurement's
phase does, and more than a passive structure with exact data does (0). Noise is allowed for besides."""

SOFTEST = 1e-6
"""Receptance [m/N] above which a rail is too soft to be one: the default track has 2e-8 at most."""

_SIGMAS = 3.0


@dataclass(frozen=True)
class RailFit:
    """A rail from measurement.

    Attributes
    ----------
    modes : at most so many in each measured direction as were allowed, none in the others
    quality : by direction: rms_db, rms_degrees (fit against the data, averaged over 1/48 octave), modes, noise (median
        standard deviation of a line over its value), active_degrees (largest phase beyond +-90), from_hz, to_hz (band
        that was used), data_from_hz, data_to_hz (band there was)
    used : by direction: file, data set, point, quantity, units, factor, sign
    """

    modes: Modes
    quality: dict[str, dict[str, float]]
    used: dict[str, Mapping[str, str | float]]


def rail_from_frf(  # noqa: PLR0913 - one argument per property of the data
    frequency_hz: ArrayLike,
    functions: Mapping[str, ArrayLike],
    *,
    quantity: str = "receptance",
    coherence: Mapping[str, ArrayLike] | None = None,
    band_hz: tuple[float, float] | None = None,
    most_modes: int = MOST_MODES,
    largest_active_degrees: float = LARGEST_ACTIVE_DEGREES,
) -> RailFit:
    """Return the passive modal rail that fits point functions.

    Parameters
    ----------
    frequency_hz : (m,) array_like
        Increasing frequencies > 0 [Hz].
    functions : mapping of direction ('lon', 'lat', 'ver', 'spin') to (m,) complex array_like
        Motion per force at the contact point, SI: m/N, m/s/N or m/s2/N; for spin rad per N m and so on.
    quantity : {'receptance', 'mobility', 'accelerance'}
    coherence : mapping of direction to (m,) array_like, optional
        From 0 to 1.
    band_hz : (start, stop), optional
        Band to be fitted; by default the widest one in which the data are good.
    most_modes : int
        In each direction.
    largest_active_degrees : float
        How far the phase of a mobility may leave +-90 degrees, noise apart.

    Raises
    ------
    DataError
        For data that are too few, too noisy or not passive enough.

    Examples
    --------
    >>> f = np.geomspace(20, 4000, 200)
    >>> omega = 2 * np.pi * f
    >>> rail = rail_from_frf(f, {"ver": 0.01 / (1e6 - omega**2 + 400j * omega)})  # one mode: 1000 rad/s, 0.1 kg^-1/2
    >>> float(rail.modes.omega[0].round(3)), float(rail.modes.zeta[0].round(3))
    (1000.0, 0.2)
    """
    if quantity not in QUANTITIES:
        raise DataError(f"quantity is {quantity!r}; must be one of {', '.join(QUANTITIES)}")
    if not functions:
        raise DataError(f"measurement: no direction; must be at least one of {', '.join(DIRECTIONS)}")
    f = np.asarray(frequency_hz, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_receptance = (2j * np.pi * f) ** -float(QUANTITIES[quantity])
    parts = []
    for direction, values in functions.items():
        given = np.asarray(values, dtype=complex)
        receptance = given * to_receptance if given.shape == f.shape else given
        seen = None if coherence is None or direction not in coherence else np.asarray(coherence[direction], float)
        used: dict[str, str | float] = {"set": "measurement", "quantity": quantity, "units": "SI", "factor": 1.0}
        measured = Measured(direction, direction, f, receptance, seen, used)
        if band_hz is not None:
            measured = measured.on_lines((f >= band_hz[0]) & (f <= band_hz[1]))
        parts.append(measured)
    return fit_measured(parts, band_hz is None, most_modes, largest_active_degrees)


def rail_from_files(
    files: Sequence[Path], choice: Choice | None = None, most_modes: int = MOST_MODES
) -> tuple[ModalData, RailFit]:
    """Return the modal rail that fits the point functions of some files, each with its own lines and directions.

    Parameters
    ----------
    files : universal files, CSV or NumPy archives
    choice : what the files do not say themselves
    most_modes : in each direction

    Raises
    ------
    DataError
        For files that cannot be read or fitted, or a direction that two files have; says which file.
    """
    chosen = choice or Choice()
    found: dict[str, tuple[Path, Measured]] = {}
    for file in files:
        points = [m for m in read_measured(file, chosen) if m.response == m.reference]
        if not points:
            raise DataError(f"{file.name}: holds cross functions only; a rail needs point functions")
        for measured in points:
            if measured.response in found:
                other = found[measured.response][0]
                raise DataError(f"{file}: holds {measured.response} as {other} does; must be in one file")
            _require_rail(measured)
            found[measured.response] = (file, measured)
    automatic = chosen.start_hz is None and chosen.stop_hz is None
    fit = fit_measured([measured for _, measured in found.values()], automatic, most_modes)
    names = files_and_origins(files, fit.used.values())
    quantities = " and ".join(sorted({str(used["quantity"]) for used in fit.used.values()}))
    source = f"passive least squares fit of the logarithm of the {quantities} in {names} (fmus.rail.measured)"
    return ModalData("measured modal rail", source, fit.modes), fit


def fit_measured(
    parts: Sequence[Measured],
    automatic_band: bool = True,
    most_modes: int = MOST_MODES,
    largest_active_degrees: float = LARGEST_ACTIVE_DEGREES,
) -> RailFit:
    """Return the fit of point functions, direction by direction."""
    ordered = sorted(parts, key=lambda measured: DIRECTIONS.index(measured.response))
    modes: list[Modes] = []
    quality: dict[str, dict[str, float]] = {}
    used = {}
    for measured in ordered:
        try:
            chosen, means, noise = _good_part(measured, automatic_band)
            active = _require_passive(measured.response, means, largest_active_degrees)
            own, errors = _fitted(measured.response, means, most_modes)
        except ValueError as error:
            raise DataError(f"{measured.used['set']}: {error}") from None
        modes.append(own)
        used[measured.response] = chosen.used
        quality[measured.response] = {
            **errors, "noise": noise, "active_degrees": active,
            "from_hz": float(chosen.used["from_hz"]), "to_hz": float(chosen.used["to_hz"]),
            "data_from_hz": float(measured.frequency_hz[0]), "data_to_hz": float(measured.frequency_hz[-1]),
        }  # fmt: skip
    joined = Modes(
        np.concatenate([part.omega for part in modes]),
        np.concatenate([part.zeta for part in modes]),
        np.concatenate([part.shape for part in modes]),
        tuple(label for part in modes for label in part.labels),
    )
    return RailFit(joined, quality, used)


def _good_part(measured: Measured, automatic_band: bool) -> tuple[Measured, Averaged, float]:
    """Return the part in the band with good data, its averages and the median noise of a line."""
    # as accelerance, whose noise is the same on all lines of an impact test
    noise = relative_noise(measured.receptance * measured.frequency_hz**2)
    inside = np.ones(noise.size, dtype=bool)
    if automatic_band:
        inside = good_band(measured.frequency_hz, noise, measured.coherence)
    if inside.sum() < FEWEST_FREQUENCIES:
        raise DataError(
            f"{measured.response} has {inside.sum()} frequencies with noise below {LARGEST_NOISE:.0%} of the value, of "
            f"{inside.size}; must be at least {FEWEST_FREQUENCIES}"
        )
    chosen = measured.on_lines(inside)
    means = averaged(chosen.frequency_hz, chosen.receptance, noise[inside], chosen.coherence)
    return chosen, means, float(np.median(noise[inside]))


def _require_passive(direction: str, means: Averaged, largest_degrees: float) -> float:
    """Return how far the phase of the mobility leaves +-90 degrees at worst, 0 where it does not.

    Raises
    ------
    DataError
        If that is more than `largest_degrees` and three standard deviations of the noise.
    """
    phase = np.degrees(np.angle(1j * means.values))
    beyond = np.maximum(np.abs(phase) - 90.0, 0.0)
    allowed = largest_degrees + _SIGMAS * np.degrees(means.noise / np.sqrt(2.0))
    worst = int(np.argmax(beyond - allowed))
    if beyond[worst] > allowed[worst]:
        raise DataError(
            f"{direction} mobility at {means.frequency_hz[worst]:g} Hz has a phase of {phase[worst]:.1f} degrees; "
            f"must be within +-90, as a passive rail's is, or {allowed[worst]:.2g} more"
        )
    return float(beyond.max())


def _fitted(direction: str, means: Averaged, most_modes: int) -> tuple[Modes, dict[str, Any]]:
    """Return the modes of one direction and the errors of the fit."""
    omega = 2 * np.pi * means.frequency_hz
    j = DIRECTIONS.index(direction)
    target = np.zeros((omega.size, 4, 4), dtype=complex)
    target[:, j, j] = means.values
    modes = fit_modes(omega, target, most_modes)
    with np.errstate(invalid="ignore", divide="ignore"):
        return modes, fit_errors(omega, target, modes)[direction]


def _require_rail(measured: Measured) -> None:
    """Raise ValueError for a receptance that no rail has, where the file does not say its units."""
    largest = float(np.abs(measured.receptance).max())
    if measured.si_assumed and measured.response in TRANSLATIONS and largest > SOFTEST:
        raise DataError(
            f"{measured.used['set']}: {measured.response} receptance reaches {largest:.2g} m/N, more than a rail's "
            f"({SOFTEST:g}); the file gives no unit: say it in its header or with the option units"
        )
