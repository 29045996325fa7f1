"""The page that sets the paper next to this software: its writer, and the parts that are quick to make."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fmus.rail.track_data import TRACKS, read_track
from orchestrator.cli import app
from orchestrator.commands.pages.paper import paper
from orchestrator.errors import InputError
from orchestrator.paper.claims import straight_web_instabilities
from orchestrator.paper.consistency_proof import proof, slope
from orchestrator.paper.drawings import draw_loop
from orchestrator.paper.frequency_domain import receptance_peaks, save
from orchestrator.paper.page import PAGE, Item, relative, write_page
from orchestrator.published.cases import PEAKS_HZ
from orchestrator.stability.loop import linear_contact


def test_page_has_labels_numbers_sentences_and_pictures(tmp_path: Path) -> None:
    picture = tmp_path / "paper" / "a.png"
    item = Item("Table 9", "levels", (("level | A", "dB", 90.0, None, relative(90, 99)),), "All well.", (picture,))
    text = write_page({"stability": [item]}, tmp_path).read_text(encoding="utf-8")
    assert "### Table 9: levels" in text
    assert "| level \\| A | dB | 90 |  | +10.0 % |" in text
    assert "All well." in text
    assert "![Table 9](paper/a.png)" in text


def test_writing_one_part_keeps_the_other(tmp_path: Path) -> None:
    first, second = Item("Table 1", "a", sentence="One."), Item("Figure 8", "b", sentence="Two.")
    write_page({"stability": [first]}, tmp_path)
    write_page({"time": [second]}, tmp_path)
    page = tmp_path / PAGE
    both = page.read_text(encoding="utf-8")
    assert both.index("One.") < both.index("Two.")
    write_page({"time": [second]}, tmp_path)
    assert page.read_text(encoding="utf-8") == both


def test_unknown_part_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"--only sound: must be one of stability, time"):
        paper(out=tmp_path, only="sound", results=tmp_path / "none")


def test_time_domain_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none: has no results of the four cases"):
        paper(out=tmp_path, only="time", results=tmp_path / "none")


def test_command_is_there() -> None:
    assert "--only" in CliRunner().invoke(app, ["paper", "--help"]).output


def test_peaks_of_the_track_are_those_of_figure_3() -> None:
    """80 and 700 Hz are read from a figure: 1 %."""
    assert receptance_peaks(read_track(TRACKS / "default.toml")) == pytest.approx(PEAKS_HZ, rel=0.01)


def test_proof_names_the_modes_that_are_excluded(tmp_path: Path) -> None:
    item = proof(tmp_path)
    assert {row[0].split(":")[0] for row in item.rows if row[4] == "excluded"} == {"(0,0)", "(3,0)"}
    assert all(figure.is_file() for figure in item.figures)


def test_the_slope_that_the_table_tells_is_a_quarter_of_the_printed_one(tmp_path: Path) -> None:
    """At s = 1 no fit comes below rms 0.15; between 0.15 and 0.3 all are below 0.035."""
    item = slope(tmp_path)
    rms = {float(row[0].rpartition("= ")[2]): float(row[3] or "nan") for row in item.rows if "s = " in row[0]}
    assert rms[1.0] > 0.15
    assert all(rms[s] < 0.035 for s in (0.15, 0.2, 0.25, 0.3))
    assert all(figure.is_file() for figure in item.figures)


def test_straight_web_is_stable_without_contact_angle_only() -> None:
    """Stable at 0 degrees as the paper says; at 3 degrees not."""
    assert straight_web_instabilities(0.0, 1.2e9) == 0
    assert straight_web_instabilities(3.0, 1.2e9) > 0


def test_same_drawing_makes_the_same_small_picture(tmp_path: Path) -> None:
    one, two = (save(draw_loop(linear_contact()), tmp_path / name).read_bytes() for name in ("1.png", "2.png"))
    assert one == two
    assert len(one) < 100_000
