"""One FMU is a system: its inputs stay at their start values, its outputs are recorded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.errors import InputError
from orchestrator.results.samples import read_samples
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario


def test_an_fmu_alone_runs_with_its_own_values(block: Path, tmp_path: Path) -> None:
    """After each step y = k u + b."""
    name = block.stem
    values = {name: {"k": 3.0, "u": 2.0, "b": 0.5}}
    scenario = Scenario(str(block), step=0.1, duration=0.5, values=values, record_every=1)
    outcome = run_scenario(scenario, tmp_path, Report())
    assert (outcome.case, outcome.progress.steps, outcome.verdict.squeals) == (name, 5, None)
    np.testing.assert_array_equal(read_samples(outcome.results)[f"{name}.y"][1:], np.full(5, 6.5))


def test_an_fmu_without_stop_time_or_step_asks_for_them(block: Path) -> None:
    with pytest.raises(InputError, match=r"give a (step size|duration)"):
        Scenario(str(block)).prepare()
