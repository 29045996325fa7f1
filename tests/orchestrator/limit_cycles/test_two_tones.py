"""Two tones at once: the Jacobian, the time domain, and what is said where the equations are not solved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from squeal_models import class158_case, fused_run, start_of, tone_of

from orchestrator.limit_cycles.tori.balance import TwoToneBalance
from orchestrator.limit_cycles.tori.described import break_up_as_json
from orchestrator.limit_cycles.tori.lines import Lines
from orchestrator.limit_cycles.tori.search import break_up

STEP = 5e-6


@pytest.mark.parametrize("carrier", [0, -1])
def test_jacobian_is_the_derivative_of_the_residual(carrier: int) -> None:
    """Central differences, as for one tone."""
    balance = TwoToneBalance(class158_case(1), Lines((3, 2), (16, 12)), (17.0, 9.0), carrier)
    random = np.random.default_rng(1)
    x = 0.1 * random.standard_normal(balance.size)
    x[-4:] = 100.0, 103.0, 0.8, 0.4
    _, jacobian = balance.linearise(x)
    differences = np.empty_like(jacobian)
    for j in range(balance.size):
        step = np.zeros(balance.size)
        step[j] = 1e-6
        differences[:, j] = (balance.residual(x + step) - balance.residual(x - step)) / 2e-6
    # forward differences of the law at its kinks: 1e-4 of the largest entry
    np.testing.assert_allclose(jacobian, differences, atol=1e-4 * np.abs(differences).max())


def test_lines_and_samples_are_one_motion() -> None:
    """Real samples of lines, and their lines again; of k and -k there is one."""
    lines = Lines((4, 3), (16, 12))
    pairs = {tuple(k) for k in lines.numbers.tolist()}
    assert all((-a, -b) not in pairs for a, b in pairs if (a, b) != (0, 0))
    random = np.random.default_rng(2)
    there = random.standard_normal((len(pairs), 2)) + 1j * random.standard_normal((len(pairs), 2))
    there[0] = there[0].real
    again = lines.transform(lines.on_grid(there))[lines.index(lines.numbers)]
    np.testing.assert_allclose(again, there, atol=1e-13)


def strongest(signal: np.ndarray, near_hz: float) -> tuple[float, float]:
    """Return frequency and amplitude of the line near a frequency, through a Hann window."""
    time, window = STEP * np.arange(signal.size), np.hanning(signal.size + 1)[:-1]

    def minus_amplitude(f: float) -> float:
        return -2 * float(abs(np.sum(signal * window * np.exp(-2j * np.pi * f * time))) / window.sum())

    found = minimize_scalar(minus_amplitude, bounds=(near_hz - 0.5, near_hz + 0.5), method="bounded")
    return float(found.x), -float(found.fun)


@pytest.mark.slow
@pytest.mark.parametrize(("case", "duration"), [(1, 4.0), (3, 5.0)])
def test_a_run_from_the_cycle_ends_in_the_two_tones(case: int, duration: float) -> None:
    """272 + 147 + 419 Hz: frequencies to 0.05 Hz, rms to 0.3 %, lines to 0.15 dB in the last 2 s of a run.

    The step of 5 us and the lines that are left out make 0.1 % of the rms each.
    """
    cycle = tone_of(case, 272.0).near(272.0)
    found = break_up(cycle)
    torus = found.torus
    assert torus is not None
    assert torus.rms_change < 2e-3
    assert torus.residual < 1e-6
    velocity = fused_run(cycle.balance.model, start_of(cycle.motion, 1.02), STEP, duration)[-round(2.0 / STEP) :, 0]
    assert torus.wheel_velocity_rms["lat"] == pytest.approx(np.std(velocity), rel=3e-3)
    seen = [strongest(velocity, line.frequency_hz) for line in torus.lines[:3]]
    for line, (frequency_hz, amplitude) in zip(torus.lines, seen, strict=False):
        assert line.frequency_hz == pytest.approx(frequency_hz, abs=0.05)
        assert line.level_db == pytest.approx(20 * np.log10(amplitude / seen[0][1]), abs=0.15)
    assert break_up_as_json(found, None)["words"].endswith(torus.words)


@pytest.mark.slow
def test_where_two_tones_are_not_found_it_says_how_far_it_came() -> None:
    """Case 3's 416 Hz: the sideband at 272 Hz takes over, so that there are no two tones, and no number of any."""
    found = break_up(tone_of(3, 416.0).near(416.0))
    assert found.torus is None
    assert found.words.startswith("breaks up through sidebands at ")
    assert "two tones at once were not found: with 73 lines the second tone takes over: at 0.17" in found.words
    assert break_up_as_json(found, None)["torus"] is None
