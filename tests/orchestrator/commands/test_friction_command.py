"""Friction laws through the commands: drawn, and in the linear analysis."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import curvesqueal

LAW = "creepage [%]; friction\n0; 0,30\n0,5; 0,29\n1; 0,26\n2; 0,22\n3; 0,20\n5; 0,19\n"


def test_a_file_is_drawn_through_its_points(tmp_path: Path) -> None:
    (tmp_path / "law.csv").write_text(LAW)
    done = curvesqueal("friction", str(tmp_path / "law.csv"), "--out", str(tmp_path / "f.png"), "--json")
    data = json.loads(done.stdout)
    assert data["law.csv"][data["creepage"].index(0.02)] == pytest.approx(0.22, rel=1e-9)
    assert (tmp_path / "f.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_modifier_leaves_fewer_modes_that_squeal(tmp_path: Path) -> None:
    """Case 2: what grows where friction rises grows by coupled directions, and grows where it falls, too."""
    (tmp_path / "law.csv").write_text(LAW)
    found = {}
    for law in (str(tmp_path / "law.csv"), "friction-modifier", "paper"):
        done = curvesqueal("stability", "case2", "--friction", law, "--json")
        found[law] = [u["frequency_hz"] for u in json.loads(done.stdout)["unstable"]]
    plain = [u["frequency_hz"] for u in json.loads(curvesqueal("stability", "case2", "--json").stdout)["unstable"]]
    assert found["paper"] == pytest.approx(plain, rel=1e-9)
    falling, rising = found[str(tmp_path / "law.csv")], found["friction-modifier"]
    assert len(rising) < len(plain) <= len(falling)
    done = curvesqueal("stability", "case2", "--friction", "wet")
    assert done.returncode != 0
    assert "neither one of paper" in done.stderr
