"""The figures of the rail's receptance and the table beside them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.interface import DIRECTIONS
from fmus.modal.data import read_modal_data
from fmus.rail.component import DATA
from fmus.rail.track_data import TRACKS, read_track
from orchestrator.figures.receptance import draw_receptance, modal_rails, receptance_errors, write_receptance

TRACK = read_track(TRACKS / "default.toml")
RAILS = modal_rails(TRACK, read_modal_data(DATA / "rail.toml").modes)


def test_every_panel_compares_four_curves_with_units() -> None:
    figure = draw_receptance(TRACK, RAILS)
    assert len(figure.axes) == 2 * len(DIRECTIONS)
    for axis in figure.axes:
        assert len(axis.get_lines()) == 1 + len(RAILS)
        assert "[" in axis.get_ylabel()
    assert [axis.get_xlabel() for axis in figure.axes[len(DIRECTIONS) :]] == ["frequency [Hz]"] * len(DIRECTIONS)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["analytical", *RAILS]


def test_the_phase_of_every_curve_is_that_of_a_passive_point() -> None:
    """Re Y >= 0 means a receptance between 0 and -180 degrees: nothing is cut off below the panel."""
    for axis in draw_receptance(TRACK, RAILS).axes[len(DIRECTIONS) :]:
        for line in axis.get_lines():
            phase = np.asarray(line.get_ydata(), dtype=float)
            assert phase.max() <= 0.0
            assert phase.min() >= -180.0


def test_the_table_orders_the_rails() -> None:
    """Accurate is better than the paper's with the extra mode, and this better than without, in every direction."""
    errors = receptance_errors(TRACK, RAILS)
    assert list(errors) == ["paper, without extra mode", "paper, with extra mode", "accurate"]
    for direction in DIRECTIONS:
        without, with_extra, accurate = (errors[name][direction]["rms_db"] for name in errors)
        assert accurate < with_extra < without


@pytest.mark.slow
def test_the_figures_are_written(tmp_path: Path) -> None:
    paths = write_receptance(TRACK, RAILS, tmp_path / "figures")
    assert [p.name for p in paths] == ["receptance.png", "figure-3.png", "figure-4.png"]
    assert all(p.stat().st_size > 10_000 for p in paths)
