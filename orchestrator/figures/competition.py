"""The figure of a competition of tones."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import matplotlib as mpl
from matplotlib.figure import Figure

if TYPE_CHECKING:
    from ..signals.tones import Tone
from ..visible import visible
from .style import COLOURS, STYLE


def draw_competition(title: str, groups: dict[str, list[Tone]], path: Path) -> None:
    """Draw how often each tone won, with confidence intervals; one group of bars per kind of start."""
    rows = [(words, tone) for words, tones in groups.items() for tone in tones]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 1.2 + 0.36 * len(rows)), layout="constrained")
        axes = figure.subplots()
        for y, (_, tone) in enumerate(rows):
            reach = [[100 * (tone.share - tone.low)], [100 * (tone.high - tone.share)]]
            axes.barh(y, 100 * tone.share, color=COLOURS["wheel"], alpha=0.75, height=0.6)
            axes.errorbar(100 * tone.share, y, xerr=reach, color="black", capsize=3, linewidth=1)
        labels = [tone.words for _, tone in rows]
        if len(groups) > 1:
            labels = [f"{words}: {label}" for (words, _), label in zip(rows, labels, strict=True)]
        axes.set_yticks(range(len(rows)), [visible(label) for label in labels])
        axes.invert_yaxis()
        axes.set(xlim=(0, 100), xlabel="Runs that end in this tone [%], 95 % confidence", title=visible(title))
        axes.grid(visible=False, axis="y")
        figure.savefig(path, dpi=150)
