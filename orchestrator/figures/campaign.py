"""Pictures of a campaign: values over two factors, shares of a variance; data in, PNG, PDF or SVG files out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import CenteredNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..visible import visible
from .style import COLOURS, STYLE

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Grid:
    """A quantity over two factors.

    Attributes
    ----------
    title : of the picture
    x_label, y_label, label : of the axes and of the colours, with units
    x, y : levels of the factors
    x_texts, y_texts : names of the levels; empty for numbers
    value : (y, x); NaN where nothing is known
    signed : whether the sign of the value decides about squeal: colours part at zero, where a line is drawn
    """

    title: str
    x_label: str
    y_label: str
    label: str
    x: Real
    y: Real
    x_texts: Sequence[str]
    y_texts: Sequence[str]
    value: Real
    signed: bool


def draw_grid(grid: Grid, path: Path) -> None:
    """Draw a map: one rectangle per cell, the border of squeal as a line, cells without runs grey."""
    with mpl.rc_context({**STYLE, "axes.grid": False}):
        figure = Figure(figsize=(6.5, 4.5), layout="constrained")
        axes = figure.subplots()
        axes.set_facecolor("#d9d9d9")
        look: Any = {"cmap": "RdBu_r", "norm": CenteredNorm(0.0)} if grid.signed else {"cmap": "viridis"}
        x, y = _edges(grid.x, bool(grid.x_texts)), _edges(grid.y, bool(grid.y_texts))
        mesh = axes.pcolormesh(x, y, np.ma.masked_invalid(grid.value), **look)
        bar = figure.colorbar(mesh, ax=axes, label=grid.label)
        if grid.signed:
            bar.ax.set_ylim(min(0.0, np.nanmin(grid.value)), max(0.0, np.nanmax(grid.value)))
            _border(axes, grid)
        axes.set(xlabel=visible(grid.x_label), ylabel=visible(grid.y_label), title=visible(grid.title))
        for values, texts, put in ((grid.x, grid.x_texts, axes.set_xticks), (grid.y, grid.y_texts, axes.set_yticks)):
            if texts:
                put(values, texts)
        figure.savefig(path, dpi=200)


def _border(axes: Axes, grid: Grid) -> None:
    """Draw where the value changes its sign, if both axes have at least two levels."""
    finite = grid.value[np.isfinite(grid.value)]
    if min(grid.value.shape) > 1 and finite.size and finite.min() < 0 < finite.max():
        axes.contour(grid.x, grid.y, grid.value, levels=[0.0], colors="black", linewidths=1.2)
        axes.plot([], [], color="black", linewidth=1.2, label="border of squeal")
        axes.legend(loc="upper right", frameon=True, fontsize=8)


def _edges(levels: Real, texts: bool) -> Real:
    """Return the borders of cells about their levels, in equal ratios where the levels are."""
    if texts or len(levels) < 2:
        half = 0.5 if texts or not levels[0] else abs(levels[0]) / 2
        return np.concatenate([levels - half, levels[-1:] + half])
    log = levels[0] > 0 and np.allclose(levels[1:] / levels[:-1], levels[1] / levels[0]) and len(levels) > 2
    place = np.log(levels) if log else levels
    inner = (place[1:] + place[:-1]) / 2
    edges = np.concatenate([[2 * place[0] - inner[0]], inner, [2 * place[-1] - inner[-1]]])
    return np.exp(edges) if log else edges


@dataclass(frozen=True)
class Share:
    """A number between zero and one with its interval."""

    value: float
    low: float
    high: float


def draw_indices(title: str, names: Sequence[str], first: Sequence[Share], total: Sequence[Share], path: Path) -> None:
    """Draw first-order and total Sobol indices of each factor with their intervals."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.5, 1.4 + 0.55 * len(names)), layout="constrained")
        axes = figure.subplots()
        place = np.arange(len(names))
        for shares, shift, colour, words in (
            (first, -0.19, COLOURS["wheel"], "first order: by itself"),
            (total, 0.19, COLOURS["rail"], "total: with the others"),
        ):
            value = np.array([s.value for s in shares])
            reach = [value - [s.low for s in shares], [s.high for s in shares] - value]
            axes.barh(place + shift, value, 0.36, color=colour, alpha=0.75, label=words)
            axes.errorbar(value, place + shift, xerr=np.maximum(reach, 0), fmt="none", color="black", capsize=3)
        axes.set_yticks(place, names)
        axes.invert_yaxis()
        axes.set(xlabel="Share of the variance [-], 95 % bootstrap interval", title=title)
        axes.grid(visible=False, axis="y")
        axes.legend(loc="lower right")
        figure.savefig(path, dpi=200)
