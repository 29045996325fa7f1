"""Labels of logarithmic axes in the style of the figures, which reads no mathematics."""

from __future__ import annotations

import io

import matplotlib as mpl
from matplotlib.figure import Figure

from orchestrator.figures.style import STYLE, plain_ticks


def test_labels_of_logarithmic_axes_are_numbers() -> None:
    """Without mathematics the labels that come with such axes show as they are written, dollar signs and all."""
    with mpl.rc_context(STYLE):
        figure = Figure()
        figure.subplots().loglog([1e-4, 10.0], [1e2, 1e4])
        plain_ticks(figure).savefig(io.BytesIO())
    for axis in (figure.axes[0].xaxis, figure.axes[0].yaxis):
        labels = [label.get_text() for label in axis.get_majorticklabels()]
        assert labels
        assert all(float(text) > 0 for text in labels if text)
