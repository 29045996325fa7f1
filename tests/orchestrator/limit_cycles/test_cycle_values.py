"""Every kind of cycle: values of this law of the contact, of which the time domain confirms those that last.

Where the law is made more accurate, levels move (10 x 10 cells of second order: 1.5 % below those of first order);
`test_the_time_domain_tends_to_the_cycles` says which are right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from squeal_models import fused_run, only, start_of, tone_of

RMS = 0.002
"""Relative; the truncation moves it by 0.0003."""


@dataclass(frozen=True)
class Row:
    """A check value: frequency, lateral rms of wheel and rail, normal force [kN], exponent [1/s] and its frequency."""

    frequency_hz: float
    wheel: float
    rail: float
    normal: tuple[float, float]
    kind: str
    exponent: float
    exponent_hz: float


ROWS = {
    ("stable", 1): Row(1100.35, 0.15386, 0.00978, (58.4, 62.0), "stable", -0.15, 0.0),
    ("torus", 1): Row(271.74, 0.17073, 0.02585, (56.0, 64.5), "sidebands", 13.51, 124.0),
    ("torus without falling friction", 3): Row(272.04, 0.15842, 0.01878, (56.3, 64.2), "sidebands", 6.33, 124.2),
    ("period doubling", 2): Row(253.68, 0.15008, 0.0, (8.7, 120.2), "period doubling", 10.90, 126.84),
    ("contact lost", 2): Row(1980.17, 0.22678, 0.0, (0.0, 174.1), "stable", -0.12, 0.0),
    ("stable low tone", 3): Row(150.63, 0.14846, 0.01563, (56.2, 64.0), "stable", -0.19, 30.9),
}


@pytest.mark.parametrize(("name", "case"), ROWS)
def test_kinds_of_cycles(name: str, case: int) -> None:
    """Frequency to 0.05 Hz, level, forces to 0.3 kN, exponents to 3 % or 0.1 1/s."""
    row = ROWS[name, case]
    cycle = only(tone_of(case, row.frequency_hz))
    assert cycle.frequency_hz == pytest.approx(row.frequency_hz, abs=0.05)
    assert cycle.wheel_velocity_rms["lat"] == pytest.approx(row.wheel, rel=RMS)
    assert cycle.rail_velocity_rms["lat"] == pytest.approx(row.rail, rel=5 * RMS, abs=1e-9)
    for force, wanted in zip(cycle.normal_force, row.normal, strict=True):
        assert force / 1e3 == pytest.approx(wanted, abs=0.3)
    judged = cycle.stability
    assert judged is not None
    assert judged.kind == row.kind
    assert judged.largest.real == pytest.approx(row.exponent, rel=0.03, abs=0.1)
    assert judged.largest_hz == pytest.approx(row.exponent_hz, abs=0.3)
    assert cycle.residual < 1e-6


def test_threshold_and_the_tone_above_it() -> None:
    """A stable pole of Case 2 has two cycles: a threshold and, above it, one with the loud kind of motion."""
    found = tone_of(2, 2575.0)
    assert [round(c.frequency_hz, 1) for c in found.cycles] == [2574.9, 2575.0]
    loud, threshold = sorted(found.cycles, key=lambda c: -c.amplitude)
    assert threshold.wheel_velocity_rms["lat"] == pytest.approx(0.07002, rel=RMS)
    assert loud.wheel_velocity_rms["lat"] == pytest.approx(0.12787, rel=RMS)
    assert threshold.stability is not None
    assert loud.stability is not None
    assert threshold.stability.threshold
    assert not loud.stability.threshold
    assert threshold.fate.startswith("threshold")


def test_contact_is_lost_for_a_part_of_the_period() -> None:
    """Share of the period without normal force, Case 2's only lasting tone."""
    cycle = only(tone_of(2, 1980.0))
    assert cycle.contact.lost == pytest.approx(0.12, abs=0.01)
    assert cycle.normal_force[0] == 0.0


@pytest.mark.slow
def test_two_stable_tones_of_one_pole() -> None:
    """The finite-element wheel has three cycles near 1980 Hz, the middle one a threshold between two that last."""
    found = tone_of(1, 1980.0, "generic840")
    values = [(c.frequency_hz, c.wheel_velocity_rms["lat"], c.stable) for c in found.cycles]
    assert np.allclose([v[0] for v in values], [1979.05, 1981.41, 1982.51], atol=0.05)
    assert np.allclose([v[1] for v in values], [0.14608, 0.17390, 0.20585], rtol=RMS)
    assert [v[2] for v in values] == [True, False, True]
    assert found.cycles[1].fate == "threshold: less falls, more rises"


@pytest.mark.slow
@pytest.mark.parametrize(("case", "tone", "error"), [(1, 1100.0, 3e-4), (2, 1980.0, 3e-4), (3, 150.6, 1e-3)])
def test_the_time_domain_tends_to_the_cycles(case: int, tone: float, error: float) -> None:
    """Runs from the cycle at two steps, extrapolated: the coupling is of second order.

    At 150 Hz the window of 0.2 s holds 30 periods, and the cycle's slow sideband has not died out.
    """
    cycle = tone_of(case, tone).near(tone)
    levels = []
    for h in (5e-6, 2.5e-6):
        velocity = fused_run(cycle.balance.model, start_of(cycle.motion), h, 0.3)[round(0.1 / h) :, 0]
        levels.append(float(np.sqrt(np.square(velocity).mean())))
    limit = (4 * levels[1] - levels[0]) / 3
    assert limit == pytest.approx(cycle.wheel_velocity_rms["lat"], rel=error)
