"""Figures of the page of the paper: consistency of Table 4 and its loop gains."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..published.table4 import CASES, CELL_MODES
from .consistency import Consistency
from .table4 import Table4

RAIL_HZ = np.geomspace(50, 5000, 500)


def draw_consistency(result: Consistency, frequency_hz: NDArray[np.float64], rail: NDArray[np.float64]) -> Figure:
    """Return the figure of r from Table 4 against Re Y33 of the rail.

    Parameters
    ----------
    frequency_hz, rail : Re Y33 of the rail over frequency [Hz], [m/s/N]
    """
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.subplots()
    axes.loglog(frequency_hz, rail, color="black", label="rail: Re Y33, default track")
    axes.fill_between(frequency_hz, 1e-7, rail, color="0.9", label="excluded: r < Re Y33")
    axes.loglog(
        result.frequency_hz, result.r, "o", color="#c2570c", label="r = |D|$^2$/Re D from Table 4, Cases 1 to 3"
    )
    for mode, f, r in zip(result.modes, result.frequency_hz, result.r, strict=True):
        axes.annotate(mode, (f, r), (6, -3), textcoords="offset points", fontsize=8)
    axes.set(xlabel="frequency [Hz]", ylabel="mobility [m/s/N]", xlim=(50, 5000), ylim=(3e-7, 5e-5))
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(loc="upper left", fontsize=8)
    return figure


def draw_gains(table: Table4) -> Figure:
    """Return the figure of loop gains: one panel per case, the paper's beside ours."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for case, axes in zip(CASES, panels.flat, strict=True):
        cells = [next(c for c in table.cells if (c.case, c.mode) == (case, mode)) for mode in CELL_MODES]
        place = np.arange(len(cells))
        for shift, name, colour, hatch in ((-0.2, "paper", "0.75", ""), (0.2, "here", "#0b5394", "//")):
            gains = [(c.paper_gain if name == "paper" else c.gain) or np.nan for c in cells]
            axes.bar(place + shift, gains, 0.4, label=name, color=colour, hatch=hatch, edgecolor="white")
        axes.axhline(1.0, color="black", linewidth=0.8)
        axes.set(yscale="log", ylim=(0.8, 60), title=f"Case {case}", xticks=place, xticklabels=CELL_MODES)
        axes.set_yticks([1, 2, 5, 10, 20, 50], ["1", "2", "5", "10", "20", "50"])
        axes.grid(visible=True, axis="y", alpha=0.3)
    for axes in panels[:, 0]:
        axes.set_ylabel("loop gain [-]")
    panels[0, 1].legend(loc="upper right")
    return figure
