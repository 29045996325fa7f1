"""The figure of friction curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from ..visible import visible
from .style import STYLE


def draw_friction(
    creepage: np.ndarray,
    curves: dict[str, np.ndarray],
    path: Path,
    points: Mapping[str, Sequence[tuple[float, float]]] | None = None,
) -> None:
    """Draw friction force over normal force against lateral creepage, as in Fig. 5 of the paper.

    Parameters
    ----------
    creepage : (n,) lateral creepages [-]
    curves : (n,) ratios by label
    path : picture to write
    points : of friction tables, by label of their curve: creepage and friction coefficient
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.5, 3.6))
        axes = figure.subplots(gridspec_kw={"left": 0.12, "right": 0.96, "bottom": 0.14, "top": 0.96})
        for (label, ratio), line in zip(curves.items(), cycle(("-", "--", "-.", ":")), strict=False):
            axes.plot(creepage, ratio, line, label=visible(label), color="black")
        for (label, pairs), marker in zip((points or {}).items(), cycle("osv^"), strict=False):
            x, y = zip(*pairs, strict=True)
            axes.plot(x, y, marker, label=f"{visible(label)}: points", color="black", markersize=4, fillstyle="none")
        axes.set(xlabel="Lateral creepage [-]", ylabel="Friction force / normal force [-]", xlim=(0, creepage[-1]))
        axes.set_ylim(0, None)
        axes.legend(loc="lower right")
        figure.savefig(path, dpi=150)
