"""Every kind of cycle against values that a prototype computed by itself, confirmed in the time domain.

Velocities may be 1.5 % off where the law of the contact has been made more accurate since; frequencies are not moved by
that. docs/limit-cycles.md has the whole table.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from squeal_models import only, tone_of

RMS = 0.015
"""Relative; the grid of FASTSIM moves it by so much."""


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
    ("stable", 1): Row(1100.28, 0.15608, 0.01019, (58.4, 62.0), "stable", -0.15, 0.0),
    ("torus", 1): Row(271.73, 0.17276, 0.02637, (56.0, 64.6), "sidebands", 13.68, 124.0),
    ("torus without falling friction", 3): Row(272.05, 0.16063, 0.01916, (56.3, 64.3), "sidebands", 6.42, 124.2),
    ("period doubling", 2): Row(253.72, 0.15237, 0.0, (8.3, 120.7), "period doubling", 15.64, 126.86),
    ("contact lost", 2): Row(1980.17, 0.22686, 0.0, (0.0, 174.3), "stable", -0.11, 0.0),
    ("stable low tone", 3): Row(150.63, 0.15106, 0.01591, (56.2, 64.1), "stable", -0.22, 30.9),
}


@pytest.mark.parametrize(("name", "case"), ROWS)
def test_kinds_of_cycles(name: str, case: int) -> None:
    """Frequency to 0.05 Hz, level, forces to 0.3 kN beside that, exponents to 3 % or 0.1 1/s."""
    row = ROWS[name, case]
    cycle = only(tone_of(case, row.frequency_hz))
    assert cycle.frequency_hz == pytest.approx(row.frequency_hz, abs=0.05)
    assert cycle.wheel_velocity_rms["lat"] == pytest.approx(row.wheel, rel=RMS)
    assert cycle.rail_velocity_rms["lat"] == pytest.approx(row.rail, rel=2 * RMS, abs=1e-9)
    swing = row.normal[1] - row.normal[0]
    for force, wanted in zip(cycle.normal_force, row.normal, strict=True):
        assert force / 1e3 == pytest.approx(wanted, abs=0.3 + RMS * swing)
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
    assert loud.wheel_velocity_rms["lat"] == pytest.approx(0.12981, rel=RMS)
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
    assert np.allclose([v[0] for v in values], [1979.01, 1981.39, 1982.51], atol=0.05)
    assert np.allclose([v[1] for v in values], [0.14743, 0.17530, 0.20904], rtol=RMS)
    assert [v[2] for v in values] == [True, False, True]
    assert found.cycles[1].fate == "threshold: less falls, more rises"
