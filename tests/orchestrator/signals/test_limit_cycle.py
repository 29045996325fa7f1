"""Facts of a run against signals whose facts are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

from orchestrator.signals.limit_cycle import growth_of, limit_cycle
from orchestrator.stability.poles import Poles

INTERVAL = 2e-5
TONE = 1102.0


def run(columns: dict[str, np.ndarray]) -> xr.Dataset:
    """Return results with these columns."""
    count = next(iter(columns.values())).size
    time = INTERVAL * (1 + np.arange(count))
    return xr.Dataset(
        {name: ("time", values) for name, values in columns.items()},
        coords={"time": time},
        attrs={"step_s": 5e-6, "record_every": 4},
    )


def times(duration: float) -> np.ndarray:
    return INTERVAL * np.arange(round(duration / INTERVAL))


@pytest.mark.parametrize("rate", [4.0, 23.0])
def test_growth_is_that_of_the_exponential(rate: float) -> None:
    """Two growing tones 875 Hz apart: each with its own rate, to 0.2 %, until the sum saturates."""
    t = times(2.0)
    other = 0.8 * rate
    signal = 2e-4 * (np.exp(rate * t) * np.sin(2 * np.pi * TONE * t) + np.exp(other * t) * np.cos(2 * np.pi * 1977 * t))
    poles = Poles(np.array([TONE, 1977.0, 3000.0]), np.array([rate, other, -5.0]))
    found = growth_of(run({"wheel.v_lat": np.clip(signal, -0.2, 0.2)}), poles)
    assert [g.pole for g in found] == [rate, other]
    assert [g.seen for g in found] == pytest.approx([rate, other], rel=2e-3)


def test_what_starts_large_has_no_linear_growth() -> None:
    t = times(1.0)
    poles = Poles(np.array([TONE]), np.array([20.0]))
    assert growth_of(run({"wheel.v_lat": 0.1 * np.sin(2 * np.pi * TONE * t)}), poles) == ()
    assert growth_of(run({"wheel.v_lat": 1e-4 * np.sin(2 * np.pi * TONE * t)}), Poles(np.zeros(0), np.zeros(0))) == ()


def test_limit_cycle_of_known_lines() -> None:
    """Amplitudes of harmonics, the strongest other line, and the ratio of rail to wheel, each as put in."""
    t = times(2.0)

    def lines(amplitudes: dict[float, float]) -> np.ndarray:
        return np.asarray(sum(a * np.sin(2 * np.pi * f * t) for f, a in amplitudes.items()))

    wheel = lines({TONE: 0.2, 2 * TONE: 0.004, 1500.0: 0.0002})
    rail = lines({TONE: 0.01, 2 * TONE: 0.008})
    cycle = limit_cycle(run({"wheel.v_lat": wheel, "rail.v_lat": rail}))
    assert cycle.steady
    assert cycle.frequency_hz == pytest.approx(TONE, abs=1e-3)
    assert cycle.harmonics[0].wheel["lat"] == pytest.approx(0.2, rel=1e-3)
    assert cycle.harmonics[1].wheel["lat"] == pytest.approx(0.004, rel=1e-3)
    assert cycle.rail_above_wheel_hz == pytest.approx([2 * TONE], abs=0.01)
    assert cycle.second_tone_db == pytest.approx(-60.0, abs=0.01)
    assert cycle.rail_to_wheel["lat"] == pytest.approx(np.hypot(0.01, 0.008) / np.hypot(0.2, 0.004), rel=1e-4)
    assert cycle.contact_lost is None


def test_stick_and_loss_of_contact_are_counted() -> None:
    """A quarter of the time in stick, a tenth without contact."""
    t = times(1.0)
    phase = np.arange(t.size) % 20
    normal = np.where(phase < 2, 0.0, 60e3)
    friction = np.where((phase >= 10) & (phase < 15), 0.5, 1.0) * 0.3 * normal
    names = ("normal_force", "tangential_force_lat", "friction_coefficient")
    columns = dict(zip((f"contact.{n}" for n in names), (normal, friction, np.full(t.size, 0.3)), strict=True))
    cycle = limit_cycle(run({"wheel.v_lat": 0.1 * np.sin(2 * np.pi * TONE * t), **columns}))
    assert (cycle.stick, cycle.contact_lost) == pytest.approx((0.25, 0.1), abs=1e-3)
    assert cycle.normal_force == (0.0, 60e3)


def test_growth_is_not_steady_and_rest_is_no_squeal() -> None:
    t = times(1.0)
    growing = limit_cycle(run({"wheel.v_lat": 0.1 * np.exp(2 * t) * np.sin(2 * np.pi * TONE * t)}))
    assert growing.squeals
    assert not growing.steady
    rest = limit_cycle(run({"wheel.v_lat": np.zeros(t.size)}))
    assert (rest.squeals, rest.frequency_hz, rest.harmonics) == (False, None, ())
