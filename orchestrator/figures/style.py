"""One style for all figures: colours, line styles, words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STYLE: Any = {
    "font.size": 9,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "lines.linewidth": 0.9,
    "text.parse_math": False,  # a name may hold a dollar sign
}

COLOURS: Any = {"wheel": "#0b5394", "rail": "#c2570c"}

LINES: Any = {"wheel": "-", "rail": "--"}

PLAIN: Any = {"parse_math": False}
"""Of a text with a name from a file, in figures of another style."""

WORDS = {"lat": "Lateral", "ver": "Vertical"}


def plain_ticks(figure: Figure) -> Figure:
    """Give logarithmic axes labels that need no mathematics, which `STYLE` does not set; return the figure."""
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            if axis.get_scale() == "log":
                axis.set_major_formatter(lambda value, _: f"{value:g}")
    return figure
