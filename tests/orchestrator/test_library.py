"""The master as a library: five lines, progress, xarray, errors."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from toy_fmus import toy_fmu, toy_ssd

import orchestrator
from orchestrator import InputError, Progress, SimulationError, load, resume, simulate

SCRIPT = """
from orchestrator import load, simulate
scenario = load("case1", duration=0.05, values={{"contact": {{"mu0": 0.35}}}})
run = simulate(scenario, folder={folder!r}, progress=lambda p: print(p.steps, "of", p.total))
print(run.data["wheel.v_lat"].attrs["units"], run.summary.dominant_frequency_hz)
"""


def test_five_lines_in_a_process_of_their_own(tmp_path: Path) -> None:
    """The snippet of the README: it reports progress, has results with units, and the process ends well."""
    script = SCRIPT.format(folder=str(tmp_path))
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120)
    lines = done.stdout.splitlines()
    assert lines[-2] == "10000 of 10000", done.stderr
    assert lines[-1].startswith("m/s ")
    assert done.returncode == 0, done.stderr


def test_readme_shows_these_lines() -> None:
    readme = (Path(__file__).parents[2] / "README.md").read_text()
    snippet = [line for line in SCRIPT.format(folder="results").strip().splitlines() if "print(run" not in line]
    for line in snippet:
        assert line.replace("'", '"') in readme


def test_outcome_has_everything(tmp_path: Path) -> None:
    seen: list[int] = []

    def follow(progress: Progress) -> None:
        seen.append(progress.steps)

    scenario = load("case4", duration=0.005, step=1e-5, record_every=2)
    run = simulate(scenario, folder=tmp_path, progress=follow, checkpoint=tmp_path / "c")
    assert seen[-1] == 500
    assert run.data.sizes["time"] == 251
    assert run.data["contact.normal_force"].attrs["units"] == "N"
    assert run.picture is None
    assert run.progress.energy_residual.keys() == {"lon", "lat", "normal", "spin"}
    assert resume(tmp_path / "c").progress.steps == 500


def test_mistakes_and_failures_are_exceptions(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="case5: neither a case"):
        load("case5")
    with pytest.raises(InputError, match=r"parameter contact.mu0 = 9: must be in the range"):
        load("case1", values={"contact": {"mu0": 9}})
    good = toy_fmu(tmp_path, "Good", "self.y = 0.5 * self.u")
    bad = toy_fmu(tmp_path, "Bad", "self.y = float('nan') if self.steps == 9 else 0.0")
    scenario = load(toy_ssd(tmp_path, good, bad), step=1e-4, duration=0.01, algorithm="jacobi", record_every=1)
    with pytest.raises(
        SimulationError, match=r"b: output y = nan at t = 0.0008 s.*results up to then are in .*ring.nc"
    ):
        simulate(scenario, folder=tmp_path)


def test_public_names_are_documented() -> None:
    for name in orchestrator.__all__:
        assert getattr(orchestrator, name).__doc__, name
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        orchestrator.nothing  # noqa: B018
