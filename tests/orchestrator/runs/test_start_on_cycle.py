"""Runs that start on a limit cycle: there is no growth phase, and the level is that of the cycle at once."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from squeal_models import tone_of

from orchestrator import InputError, load, simulate
from orchestrator.runs.starts import on_cycle


def lateral_rms(system: str, tone: float, folder: Path) -> float:
    """Return the rms lateral velocity of the wheel from 0.1 to 0.3 s in a run that starts on a cycle."""
    run = simulate(load(system, duration=0.3, start_cycle=tone), folder=folder)
    lateral = run.data["wheel.v_lat"]
    return float(np.sqrt(np.square(lateral.to_numpy()[lateral["time"].to_numpy() > 0.1]).mean()))


def test_a_run_from_a_cycle_stays_on_it(tmp_path: Path) -> None:
    """0.2 %: the error of the step of 5 us at 1.1 kHz is 0.15 %."""
    wanted = tone_of(1, 1100.0).near(1100.0).wheel_velocity_rms["lat"]
    assert lateral_rms("case1", 1100.0, tmp_path) == pytest.approx(wanted, rel=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "tone", "error"),
    [(3, 150.6, 0.002), (1, 401.8, 0.002), (1, 1977.0, 0.002), (2, 1980.0, 0.006)],  # the last one loses contact
)
def test_cycles_up_to_2_khz(tmp_path: Path, case: int, tone: float, error: float) -> None:
    """With lost contact the step counts more."""
    wanted = tone_of(case, tone).near(tone).wheel_velocity_rms["lat"]
    assert lateral_rms(f"case{case}", tone, tmp_path) == pytest.approx(wanted, rel=error)


def test_the_start_replaces_pulse_and_seed() -> None:
    """No pulse; a seed is refused, for it asks for another start, and so is a tone that is not there."""
    start = on_cycle(load("case1"), 1100.0).values
    assert start["contact"]["pulse_force"] == 0.0
    assert len(start["wheel"]) == 2 * sum(name.startswith("initial_velocity") for name in start["wheel"])
    with pytest.raises(InputError, match="seed = 3 asks for another start"):
        on_cycle(load("case1", seed=3), 1100.0)
    with pytest.raises(InputError, match="no tone near 700 Hz"):
        on_cycle(load("case1"), 700.0)
