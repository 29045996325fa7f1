"""Competition of tones: statistics against closed forms, starts as asked for, nothing lost and nothing done twice."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from command_line import curvesqueal

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.runs.competition import START_VELOCITY, Trial, mode_start, plan, read_endings, run_trial
from orchestrator.signals.tones import tones
from orchestrator.system.reader import read_system


def test_frequencies_are_gathered_into_tones() -> None:
    found = tones([1100.2, 1979.0, None, 1983.8, 1099.6, 1978.0, None])
    assert [(t.count, t.of) for t in found] == [(3, 7), (2, 7), (2, 7)]
    assert found[0].frequency_hz == pytest.approx(1980.27, abs=0.01)
    assert None in (found[1].frequency_hz, found[2].frequency_hz)
    assert pytest.approx(1099.9) in (found[1].frequency_hz, found[2].frequency_hz)


@pytest.mark.parametrize("n", [1, 20, 24])
def test_confidence_interval_of_a_sure_thing(n: int) -> None:
    """Clopper and Pearson in closed form: n of n has the lower end (alpha/2)^(1/n) and the upper end 1."""
    tone = tones([1978.0] * n)[0]
    assert (tone.share, tone.high) == (1.0, 1.0)
    assert tone.low == pytest.approx(0.025 ** (1 / n), rel=1e-9)


def test_plan_is_every_combination() -> None:
    trials = plan("case1", 3, 7, [1100.0, 1976.0], [1.1e9, 1.2e9])
    assert len(trials) == len(set(trials)) == 12
    assert {t.seed for t in trials} == {7, 8, 9}
    assert plan("case1", 1, 0, [], []) == [Trial("case1", 0)]


@pytest.mark.parametrize(
    ("how", "message"),
    [((0, 0, [], []), "--runs 0: must be at least 1"), ((1, -1, [], []), "--seed -1: must be >= 0"),
     ((1, 0, [], [-1.0]), "--stiffness -1: must be > 0")],
)  # fmt: skip
def test_bad_plans_are_one_sentence(how: tuple[int, int, list[float], list[float]], message: str) -> None:
    with pytest.raises(InputError, match=message):
        plan("case1", *how)


def test_a_chosen_mode_starts_at_the_given_velocity(built: Path) -> None:
    """The contact point moves at 0.1 m/s laterally at the start, and at the mode's frequency."""
    assembly = assemble(read_system(built / "curvesqueal.ssp"))
    start = mode_start(assembly.fmus["wheel"], {}, 1100.0)
    assert len(start) == 1
    assembly.parameters["wheel"].update(start)
    with Master(assembly, Settings(5e-6, 1e-5)) as master:
        lateral = master.plan.y[master.outputs.index(("wheel", "v_lat"))]
    assert abs(lateral) == pytest.approx(START_VELOCITY, rel=1e-9)


def test_a_mode_that_is_not_there_is_refused(built: Path) -> None:
    wheel = assemble(read_system(built / "curvesqueal.ssp")).fmus["wheel"]
    with pytest.raises(InputError, match=r"no lateral mode within 2 % of 700 Hz; its strong ones are at .*418, 1102"):
        mode_start(wheel, {}, 700.0)


def test_a_trial_repeats_with_its_seed_and_depends_on_it() -> None:
    trial = Trial("case1", 3, duration=0.01)
    first, again = run_trial(trial), run_trial(trial)
    assert first == again
    assert run_trial(replace(trial, seed=4)).lateral_rms != first.lateral_rms


def test_runs_are_kept_and_not_made_again(tmp_path: Path) -> None:
    """Two runs, then three: one more line in the file; a half-written last line is dropped."""
    command = ("competition", "case1", "--duration", "0.005", "--jobs", "1", "--json", "--out", str(tmp_path))
    done = curvesqueal(*command, "--runs", "2")
    assert done.returncode == 0, done.stderr
    path = tmp_path / "competition-case1.jsonl"
    before = path.read_text()
    path.write_text(before + '{"trial": {"system": "ca')
    data = json.loads(curvesqueal(*command, "--runs", "3").stdout)
    assert (data["done"], data["wanted"]) == (3, 3)
    assert path.read_text().startswith(before)
    assert len(read_endings(path)) == 3
    shares = [tone["share"] for tone in data["starts"]["random start"]]
    assert sum(shares) == pytest.approx(1.0)
    assert (tmp_path / "competition-case1.png").stat().st_size > 5_000


def test_a_foreign_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "competition-case1.jsonl"
    path.write_text('{"hello": 1}\n')
    with pytest.raises(InputError, match="line 1: is no trial of a competition; give another folder"):
        read_endings(path)


@pytest.mark.slow
def test_an_interrupted_competition_keeps_its_runs(tmp_path: Path) -> None:
    """Ctrl-C after the first run: exit code 130, a sentence, and the runs that were done."""
    command = [sys.executable, "-m", "orchestrator", "competition", "case2", "--runs", "50", "--duration", "0.05",
               "--jobs", "2", "--out", str(tmp_path)]  # fmt: skip
    path = tmp_path / "competition-case2.jsonl"
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        limit = time.monotonic() + 120
        while not (path.exists() and path.stat().st_size > 0) and time.monotonic() < limit:
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "of 50 runs; the same command goes on from there" in " ".join(err.split())
    assert "Traceback" not in err
    assert 0 < len(read_endings(path)) < 50
