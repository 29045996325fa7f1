"""Checkpoint and restart: the run goes on to the bit, whatever happened in between."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from damaged_files import numbers
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu, write_ssd

from orchestrator.coupling.master import Progress
from orchestrator.errors import InputError
from orchestrator.results.file import Column, ResultsFile
from orchestrator.runs.checkpoint import read_checkpoint
from orchestrator.runs.run import Keeping, Report, resume, run_scenario
from orchestrator.runs.scenario import Scenario

STEPS = 400_000
SCENARIO = Scenario("case1", duration=STEPS * 5e-6, seed=5, record_every=300)
QUIET = Report(picture=False)


class PowerCutError(Exception):
    """Stands for a power cut: nothing of the run's own clean-up is done by the master."""


def cut_at(steps: int) -> Report:
    """Return a report that cuts the run off once it has made some steps."""

    def progress(latest: Progress) -> None:
        if latest.steps >= steps:
            raise PowerCutError

    return Report(progress, picture=False)


def test_a_run_goes_on_to_the_bit(tmp_path: Path) -> None:
    """Cut off twice, resumed twice: the results file has the bytes of a run that was never cut."""
    whole = run_scenario(SCENARIO, tmp_path / "whole", QUIET)
    keeping = Keeping(tmp_path / "run.checkpoint", every=0.0)
    with pytest.raises(PowerCutError):
        run_scenario(SCENARIO, tmp_path / "cut", cut_at(900), keeping)
    first = read_checkpoint(keeping.path)
    assert 0 < first.steps < STEPS
    with pytest.raises(PowerCutError):
        resume(keeping.path, cut_at(first.steps + 500), every=0.0)
    assert first.steps < read_checkpoint(keeping.path).steps < STEPS
    end = resume(keeping.path, QUIET, every=0.0)
    assert end.progress.steps == STEPS
    assert numbers(end.results) == numbers(whole.results)
    assert end.progress.energy_residual == whole.progress.energy_residual
    again = resume(keeping.path, QUIET)  # there is nothing left to do
    assert again.progress.steps == STEPS
    assert numbers(again.results) == numbers(whole.results)


@pytest.mark.parametrize(("algorithm", "law"), [("jacobi", 0), ("iterative", 0), ("staggered", 2)])
def test_other_algorithms_and_the_contact_with_memory_go_on_to_the_bit(
    tmp_path: Path, algorithm: str, law: int
) -> None:
    """The tractions that a contact remembers are part of its state."""
    scenario = Scenario("case3", duration=0.003, algorithm=algorithm, values={"contact": {"creep_law": law}})
    whole = run_scenario(scenario, tmp_path / "whole", QUIET)
    keeping = Keeping(tmp_path / "run.checkpoint", every=0.0)
    with pytest.raises(PowerCutError):
        run_scenario(scenario, tmp_path / "cut", cut_at(1), keeping)
    end = resume(keeping.path, QUIET)
    assert numbers(end.results) == numbers(whole.results)


def test_a_killed_process_is_resumed_by_another(tmp_path: Path) -> None:
    """Kill -9 on the command line, then `resume`: the same results as without."""
    options = ["--duration", "0.3", "--json", "--record-every", "8"]
    run = [sys.executable, "-m", "orchestrator", "run", "case2", *options]
    checkpoint = tmp_path / "run.checkpoint"
    keep = ["--checkpoint", str(checkpoint), "--checkpoint-every", "0", "--out", str(tmp_path / "cut")]
    with subprocess.Popen([*run, *keep], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        limit = time.monotonic() + 120
        while not checkpoint.exists() and time.monotonic() < limit:
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
    assert read_checkpoint(checkpoint).steps < 60_000
    command = [sys.executable, "-m", "orchestrator", "resume", str(checkpoint), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert (data["steps"], data["completed"]) == (60_000, True)
    whole = run_scenario(Scenario("case2", duration=0.3, record_every=8), tmp_path / "whole", QUIET)
    assert numbers(Path(data["results"])) == numbers(whole.results)


@pytest.mark.skipif(COMPILER is None, reason="no C compiler for the FMI 3.0 test FMU")
def test_an_fmu_that_cannot_be_kept_is_refused_before_the_run(tmp_path: Path) -> None:
    file = state_space_fmu(tmp_path, "lost", StateSpace([[-1]], [[1]], [[1]]), keeps_state=False)
    ssd = write_ssd(tmp_path / "s.ssd", {"a": file}, [("a.y[1]", "a.u[1]")])
    with pytest.raises(InputError, match=r"checkpoint: a \(lost.fmu\) cannot serialise its state"):
        run_scenario(Scenario(str(ssd), step=0.1, duration=1.0), tmp_path / "r", QUIET, Keeping(tmp_path / "c"))
    assert not (tmp_path / "r").exists()


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the checkpoint of a run that is complete."""
    folder = tmp_path_factory.mktemp("kept")
    run_scenario(Scenario("case4", duration=0.001), folder, QUIET, Keeping(folder / "c"))
    return folder / "c"


def test_what_is_no_checkpoint_is_refused(tmp_path: Path, kept: Path) -> None:
    with pytest.raises(InputError, match="no such checkpoint file"):
        resume(tmp_path / "none", QUIET)
    text = tmp_path / "text"
    text.write_text("no checkpoint")
    broken = tmp_path / "broken"
    broken.write_bytes(kept.read_bytes()[:5000])
    other = tmp_path / "other.npz"
    np.savez(other, a=np.zeros(3))
    for file in (text, broken, other):
        with pytest.raises(InputError, match="is not a checkpoint of curvesqueal"):
            resume(file, QUIET)


def test_a_checkpoint_without_its_results_is_refused(tmp_path: Path) -> None:
    outcome = run_scenario(Scenario("case4", duration=0.001), tmp_path, QUIET, Keeping(tmp_path / "c"))
    data = outcome.results.read_bytes()
    outcome.results.write_bytes(data[:-100])
    with pytest.raises(InputError, match="does not hold the 51 rows that the checkpoint goes on from"):
        resume(tmp_path / "c", QUIET)
    outcome.results.unlink()
    with pytest.raises(InputError, match="cannot go on with these results: No such file"):
        resume(tmp_path / "c", QUIET)


def test_another_fmu_in_a_place_is_refused(tmp_path: Path, built: Path) -> None:
    rail = tmp_path / "rail.fmu"
    rail.write_bytes((built / "rail.fmu").read_bytes())
    scenario = Scenario("case1", duration=0.001, sources={"rail": rail})
    run_scenario(scenario, tmp_path, QUIET, Keeping(tmp_path / "c"))
    rail.write_bytes((built / "rail-paper.fmu").read_bytes())
    with pytest.raises(InputError, match=r"rail \(.*rail.fmu\) is not the FMU that the checkpoint was made with"):
        resume(tmp_path / "c", QUIET)


COLUMNS = [Column("a", "m", ""), Column("b", "m", "")]


def test_reopened_results_drop_what_came_after(tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    with ResultsFile(path, COLUMNS, {}) as file:
        file.append(np.arange(3.0), np.ones((3, 2)))
        before = path.read_bytes()
        file.append(np.arange(3.0), np.zeros((3, 2)))
    with ResultsFile.reopen(path, COLUMNS, {}) as file:
        file.cut(3)
    assert path.read_bytes() == before
