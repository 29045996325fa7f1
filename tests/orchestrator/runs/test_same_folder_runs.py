"""Two runs at the same time into one folder: both leave their own results."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import Y, foreign_fmu, variable
from table_fmus import COMPILER

from orchestrator.results.file import Column, ResultsFile, open_results


def test_a_name_is_given_once(tmp_path: Path) -> None:
    columns = [Column("a", "m", "")]
    files = [ResultsFile.claim(tmp_path, "case1", columns, {}) for _ in range(3)]
    assert [file.path.name for file in files] == ["case1.nc", "case1-2.nc", "case1-3.nc"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["case1-2.nc", "case1-3.nc", "case1.nc"]
    for file in files:
        file.close()


@pytest.mark.slow
@pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")
def test_two_runs_into_one_folder_are_both_right(tmp_path: Path) -> None:
    """The same system with different parameters, started together."""
    fmu = foreign_fmu(tmp_path / "x.fmu", Y + variable("p", 2, "parameter", start=0), step="m->r[1]=m->r[2]*m->t")
    ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu}, [], stop=1.0)
    command = [
        sys.executable,
        "-m",
        "orchestrator",
        "run",
        str(ssd),
        "--step",
        "1e-4",
        "--json",
        "--out",
        str(tmp_path / "r"),
    ]
    runs = [
        subprocess.Popen([*command, "--set", f"c.p={p}"], stdout=subprocess.PIPE, text=True, env=os.environ)
        for p in (1, 2)
    ]
    paths = [Path(json.loads(run.communicate(timeout=300)[0])["results"]) for run in runs]
    assert sorted(path.name for path in paths) == ["system-2.nc", "system.nc"]
    for factor, path in zip((1, 2), paths, strict=True):
        with open_results(path) as data:
            assert data.sizes["time"] == 2501
            np.testing.assert_allclose(data["c.y"], factor * data["time"], rtol=1e-12)
