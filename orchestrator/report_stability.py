"""Figures of stability: results in, Nyquist and Bode diagrams of eigenloci and the consistency of Table 4 out.

`python -m orchestrator.report_stability FOLDER` writes them for the four cases.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from fmus.rail.track_data import TRACKS, read_track

from .consistency import Consistency, consistency
from .eigenloci import Eigenloci
from .frequency_domain import linear_contact, of_track
from .paper_table import CASES, CELL_MODES, read_paper_table
from .stability_case import REPORTED_BELOW_HZ, Stability
from .stability_commands import find_stability
from .table4 import Table4

COLOURS = ("#9a9a9a", "#0b5394", "#c2570c")
STYLES: Any = ("--", "-", ":")
RAIL_HZ = np.geomspace(50, 5000, 500)


def draw_stability(result: Stability, title: str) -> Figure:
    """Return the figure: Nyquist contours of the eigenloci beside modulus and phase, unstable frequencies starred.

    The paper's Fig. 7 shows the eigenvalue of largest modulus only; here every locus has a line of its own.
    """
    figure = Figure(figsize=(10, 5), layout="constrained")
    axes = figure.subplot_mosaic(
        [["nyquist", "modulus"], ["nyquist", "phase"]], height_ratios=(2, 1), width_ratios=(1, 1.2)
    )
    nyquist, modulus, phase = axes["nyquist"], axes["modulus"], axes["phase"]
    phase.sharex(modulus)
    shown = result.loci.frequency_hz <= REPORTED_BELOW_HZ
    loci = Eigenloci(result.loci.omega[shown], result.loci.values[shown])
    order = np.argsort(np.abs(loci.values).max(axis=0))
    for colour, style, k in zip(COLOURS[::-1], STYLES, order[::-1], strict=True):
        look: Any = {"color": colour, "linestyle": style, "linewidth": 0.8}
        nyquist.plot(loci.values[:, k].real, loci.values[:, k].imag, **look)
        modulus.loglog(loci.frequency_hz, np.abs(loci.values[:, k]), **look)
        phase.semilogx(loci.frequency_hz, np.degrees(np.angle(loci.values[:, k])), ".", color=colour, markersize=0.5)
    _mark(nyquist, modulus, result)
    modulus.axhline(1.0, color="black", linewidth=0.6)
    modulus.set(ylabel="modulus [-]", ylim=(1e-3, None), xlim=(50, REPORTED_BELOW_HZ))
    phase.set(ylabel="phase [degrees]", xlabel="frequency [Hz]", yticks=range(-180, 181, 90), ylim=(-185, 185))
    for panel in axes.values():
        panel.grid(visible=True, alpha=0.3)
    figure.suptitle(f"{title}: eigenloci of H1 G + H2, in the order of their largest modulus", fontsize="medium")
    handles = [
        *(Line2D([], [], color=c, ls=s, label=f"eigenlocus {n}")
          for n, (c, s) in enumerate(zip(COLOURS[::-1], STYLES, strict=True), start=1)),
        Line2D([], [], color="black", marker="*", linestyle="", markersize=7, label="unstable frequency [Hz]"),
        Line2D([], [], color="black", marker="+", linestyle="", markersize=9, label="critical point +1"),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), fontsize=8, frameon=False)
    return figure


def _mark(nyquist: Axes, modulus: Axes, result: Stability) -> None:
    """Mark the critical point and the unstable frequencies."""
    gains = [i.crossing.gain for i in result.instabilities]
    frequencies = [i.crossing.frequency_hz for i in result.instabilities]
    nyquist.plot(gains, np.zeros(len(gains)), "k*", markersize=7)
    nyquist.plot([1.0], [0.0], "k+", markersize=12)
    nyquist.set(xlabel="real part [-]", ylabel="imaginary part [-]")
    reach = 1.2 * max([2.0, *gains])  # the longitudinal locus goes far to the left, where nothing happens
    nyquist.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    modulus.plot(frequencies, gains, "k*", markersize=7)
    for k, (f, g) in enumerate(zip(frequencies, gains, strict=True)):
        near = k and f / frequencies[k - 1] < 1.1
        modulus.annotate(f"{f:.0f}", (f, g), (3 if near else 0, 5), textcoords="offset points", fontsize=7, ha="left")


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


def write_figures(folder: Path) -> list[Path]:
    """Write the figures of the four cases and of the consistency of Table 4; return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for case in ("case1", "case2", "case3", "case4"):
        paths.append(folder / f"stability-{case}.png")
        draw_stability(find_stability(case), case).savefig(paths[-1], dpi=150)
    track = of_track(read_track(TRACKS / "default.toml"))
    falling, constant = linear_contact(), linear_contact({"falling_ratio": 0.0})
    Y = falling.turn @ track(2 * np.pi * RAIL_HZ) @ falling.turn.T
    paths.append(folder / "consistency.png")
    result = consistency(read_paper_table(), track, falling, constant)
    draw_consistency(result, RAIL_HZ, Y[:, 2, 2].real).savefig(paths[-1], dpi=150)
    return paths


if __name__ == "__main__":
    write_figures(Path(sys.argv[1]))
