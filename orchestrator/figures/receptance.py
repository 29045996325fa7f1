"""Receptance of the rail: `Track` in, figures of analytical against modal rails and the table of their errors out.

The paper's Figs 3 and 4 in all four directions, magnitude and phase.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes, receptance
from fmus.rail.fit import accurate_modes, error_frequencies, fit_errors
from fmus.rail.paper_fit import paper_modes
from fmus.rail.track import track_receptance
from fmus.rail.track_data import Track

from ..visible import visible
from .style import PLAIN

Errors = dict[str, dict[str, dict[str, float]]]

FREQUENCIES_HZ = np.geomspace(20, 10e3, 600)

_TITLE = {"lon": "longitudinal", "lat": "lateral", "ver": "vertical", "spin": "spin"}
_UNIT = {"lon": "m/N", "lat": "m/N", "ver": "m/N", "spin": "rad/(N m)"}


@dataclass(frozen=True)
class _Line:
    """How a curve is drawn: told apart without colour too."""

    colour: str
    style: str
    width: float


_LINES = {
    "analytical": _Line("black", "-", 1.6),
    "paper, without extra mode": _Line("tab:blue", "--", 1.1),
    "paper, with extra mode": _Line("tab:red", ":", 1.8),
    "accurate": _Line("tab:green", "-.", 1.3),
}


def modal_rails(track: Track, accurate: Modes | None = None) -> dict[str, Modes]:
    """Return the modal rails that are compared, by the name in the legend.

    Parameters
    ----------
    accurate : Modes, optional
        The accurate modal rail if it is at hand; fitted otherwise, which takes some seconds.
    """
    return {
        "paper, without extra mode": paper_modes(track, extra=False),
        "paper, with extra mode": paper_modes(track),
        "accurate": accurate_modes(track) if accurate is None else accurate,
    }


def receptance_errors(track: Track, rails: dict[str, Modes]) -> Errors:
    """Return `{rail: {direction: {rms_db, rms_degrees, modes}}}` over 200 frequencies, 30 Hz to 5 kHz."""
    omega = 2 * np.pi * error_frequencies()
    target = track_receptance(omega, track)
    return {name: fit_errors(omega, target, modes) for name, modes in rails.items()}


def draw_receptance(track: Track, rails: dict[str, Modes], directions: tuple[str, ...] = DIRECTIONS) -> Figure:
    """Return the figure: a column per direction, magnitude above phase.

    Parameters
    ----------
    directions : tuple of str
        `("ver",)` is the paper's Fig. 3, `("lat", "lon")` its Fig. 4.
    """
    omega = 2 * np.pi * FREQUENCIES_HZ
    curves = {"analytical": track_receptance(omega, track)}
    curves |= {name: receptance(omega, modes) for name, modes in rails.items()}
    figure = Figure(figsize=(1.2 + 3.6 * len(directions), 6.2), layout="constrained")
    axes = figure.subplots(2, len(directions), sharex=True, squeeze=False, height_ratios=(3, 2))
    for column, direction in enumerate(directions):
        _draw_direction(axes[:, column], curves, direction)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=min(len(curves), 2 * len(directions)))
    figure.suptitle(f"Point receptance of the rail\n{visible(track.title)}", fontsize="medium", **PLAIN)
    return figure


def write_receptance(track: Track, rails: dict[str, Modes], folder: Path) -> list[Path]:
    """Write the figures as PNG, all directions and those of the paper, and return their paths."""
    figures = {"receptance": DIRECTIONS, "figure-3": ("ver",), "figure-4": ("lat", "lon")}
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, directions in figures.items():
        paths.append(folder / f"{name}.png")
        draw_receptance(track, rails, directions).savefig(paths[-1], dpi=200)
    return paths


def _draw_direction(axes: NDArray[np.object_], curves: dict[str, NDArray[np.complex128]], direction: str) -> None:
    """Draw magnitude and phase of one direction into the two axes."""
    j = DIRECTIONS.index(direction)
    magnitude: Axes = axes[0]
    phase: Axes = axes[1]
    for name, alpha in curves.items():
        line = _LINES[name]
        look = {"color": line.colour, "linestyle": line.style, "linewidth": line.width, "label": name}
        magnitude.loglog(FREQUENCIES_HZ, np.abs(alpha[:, j, j]), **look)
        phase.semilogx(FREQUENCIES_HZ, np.degrees(np.angle(alpha[:, j, j])), **look)
    exact = np.abs(curves["analytical"][:, j, j])
    magnitude.set_ylim(exact.min() / 4, exact.max() * 3)
    magnitude.set_title(_TITLE[direction])
    magnitude.set_ylabel(f"magnitude [{_UNIT[direction]}]")
    phase.set_ylabel("phase [degrees]")
    phase.set_ylim(-185, 5)
    phase.set_yticks(range(-180, 1, 45))
    phase.set_xlabel("frequency [Hz]")
    phase.set_xlim(FREQUENCIES_HZ[0], FREQUENCIES_HZ[-1])
    for axis in (magnitude, phase):
        axis.grid(visible=True, which="major", linewidth=0.5, alpha=0.6)
        axis.grid(visible=True, which="minor", linewidth=0.3, alpha=0.3)
