"""Drawings of the models of the paper, its Figs 1 and 2, with the numbers of this software in them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Rectangle

from fmus.contact.linearised import LinearContact
from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes

_FONT = 9
_INK = "black"
_FILL = "#e8eef7"


def draw_loop(contact: LinearContact) -> Figure:
    """Return the self-excited vibration loop, Fig. 1, with the entries that matter for lateral motion."""
    figure = Figure(figsize=(7.2, 3.0), layout="constrained")
    axes = _canvas(figure, (0, 10), (0, 4.2))
    slope, per_load = contact.H1[1, 1], contact.h2[1]
    _box(axes, (2.6, 3.0), f"G\nmobility of wheel, rail and spring\n$K_H$ = {contact.stiffness:.3g} N/m")
    _box(axes, (7.4, 3.0), f"$H_1$\nslopes of the friction law\nlateral: {slope:.0f} N s/m")
    _box(axes, (5.0, 0.9), f"$H_2$\nfriction by the normal force\nlateral: {per_load:.3f} N/N")
    axes.plot(9.6, 1.9, "o", markersize=16, markerfacecolor="white", markeredgecolor=_INK)
    axes.text(9.6, 1.9, "+", ha="center", va="center", fontsize=_FONT + 3)
    _arrow(axes, ((4.25, 3.0), (5.75, 3.0)))
    axes.text(5.0, 3.15, "$V^s$", ha="center", fontsize=_FONT)
    _arrow(axes, ((9.05, 3.0), (9.6, 3.0), (9.6, 2.2)))
    _arrow(axes, ((6.65, 0.9), (9.6, 0.9), (9.6, 1.6)))
    _arrow(axes, ((9.3, 1.9), (0.4, 1.9), (0.4, 3.0), (0.95, 3.0)))
    _arrow(axes, ((1.6, 1.9), (1.6, 0.9), (3.35, 0.9)))
    axes.text(7.2, 2.02, "$F^f$, friction forces on the wheel", ha="center", fontsize=_FONT)
    return figure


def draw_modal_rail(rail: Modes, direction: str = "ver") -> Figure:
    """Return the spring-mass model of one direction of the rail, Fig. 2: one oscillator per mode."""
    column = DIRECTIONS.index(direction)
    modes = rail.keep(np.flatnonzero(rail.shape[:, column]))
    n = len(modes)
    figure = Figure(figsize=(7.2, 3.4), layout="constrained")
    axes = _canvas(figure, (-0.6, 2.4 * n + 0.6), (-0.2, 4.6))
    axes.plot((0, 2.4 * n), (3.6, 3.6), color=_INK, linewidth=2.5)
    axes.annotate("", (1.2 * n, 3.65), (1.2 * n, 4.4), arrowprops={"arrowstyle": "-|>", "lw": 1.5})
    axes.text(1.2 * n + 0.1, 4.1, f"$F$ ({direction}); the motions of all modes add up", fontsize=_FONT)
    for k, (omega, zeta, shape) in enumerate(zip(modes.omega, modes.zeta, modes.shape[:, column], strict=True)):
        x = 2.4 * k + 1.2
        mass = 1 / shape**2
        axes.plot((x, x), (3.6, 2.9), color=_INK, linewidth=1)
        axes.add_patch(Rectangle((x - 0.55, 2.3), 1.1, 0.6, facecolor=_FILL, edgecolor=_INK))
        axes.text(x, 2.6, f"{mass:.3g} kg", ha="center", va="center", fontsize=_FONT)
        _spring(axes, x - 0.35, (0.9, 2.3))
        _damper(axes, x + 0.35, (0.9, 2.3))
        _ground(axes, x)
        extra = "extra mode\n" if omega > 2 * np.pi * 1e4 else ""
        axes.text(
            x, 0.62, f"{extra}{omega / (2 * np.pi):.0f} Hz\n$\\zeta$ = {zeta:.3g}", ha="center", va="top",
            fontsize=_FONT,
        )  # fmt: skip
    return figure


def _canvas(figure: Figure, x: tuple[float, float], y: tuple[float, float]) -> Axes:
    axes = figure.subplots()
    axes.set(xlim=x, ylim=y)
    axes.axis("off")
    return axes


def _box(axes: Axes, middle: tuple[float, float], text: str) -> None:
    x, y = middle
    axes.add_patch(
        FancyBboxPatch((x - 1.6, y - 0.55), 3.2, 1.1, boxstyle="round,pad=0.05", facecolor=_FILL, edgecolor=_INK)
    )
    axes.text(x, y, text, ha="center", va="center", fontsize=_FONT)


def _arrow(axes: Axes, points: Sequence[tuple[float, float]]) -> None:
    """Draw a line along some points with a head at its end."""
    x, y = zip(*points[:-1], strict=True)
    axes.plot(x, y, color=_INK, linewidth=1.2, solid_joinstyle="miter")
    axes.annotate("", points[-1], points[-2], arrowprops={"arrowstyle": "-|>", "lw": 1.2, "shrinkA": 0, "shrinkB": 0})


def _spring(axes: Axes, x: float, ends: tuple[float, float]) -> None:
    y = np.linspace(*ends, 12)
    side = np.array([0, 0, *([1, -1] * 4), 0, 0]) * 0.14
    axes.plot(x + side, y, color=_INK, linewidth=1)


def _damper(axes: Axes, x: float, ends: tuple[float, float]) -> None:
    low, high = ends
    middle = 0.5 * (low + high)
    axes.plot((x, x), (low, middle - 0.2), color=_INK, linewidth=1)
    axes.plot((x - 0.15, x - 0.15, x + 0.15, x + 0.15), (middle + 0.2, middle - 0.2, middle - 0.2, middle + 0.2),
              color=_INK, linewidth=1)  # fmt: skip
    axes.plot((x - 0.11, x + 0.11), (middle, middle), color=_INK, linewidth=1.6)
    axes.plot((x, x), (middle, high), color=_INK, linewidth=1)


def _ground(axes: Axes, x: float) -> None:
    axes.plot((x - 0.7, x + 0.7), (0.9, 0.9), color=_INK, linewidth=1.2)
    for k in np.linspace(-0.6, 0.6, 7):
        axes.plot((x + k, x + k - 0.12), (0.9, 0.76), color=_INK, linewidth=0.7)
