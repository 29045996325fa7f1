"""The shipped modal rails: default track in, the files in `data` out, as the table `component.SHIPPED` says.

`curvesqueal rail regenerate` writes them, or says where their receptances differ
from those of what is there.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from ..errors import DataError
from ..modal.data import ModalData, read_modal_data, write_modal_data
from ..modal.modes import Modes, receptance
from .component import DATA, SHIPPED
from .discrete import DiscreteTrack, discrete_modes
from .fit import accurate_modes, error_frequencies, fit_errors
from .paper_fit import paper_modes
from .track_data import TRACKS, Track, read_track

_ANALYTICAL = {"accurate": accurate_modes, "paper": paper_modes}

DIGITS = 6
LARGEST_DIFFERENCE = (0.05, 0.3)
"""Difference of receptances, rms in dB and degrees, that still counts as equal: a tenth of what the fits promise. The
modes themselves are not compared: other versions of NumPy and SciPy find others that do the same within 0.001 dB."""

_SOURCE = {
    "accurate": (
        "passive least squares fit, 28 Hz to 5.5 kHz, of the logarithm of the receptance of the analytical track "
        "(fmus.rail.fit)"
    ),
    "paper": (
        "method of Ding, Squicciarini and Thompson (2016), section 3.1: cut-on frequencies, C = s eta / omega_0, one "
        "mode at 20 kHz; modal masses fitted to the analytical track, 30 Hz to 5 kHz (fmus.rail.paper_fit)"
    ),
    "discrete": (
        "passive least squares fit, 28 Hz to 5.5 kHz, of the logarithm of the receptance of the finite-element rail on "
        "discrete sleepers (fmus.rail.discrete)"
    ),
}


def modal_rail(track: Track, method: str, most_modes: int | None = None) -> ModalData:
    """Return the modal rail of a track with the words for its file, numbers rounded to six digits.

    Parameters
    ----------
    method : {'accurate', 'paper'}
    most_modes : int, optional
        Largest number of modes in each direction, 'accurate' only.
    """
    if method not in _ANALYTICAL:
        raise DataError(f"method is {method!r}; must be one of {', '.join(_ANALYTICAL)}")
    if method == "paper" and most_modes is not None:
        raise DataError("most_modes goes with method 'accurate'; the paper's method takes every cut-on")
    modes = accurate_modes(track, most_modes) if most_modes is not None else _ANALYTICAL[method](track)
    return ModalData(f"{method} modal rail: {track.title}", _SOURCE[method], _rounded(modes))


def discrete_modal_rail(track: Track, position: float = 0.5, most_modes: int = 16) -> ModalData:
    """Return the modal rail of a track on discrete sleepers.

    Parameters
    ----------
    position : float
        Of the contact in the span [-]: 0 above a sleeper, 0.5 at mid-span.
    most_modes : int
        Largest number of modes in each direction.
    """
    modes = discrete_modes(DiscreteTrack(track, position), most_modes)
    title = f"discrete sleepers, contact at {position:g} of the span: {track.title}"
    return ModalData(title, _SOURCE["discrete"], _rounded(modes))


METHODS: dict[str, Callable[[Track], ModalData]] = {
    "accurate": partial(modal_rail, method="accurate"),
    "paper": partial(modal_rail, method="paper"),
    "discrete": discrete_modal_rail,
}
"""How the shipped rails are made of the default track."""


def shipped() -> dict[str, ModalData]:
    """Return the shipped modal rails by file name, made anew."""
    track = read_track(TRACKS / "default.toml")
    return {f"{name}.toml": METHODS[rail.method](track) for name, rail in SHIPPED.items()}


def regenerate(folder: Path = DATA) -> None:
    """Write the shipped modal rails."""
    for name, data in shipped().items():
        write_modal_data(folder / name, data)


def differences(folder: Path = DATA) -> list[str]:
    """Return a sentence for each shipped file that is not what its method makes."""
    found = []
    for name, data in shipped().items():
        there = read_modal_data(folder / name)
        if (there.title, there.source) != (data.title, data.source):
            found.append(f"{name}: title or source differs")
        omega = 2 * np.pi * error_frequencies()
        errors = fit_errors(omega, receptance(omega, data.modes), there.modes)
        for direction, error in errors.items():
            if error["rms_db"] > LARGEST_DIFFERENCE[0] or error["rms_degrees"] > LARGEST_DIFFERENCE[1]:
                db, degrees = error["rms_db"], error["rms_degrees"]
                found.append(
                    f"{name}: {direction} differs by {db:.2f} dB and {degrees:.1f} degrees rms; "
                    f"must be at most {LARGEST_DIFFERENCE[0]:g} and {LARGEST_DIFFERENCE[1]:g}"
                )
    return found


def _rounded(modes: Modes) -> Modes:
    """Return the modes with frequencies, damping ratios and shapes of six digits."""

    def digits(values: np.typing.NDArray[np.float64]) -> np.typing.NDArray[np.float64]:
        return np.array([float(f"{v:.{DIGITS}g}") for v in values.ravel()]).reshape(values.shape)

    frequency_hz = digits(modes.omega / (2 * np.pi))
    return Modes(2 * np.pi * frequency_hz, digits(modes.zeta), digits(modes.shape), modes.labels)
