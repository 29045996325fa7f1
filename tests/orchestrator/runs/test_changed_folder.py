"""An FMU that changes the working directory sends nothing elsewhere: paths are absolute before it is loaded."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import curvesqueal
from fmi3_fmu import write_ssd
from foreign_fmus import U, Y, foreign_fmu
from table_fmus import COMPILER

from orchestrator.library import load, simulate
from orchestrator.results.file import open_results

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")


def wanderer(folder: Path, elsewhere: Path, when: str) -> Path:
    """Write an SSD of an FMU that goes elsewhere when it is made, initialised or stepped."""
    goes = f'extern int chdir(const char*);chdir("{elsewhere}");'
    fmu = foreign_fmu(folder / "goes.fmu", Y + U, **{when: goes})  # type: ignore[arg-type]
    return write_ssd(folder / "s.ssd", {"c": fmu}, [], stop=0.05)


@pytest.mark.parametrize("when", ["create", "init", "step"])
def test_results_are_where_they_were_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, when: str) -> None:
    """Results, picture and CSV, from relative paths."""
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    here.mkdir()
    elsewhere.mkdir()
    wanderer(here, elsewhere, when)
    monkeypatch.chdir(here)
    run = simulate(load("s.ssd", step=1e-3), folder="r", picture=True, csv=True)
    assert Path.cwd() == elsewhere
    assert sorted(p.name for p in elsewhere.iterdir()) == []
    assert {"system.nc", "system.png", "system.csv"} <= {p.name for p in (here / "r").iterdir()}
    with open_results(run.results) as data:
        assert data.sizes["time"] > 10


@pytest.mark.slow
def test_commands_write_where_they_were_told_to(tmp_path: Path) -> None:
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    here.mkdir()
    elsewhere.mkdir()
    wanderer(here, elsewhere, "create")
    done = curvesqueal(
        "run", "s.ssd", "--step", "1e-3", "--out", "r", "--replace", "c=goes.fmu", "--json",
        folder=here,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert Path(json.loads(done.stdout)["results"]).parent == here / "r"
    assert list(elsewhere.iterdir()) == []
    assert {p.name for p in here.iterdir()} == {"goes.fmu", "s.ssd", "r"}
