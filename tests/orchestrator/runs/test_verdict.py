"""The verdict: a run that squeals, one that does not, one that is too short, and one that is not to be trusted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from orchestrator.results.samples import Samples
from orchestrator.runs.outcome import as_json
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.runs.verdict import verdict

QUIET = Report(picture=False)


@pytest.mark.slow
def test_a_squealing_case_says_tone_mode_and_level(tmp_path: Path) -> None:
    """Case 1 for 1.5 s: the paper's 1100 Hz, which is the wheel's (3,0) (Table 4)."""
    outcome = run_scenario(Scenario("case1", duration=1.5), tmp_path, QUIET)
    answer = outcome.verdict
    assert answer.squeals is True
    assert answer.tone_hz == pytest.approx(1100, rel=0.01)
    assert answer.mode == "(3,0)"
    assert answer.level_dba is not None
    assert answer.level_dba_band is not None
    assert answer.level_dba_band[0] < answer.level_dba < answer.level_dba_band[1]
    data = json.loads(as_json(outcome))
    assert (data["squeals"], data["mode"]) == (True, "(3,0)")
    assert data["level_dba_band"] == list(answer.level_dba_band)
    assert data["trust"]["verdict"] in ("good", "doubtful")


def test_a_quiet_run_names_no_tone(tmp_path: Path) -> None:
    """Without friction nothing grows: the pulse rings down, and a strongest line is no squeal."""
    scenario = Scenario("case1", duration=0.05, values={"contact": {"mu0": "0"}})
    answer = run_scenario(scenario, tmp_path, QUIET).verdict
    assert answer.squeals is False
    assert (answer.tone_hz, answer.mode, answer.level_dba, answer.level_dba_band) == (None, None, None, None)
    assert "does not squeal:" in answer.sentence
    assert answer.trust == "good"


def test_a_run_that_ends_before_the_growth_does_not_call_the_case_quiet(tmp_path: Path) -> None:
    """Case 1 has an unstable mode at 1100 Hz (Table 4), which 20 ms from a small pulse do not show."""
    answer = run_scenario(Scenario("case1", duration=0.02), tmp_path, QUIET).verdict
    assert (answer.squeals, answer.trust) == (False, "doubtful")
    assert answer.sentence.startswith("does not squeal yet: 1101 Hz grows by")


def test_a_scheme_that_invents_instability_is_not_trusted(tmp_path: Path) -> None:
    """Case 2 by Jacobi at 20 us: docs/adr/0003; the sentence stands beside the result."""
    scenario = Scenario("case2", duration=0.01, step=2e-5, algorithm="jacobi")
    answer = run_scenario(scenario, tmp_path, QUIET).verdict
    assert answer.trust == "doubtful"
    assert any("stable modes unstable" in reason for reason in answer.reasons)
    assert "trust: doubtful" in answer.sentence


def test_irregular_motion_has_a_verdict_and_no_tone(tmp_path: Path) -> None:
    """Noise in place of the wheel's velocity: above the threshold of squeal, without a line spectrum."""
    run = run_scenario(Scenario("case1", duration=0.01), tmp_path, QUIET)
    time = np.arange(100_000) * 2e-5
    noise = 0.1 * np.random.default_rng(0).standard_normal(time.size)
    data = Samples({"time": time, "wheel.v_lat": noise}, {"step_s": 2e-5, "record_every": 1}, {})
    answer = verdict(run.results, data, run.summary, run.progress, run.spurious)
    assert (answer.squeals, answer.irregular, answer.tone_hz, answer.mode) == (True, True, None, None)
    assert answer.sentence.startswith("squeals irregularly, without a tone (strongest line")
