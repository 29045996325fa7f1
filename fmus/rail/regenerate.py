"""The shipped modal rails: default track in, `data/rail.toml`, `rail-paper.toml` and `rail-discrete.toml` out.

`python -m fmus.rail.regenerate` writes them; with `--check` it writes nothing and fails where they differ from what is
there by more than the rounding of another machine's linear algebra explains.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from ..modal import Modes
from ..modal_data import ModalData, read_modal_data, write_modal_data
from .component import DATA
from .discrete import DiscreteTrack, discrete_modes
from .fit import accurate_modes
from .paper_fit import paper_modes
from .track_data import TRACKS, Track, read_track

METHODS = {"accurate": accurate_modes, "paper": paper_modes}
SHIPPED = {"rail.toml": "accurate", "rail-paper.toml": "paper", "rail-discrete.toml": "discrete"}

DIGITS = 6
LARGEST_DIFFERENCE = 1e-3
"""Relative difference that counts as equal: a fit ends where its cost is flat to 1e-9, so its numbers to the root."""

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
    if method not in METHODS:
        raise ValueError(f"method is {method!r}; must be one of {', '.join(METHODS)}")
    if method == "paper" and most_modes is not None:
        raise ValueError("most_modes goes with method 'accurate'; the paper's method takes every cut-on")
    modes = accurate_modes(track, most_modes) if most_modes is not None else METHODS[method](track)
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


def shipped() -> dict[str, ModalData]:
    """Return the shipped modal rails by file name, made anew."""
    track = read_track(TRACKS / "default.toml")
    return {
        name: discrete_modal_rail(track) if method == "discrete" else modal_rail(track, method)
        for name, method in SHIPPED.items()
    }


def regenerate(folder: Path = DATA) -> None:
    """Write the shipped modal rails."""
    for name, data in shipped().items():
        write_modal_data(folder / name, data)


def differences(folder: Path = DATA) -> list[str]:
    """Return a sentence for each shipped file that is not what its method makes."""
    found = []
    for name, data in shipped().items():
        there = read_modal_data(folder / name)
        if (there.title, there.source, there.modes.labels) != (data.title, data.source, data.modes.labels):
            found.append(f"{name}: title, source or modes differ")
            continue
        for quantity in ("omega", "zeta", "shape"):
            old, new = getattr(there.modes, quantity), getattr(data.modes, quantity)
            worst = float(np.max(np.abs(old - new) / np.maximum(np.abs(new), 1e-12)))
            if worst > LARGEST_DIFFERENCE:
                found.append(
                    f"{name}: {quantity} differs by {worst:.1e}, relative; must be at most {LARGEST_DIFFERENCE}"
                )
    return found


def _rounded(modes: Modes) -> Modes:
    """Return the modes with frequencies, damping ratios and shapes of six digits."""

    def digits(values: np.typing.NDArray[np.float64]) -> np.typing.NDArray[np.float64]:
        return np.array([float(f"{v:.{DIGITS}g}") for v in values.ravel()]).reshape(values.shape)

    frequency_hz = digits(modes.omega / (2 * np.pi))
    return Modes(2 * np.pi * frequency_hz, digits(modes.zeta), digits(modes.shape), modes.labels)


if __name__ == "__main__":
    if "--check" in sys.argv[1:]:
        sys.exit("\n".join(differences()) or None)
    regenerate()
