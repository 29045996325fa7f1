"""Figures of stability: results in, Nyquist and Bode diagrams of eigenloci and the consistency of Table 4 out.

`python -m orchestrator.report_stability FOLDER` writes them for the four cases.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..stability.analysis import REPORTED_BELOW_HZ, Stability
from ..stability.eigenloci import Eigenloci
from ..visible import visible
from .style import PLAIN

COLOURS = ("#9a9a9a", "#0b5394", "#c2570c")
STYLES: Any = ("--", "-", ":")


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
    words = f"{visible(title)}: eigenloci of H1 G + H2, in the order of their largest modulus"
    figure.suptitle(words, fontsize="medium", **PLAIN)
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
