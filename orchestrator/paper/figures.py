"""Figures of the page of the paper: consistency of Table 4, the slope that it tells, and its loop gains."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

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
    axes.loglog(
        result.frequency_hz, result.largest_r, "_", color="#0b5394", markersize=14, markeredgewidth=1.5,
        label="largest r, whatever the falling coefficient",
    )  # fmt: skip
    for mode, f, r in zip(result.modes, result.frequency_hz, result.r, strict=True):
        axes.annotate(mode, (f, r), (6, -3), textcoords="offset points", fontsize=8)
    axes.set(xlabel="frequency [Hz]", ylabel="mobility [m/s/N]", xlim=(50, 5000), ylim=(3e-7, 5e-5))
    axes.grid(visible=True, which="both", alpha=0.3)
    axes.legend(loc="upper left", fontsize=8)
    return figure


def draw_slope(profile: Sequence[Mapping[str, float]], found: float, deviation: float) -> Figure:
    """Return the figure of the misfit over the slope factor s.

    Parameters
    ----------
    profile : with slope_factor and rms_ln_gain, as the identification writes it
    found, deviation : s with everything free, and its standard deviation relative to it
    """
    figure = Figure(figsize=(6.5, 3.6), layout="constrained")
    axes = figure.subplots()
    s, rms = (np.array([p[name] for p in profile]) for name in ("slope_factor", "rms_ln_gain"))
    axes.axvspan(
        found * (1 - deviation), found * (1 + deviation), color="0.85", label=f"s free: {found:.3f} $\\pm$ 1 deviation"
    )
    axes.loglog(s, rms, "o-", color="#0b5394", label="best fit of Table 4 at this s")
    axes.axvline(1.0, color="#c2570c", linestyle="--", label="eq. (11) and Table 1")
    axes.set(xlabel="s = (g/m$_0^2$) over that of eq. (11) and Table 1 [-]", ylabel="rms of ln(gain/paper gain) [-]")
    ticks = [0.1, 0.15, 0.2, 0.3, 0.5, 0.75, 1.0]
    axes.set_xticks(ticks, [f"{t:g}" for t in ticks], minor=False)
    axes.set_xticks([], minor=True)
    axes.set_yticks([0.01, 0.02, 0.05, 0.1, 0.2], ["0.01", "0.02", "0.05", "0.1", "0.2"])
    axes.set_yticks([], minor=True)
    axes.grid(visible=True, alpha=0.3)
    axes.legend(loc="upper center", fontsize=8)
    return figure


def draw_gains(table: Table4, inferred: Table4) -> Figure:
    """Return the figure of loop gains: one panel per case, the paper's beside those as printed and inferred."""
    figure = Figure(figsize=(8, 5), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for case, axes in zip(CASES, panels.flat, strict=True):
        ours, twin = (
            [next(c for c in t.cells if (c.case, c.mode) == (case, mode)) for mode in CELL_MODES]
            for t in (table, inferred)
        )
        place = np.arange(len(CELL_MODES))
        for shift, name, gains, colour, hatch in (
            (-0.27, "paper", [c.paper_gain for c in ours], "0.75", ""),
            (0.0, "as printed", [c.gain for c in ours], "#0b5394", "//"),
            (0.27, "inferred", [c.gain for c in twin], "#c2570c", ".."),
        ):
            heights = [gain or np.nan for gain in gains]
            axes.bar(place + shift, heights, 0.27, label=name, color=colour, hatch=hatch, edgecolor="white")
        axes.axhline(1.0, color="black", linewidth=0.8)
        axes.set(yscale="log", ylim=(0.8, 60), title=f"Case {case}", xticks=place, xticklabels=CELL_MODES)
        axes.set_yticks([1, 2, 5, 10, 20, 50], ["1", "2", "5", "10", "20", "50"])
        axes.grid(visible=True, axis="y", alpha=0.3)
    for axes in panels[:, 0]:
        axes.set_ylabel("loop gain [-]")
    panels[0, 1].legend(loc="upper right")
    return figure
