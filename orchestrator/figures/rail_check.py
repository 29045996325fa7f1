"""What the check of a rail found: report in, table, plain data and figure out."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fmus.interface import DIRECTIONS

from ..probing.rail_check import RailReport
from ..probing.rail_passivity import BAND_HZ, Mobility
from ..visible import visible
from .style import STYLE, plain_ticks

TITLE = {"lon": "longitudinal", "lat": "lateral", "ver": "vertical", "spin": "spin"}
UNIT = {"lon": "m/(N s)", "lat": "m/(N s)", "ver": "m/(N s)", "spin": "rad/(N m s)"}

FREQUENCIES = 200


def draw_mobility(mobility: Mobility, title: str) -> Figure:
    """Return the figure of the point mobilities: magnitude above phase, in grey where only an active rail has it."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(13.0, 5.6), layout="constrained")
        axes = figure.subplots(2, 4, sharex=True, height_ratios=(3, 2))
        for j, direction in enumerate(DIRECTIONS):
            magnitude, phase = axes[0, j], axes[1, j]
            own = mobility.values[:, j, j]
            magnitude.set(title=TITLE[direction], ylabel=f"magnitude [{UNIT[direction]}]", xscale="log")
            if own.any():
                magnitude.loglog(mobility.frequency_hz, np.abs(own), color="black")
                decades = np.log10(np.abs(own[own != 0]))
                magnitude.set_ylim(10 ** np.floor(decades.min() - 0.1), 10 ** np.ceil(decades.max() + 0.1))
                phase.semilogx(mobility.frequency_hz, np.degrees(np.angle(own)), color="black")
            else:
                magnitude.text(0.5, 0.5, "does not move", ha="center", transform=magnitude.transAxes)
            _frame_phase(phase)
        title += f"; at s = {mobility.shift:.3g} 1/s + j omega" if mobility.shift else ""
        figure.suptitle(f"Point mobility from impulse responses: {visible(title)}", fontsize="medium")
    return plain_ticks(figure)


def _frame_phase(axes: Axes) -> None:
    """Give the phase its limits and shade what lies beyond +-90 degrees."""
    for low in (-180, 90):
        axes.axhspan(low, low + 90, color="0.9", zorder=0)
    axes.set(ylabel="phase [degrees]", xlabel="frequency [Hz]", ylim=(-180, 180), yticks=range(-180, 181, 90))
    axes.set(xscale="log", xlim=BAND_HZ)


def write_mobility(report: RailReport, folder: Path) -> Path | None:
    """Write the figure as PNG and return its path; None if the FMU did not run."""
    if report.mobility is None:
        return None
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{report.file.stem}-mobility.png"
    draw_mobility(report.mobility, report.file.name).savefig(path, dpi=150)
    return path
