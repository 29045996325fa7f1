"""Line spectra against irregular motion: closed forms, and Case 4, whose random starts end in both."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from squeal_models import class158_case, fused_run

from orchestrator.signals.lines import REGULAR, is_irregular, line_share
from orchestrator.signals.tones import tones_of_runs

INTERVAL = 4e-5


@settings(max_examples=25, deadline=None)
@given(st.floats(60, 3000), st.floats(20, 900), st.floats(0.05, 1.0), st.floats(0.25, 2.0))
def test_tones_and_pairs_of_tones_are_lines(one: float, other: float, part: float, duration: float) -> None:
    """Whatever their frequencies: a Hann window leaves less than 0.1 % of a line outside of five bins."""
    t = np.arange(round(duration / INTERVAL)) * INTERVAL
    both = np.sin(2 * np.pi * one * t) + part * np.sin(2 * np.pi * (one + other) * t + 1.0)
    share = line_share(both, INTERVAL)
    assert share is None or share > 0.99  # None: a slow beat looks like a level that changes
    assert (line_share(np.sin(2 * np.pi * one * t), INTERVAL) or 0.0) > 0.998


def test_noise_of_a_band_is_irregular() -> None:
    """A band of 360 Hz, about that of Case 4: eight lines of five bins of 1 Hz hold 40 of 360 Hz, the largest ones."""
    random = np.random.default_rng(0)
    f = np.fft.rfftfreq(25000, INTERVAL)
    lines = np.where((f > 60) & (f < 420), random.standard_normal(f.size) + 1j * random.standard_normal(f.size), 0)
    share = line_share(np.fft.irfft(lines), INTERVAL)
    assert share is not None
    assert 40 / 360 < share < 0.5 < REGULAR


def test_nothing_is_said_of_what_is_short_at_rest_or_growing() -> None:
    """Short signals have no resolution; growth widens a line."""
    t = np.arange(25000) * INTERVAL
    assert line_share(np.sin(900 * t[:5000]), INTERVAL) is None
    assert line_share(np.zeros(25000), INTERVAL) is None
    assert line_share(np.exp(10 * t) * np.sin(900 * t), INTERVAL) is None


def test_irregular_runs_are_counted_apart() -> None:
    """Their strongest line joins no tone."""
    found = tones_of_runs([274.0, 272.0, 1980.0, np.nan], [1.0, 0.0, 0.0, np.nan])
    assert sorted(t.words for t in found) == ["1980.0 Hz", "272.0 Hz", "at rest", "irregular"]
    assert {t.of for t in found} == {4}


@pytest.mark.slow
def test_case_4_ends_in_a_tone_or_irregularly() -> None:
    """Random starts of standard deviation 1e-3: one ends in impacts without lines, another at 1980 Hz."""
    model = class158_case(4)
    n = len(model.wheel) + len(model.rail)  # type: ignore[arg-type]
    answers = []
    for seed in (0, 1):
        start = 1e-3 * np.random.default_rng(seed).standard_normal(n)
        lateral = fused_run(model, (start, np.zeros(n)), 5e-6, 5.0)[::4, 0]
        answers.append((is_irregular(lateral, 2e-5), float(lateral[-50000:].std())))
    assert [a[0] for a in answers] == [True, False]
    assert answers[0][1] > 0.3  # m/s; the tone has 0.227
    assert answers[1][1] == pytest.approx(0.2268, rel=0.01)
