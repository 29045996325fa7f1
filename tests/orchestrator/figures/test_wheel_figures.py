"""Figures of wheels: they are drawn, labelled and to scale."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.wheel.finite_elements.section import read_section
from fmus.wheel.wheelset import DATA
from orchestrator.figures.wheel import WHEEL_MODES, WHEELSET_MODES, plot_modes, plot_sections

GENERIC = read_section(DATA / "generic840-section.toml")


def test_sections_are_drawn_to_scale_with_units(tmp_path: Path) -> None:
    """Both directions have one scale, in mm, and the wheel's outline is within the frame."""
    figure = plot_sections([GENERIC, read_section(DATA / "straight840-section.toml")])
    figure.savefig(tmp_path / "sections.png")
    assert len(figure.axes) == 2
    for axes in figure.axes:
        assert axes.get_aspect() == 1.0
        assert (axes.get_xlabel(), axes.get_ylabel()) == ("$z$ [mm]", "$r$ [mm]")
        low, high = axes.get_ylim()
        assert low <= 0.0
        assert high > 448.0


@pytest.mark.slow
def test_every_mode_of_table_4_is_drawn(tmp_path: Path) -> None:
    """Eleven panels and a colour bar; each says its label and frequency."""
    figure = plot_modes(GENERIC)
    figure.savefig(tmp_path / "modes.png")
    *panels, bar = figure.axes
    assert len(panels) == len(WHEELSET_MODES) + len(WHEEL_MODES) == 11
    titles = [axes.get_title() for axes in panels]
    assert all(title.endswith(" Hz") for title in titles)
    for label in ("axle", "(1,0)", "(0,0)", "(2,0)", "(2,r)", "(6,0)"):
        assert any(title.startswith(label) for title in titles), label
    assert bar.get_xlabel() == "displacement in the section, relative to its largest"
    frequencies = [float(title.split()[-2]) for title in titles[len(WHEELSET_MODES) :]]
    assert frequencies == sorted(frequencies)
    assert frequencies[0] == pytest.approx(417, abs=1)  # printed without decimals, coarsest mesh
