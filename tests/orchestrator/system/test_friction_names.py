"""Friction laws by name or file: what they mean, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.contact.friction.file import read_friction
from fmus.contact.friction.named import NAMED, friction_table
from orchestrator.errors import InputError
from orchestrator.fmi.instance import open_fmu
from orchestrator.system.cases import find_system
from orchestrator.system.friction import beyond_table, friction_values
from orchestrator.system.settable import spread

GOOD = {
    "creepage,friction\n0,0.3\n0.02,0.25\n": ((0.0, 0.02), (0.3, 0.25), "creepage"),
    "# tribometer\nCreepage [%];Friction coefficient\n0;0,3\n2;0,25\n": ((0.0, 0.02), (0.3, 0.25), "creepage"),
    "velocity [mm/s]\tmu\n10\t0.3\n200\t0.25\n": ((0.01, 0.2), (0.3, 0.25), "velocity"),
}

BAD = {
    "creepage,friction\n0,0.3\n0.02,0.2\n0.01,0.2\n": "line 4: creepage must rise from point to point; got 0.01 after",
    "creepage,friction\n0,0.3\n0.02,-0.2\n": "law.csv, line 3: friction must be above 0 and at most 2; got -0.2",
    "creepage,friction\n0,0.3\n": "law.csv: must have 2 to 50 points; has 1",
    "creepage,friction\n0,0.3\n0.02,much\n": "law.csv, line 3: must have a number in column 2; got 'much'",
    "velocity,friction\n0,0.3\n1,0.2\n": r"law.csv, line 1: velocity has no unit; must be one such as velocity \[m/s\]",
    "velocity [kg],friction\n0,0.3\n1,0.2\n": "law.csv, line 1: velocity: unit 'kg' is no velocity",
    "creepage [m],friction\n0,0.3\n1,0.2\n": "law.csv, line 1: creepage is in 'm'; must be in - or %",
    "x,friction\n0,0.3\n1,0.2\n": "law.csv, line 1: must have one column creepage or velocity; has x, friction",
    "creepage,force [N]\n0,0.3\n1,0.2\n": "law.csv, line 1: must have one column friction; has creepage, force",
    "": "law.csv: is empty",
}


@pytest.mark.parametrize("text", GOOD)
def test_files_are_tables(tmp_path: Path, text: str) -> None:
    (tmp_path / "law.csv").write_text(text)
    x, y, over = GOOD[text]
    assert read_friction(tmp_path / "law.csv") == pytest.approx(friction_table(x, y, over))


@pytest.mark.parametrize("text", BAD)
def test_bad_files_are_refused_with_their_line(tmp_path: Path, text: str) -> None:
    (tmp_path / "law.csv").write_text(text)
    with pytest.raises(InputError, match=BAD[text]):
        friction_values(str(tmp_path / "law.csv"))


def test_what_is_no_law_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"friction nothing: neither one of paper, constant, de-beer, .* nor a file"):
        friction_values("nothing")
    (tmp_path / "law.csv").write_text("creepage,friction\n0,0.3\n0.02,0.25\n")
    with pytest.raises(InputError, match=r"friction comes from the table law\.csv, so it has no effect"):
        friction_values(str(tmp_path / "law.csv"), {"mu0": 0.4})


def test_friction_of_a_contact_stands_for_its_parameters() -> None:
    """Set by name; what is set besides wins."""
    fmus = {"contact": open_fmu(find_system("case1").elements["contact"].source)}
    found = spread({"contact": {"friction": "polach-dry", "polach_decay": 0.5}}, fmus)
    assert found == {"contact": {**NAMED["polach-dry"].values, "polach_decay": 0.5}}


@pytest.mark.parametrize(
    ("header", "steady", "said"),
    [
        ("creepage", 0.02, None),
        ("creepage", 0.031, "goes from 0 to 0.03; at the steady creepage of 0.031 the curve is continued"),
        ("velocity [m/s]", 0.002, None),
        ("velocity [m/s]", 0.02, "goes from 0 to 0.03; at the steady sliding velocity of 0.2 m/s"),
    ],
)
def test_a_table_that_ends_before_the_steady_creepage_is_told(
    tmp_path: Path, header: str, steady: float, said: str | None
) -> None:
    (tmp_path / "law.csv").write_text(f"{header},friction\n0,0.3\n0.03,0.25\n")
    values = {"steady_creepage_lon": 0.0, "steady_creepage_lat": steady, "rolling_velocity": 10.0}
    sentence = beyond_table({**values, **friction_values(str(tmp_path / "law.csv"))})
    assert (sentence is None) if said is None else (sentence is not None and said in sentence)
