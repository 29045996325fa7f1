"""Signs of an energy source in impulse responses: none in what is passive, all found in what is not."""

from __future__ import annotations

import numpy as np
import pytest
from coupled import modes_of
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.modal.component import structure
from fmus.modal.modes import Modes, mobility
from fmus.rail.component import shipped_rail
from orchestrator.probing.rail_passivity import (
    Responses,
    estimate_mobility,
    find_activity,
    find_growth,
    find_lateness,
    lowest_energy,
)

STEP = 5e-6

Real = NDArray[np.float64]


def responses(modes: Modes, steps: int, sign: float = 1.0) -> Responses:
    """Return the impulse responses of a modal rail; a negative sign gives all modes a negative mass."""
    component = structure("rail", "", modes)
    rows = np.zeros((steps, 8, 4))
    for k in range(4):
        instance = Instance(component)
        instance.initialise()
        instance.inputs[k] = 1.0
        for n in range(steps):
            instance.do_step(STEP)
            rows[n, :, k] = instance.outputs
            instance.inputs[k] = 0.0
    way = np.diff(rows[:, 4:], axis=0, prepend=0.0)
    return Responses(sign * rows[:, :4], sign * way, STEP)


def one_mode(frequency_hz: float, zeta: float) -> Modes:
    """Return a vertical mode of 100 kg."""
    return Modes(np.array([2 * np.pi * frequency_hz]), np.array([zeta]), np.array([[0.0, 0.0, 0.1, 0.0]]))


def growing(rate: float, frequency_hz: float, steps: int = 20000) -> Responses:
    """Return the answer of a vertical mode whose amplitude goes like exp(rate t)."""
    t = STEP * np.arange(steps + 1)
    s = rate + 2j * np.pi * frequency_hz
    v = np.zeros((steps, 4, 4))
    v[:, 2, 2] = 1e-8 * np.exp(s * t[1:]).real
    u = np.zeros((steps + 1, 4, 4))
    u[:, 2, 2] = 1e-8 * (np.exp(s * t) / s).real
    return Responses(v, np.diff(u, axis=0), STEP)


@pytest.mark.parametrize("name", ["rail", "rail-paper"])
def test_mobility_from_impulse_responses_is_the_modal_sum(name: str) -> None:
    """Up to aliasing, which takes (f step)^2: 1 % at 10 kHz, where the paper's 20 kHz mode is near; 0.1 % to 2 kHz."""
    modes = modes_of(shipped_rail(name))
    found = estimate_mobility(responses(modes, 30000))
    expected = mobility(2 * np.pi * found.frequency_hz, modes)
    for j in range(4):
        error = np.abs(found.values[:, j, j] / expected[:, j, j] - 1)
        assert error[(found.frequency_hz > 30)].max() < 0.01
        assert error[(found.frequency_hz > 50) & (found.frequency_hz < 2000)].max() < 1e-3


def test_a_mode_that_rings_on_is_judged_off_the_axis() -> None:
    """Undamped: Y(s) = s / (m (s^2 + omega^2)) at s = shift + j omega, within the remainder that the shift leaves."""
    found = estimate_mobility(responses(one_mode(300.0, 0.0), 8000))
    assert found.shift == pytest.approx(np.log(1e6) / 0.04, rel=0.01)
    s = found.shift + 2j * np.pi * found.frequency_hz
    expected = s / (100.0 * (s**2 + (2 * np.pi * 300.0) ** 2))
    np.testing.assert_allclose(found.values[:, 2, 2], expected, rtol=2e-3)


@pytest.mark.parametrize("zeta", [0.0, 0.001, 0.05, 3.0])
def test_a_damped_mode_is_no_source(zeta: float) -> None:
    answer = responses(one_mode(300.0, zeta), 20000)
    assert find_growth(answer) is None
    assert find_activity(estimate_mobility(answer), STEP) is None


def test_coupled_modes_are_no_source() -> None:
    """Shapes in all directions, light damping, beats between 300 and 302 Hz."""
    rng = np.random.default_rng(5)
    f = np.array([40.0, 300.0, 302.0, 1500.0, 4000.0])
    modes = Modes(2 * np.pi * f, np.array([0.1, 0.0, 1e-3, 0.01, 0.5]), 0.1 * rng.standard_normal((5, 4)))
    answer = responses(modes, 20000)
    assert find_growth(answer) is None
    assert find_activity(estimate_mobility(answer), STEP) is None


@pytest.mark.parametrize(("rate", "frequency_hz"), [(1.0, 80.0), (20.0, 500.0), (300.0, 3000.0)])
def test_negative_damping_is_found_with_rate_and_frequency(rate: float, frequency_hz: float) -> None:
    """The rate is that of the pole to three digits, the frequency that of a window of 50 ms: 20 Hz."""
    said = find_growth(growing(rate, frequency_hz))
    assert said is not None
    assert said.startswith(f"after a pulse the ver velocity grows by {rate:.3g} 1/s, at about ")
    assert float(said.split()[-2]) == pytest.approx(frequency_hz, abs=20.0)


def test_decay_is_no_growth() -> None:
    assert find_growth(growing(-1.0, 80.0)) is None


def test_negative_modal_mass_is_found() -> None:
    """All of the mobility points the wrong way."""
    said = find_activity(estimate_mobility(responses(one_mode(300.0, 0.1), 20000, sign=-1.0)), STEP)
    assert said is not None
    assert said.startswith("the ver mobility at ")
    assert said.endswith("must be within +-90")


def test_a_single_active_mode_among_passive_ones_is_found_at_its_frequency() -> None:
    """A mode of negative mass at 700 Hz inside a rail that dissipates otherwise."""
    passive = responses(Modes(2 * np.pi * np.array([100.0]), np.array([0.3]), np.array([[0, 0, 0.05, 0]])), 20000)
    active = responses(one_mode(700.0, 0.05), 20000, sign=-1.0)
    both = Responses(passive.velocity + active.velocity, passive.way + active.way, STEP)
    found = estimate_mobility(both)
    assert find_activity(found, STEP) is not None
    own: NDArray[np.complex128] = found.values[:, 2, 2]
    assert found.frequency_hz[np.argmin(own.real)] == pytest.approx(700.0, abs=10.0)


def test_energy_from_cross_terms_is_found() -> None:
    """Point mobilities of a damper, but a cross term larger than their mean: det Re Y < 0."""
    way = np.zeros((2000, 4, 4))
    way[0] = 1e-11 * np.eye(4)
    way[0, 1, 2] = way[0, 2, 1] = 2e-11
    said = find_activity(estimate_mobility(Responses(way / STEP, way, STEP)), STEP)
    assert said is not None
    assert said.startswith("forces in several directions at ")


def pulse_response(f: Real, zeta: Real, squared: Real, duration: float) -> Responses:
    """Return the closed form of a vertical answer of modes, also of negative damping, to a force held over a step."""
    t = STEP * np.arange(round(duration / STEP) + 1)[:, None]
    a, omega = 2 * np.pi * f * zeta, 2 * np.pi * f
    b = omega * np.sqrt(1 - zeta**2)
    moved = squared / omega**2 * (1 - np.exp(-a * t) * (np.cos(b * t) + a / b * np.sin(b * t)))
    fast = squared * np.exp(-a * t) * np.sin(b * t) / b
    v, u = np.zeros((len(t) - 1, 4, 4)), np.zeros((len(t), 4, 4))
    v[:, 2, 2] = np.diff(fast.sum(axis=1))
    u[1:, 2, 2] = np.diff(moved.sum(axis=1))
    return Responses(v, np.diff(u, axis=0), STEP)


def log_spaced(n: int) -> tuple[Real, Real, Real]:
    """Return frequencies, damping ratios and squared shapes of modes from 40 Hz to 8 kHz."""
    return 40.0 * 200.0 ** (np.arange(n) / n), np.full(n, 0.05), np.full(n, 0.0016)


def beam(length: float, damping: float) -> tuple[Real, Real, Real]:
    """Return the modes below 8 kHz of a simply supported beam on an elastic foundation, driven at mid-span."""
    n = np.arange(1, 400, 2)
    f = np.sqrt((5e7 + 6.4e6 * (n * np.pi / length) ** 4) / 60.0) / (2 * np.pi)
    f = f[f < 8000.0]
    return f, np.full(f.size, damping), np.full(f.size, 2 / (60.0 * length))


@pytest.mark.parametrize("modes", [log_spaced(80), log_spaced(125), beam(60.0, 0.1), beam(36.0, 0.02)])
def test_a_rail_dense_in_modes_is_no_source(modes: tuple[Real, Real, Real]) -> None:
    """As finite elements make them: passive by construction, positive damping and real shapes."""
    answer = pulse_response(*modes, 0.2)
    assert find_lateness(answer) is None
    assert find_growth(answer) is None
    assert find_activity(estimate_mobility(answer), STEP) is None


def test_one_active_mode_among_ten_is_found_with_its_growth_rate() -> None:
    """Damping ratio -0.002 at 566 Hz: exp(7.11 t)."""
    f, zeta, squared = log_spaced(10)
    zeta[5] = -0.002
    said = find_growth(pulse_response(f, zeta, squared, 0.4))
    assert said is not None
    rate, frequency = float(said.split(" by ")[1].split()[0]), float(said.split()[-2])
    assert rate == pytest.approx(0.002 * 2 * np.pi * f[5], rel=0.01)
    assert frequency == pytest.approx(f[5], abs=5.0)  # the window of 0.2 s


@pytest.mark.parametrize("late", [1, 3])
def test_what_is_told_too_late_is_called_late(late: int) -> None:
    answer = pulse_response(*log_spaced(10), 0.1)
    nothing = np.zeros((late, 4, 4))
    delayed = Responses(
        np.concatenate([nothing, answer.velocity[:-late]]), np.concatenate([nothing, answer.way[:-late]]), STEP
    )
    said = find_lateness(delayed)
    assert said is not None
    assert said.startswith("late by a step" if late == 1 else "late by 3 steps")


def test_lowest_energy_is_that_of_the_whole_matrix() -> None:
    """Lanczos' lowest value against a full eigenvalue problem: the same sign, and never below."""
    k = np.arange(300)
    for rate in (-2e-3, 0.0, 1e-3, 1e-2):
        way = np.exp(rate * k) * np.cos(0.3 * k)
        t = np.where(k == 0, way, way / 2)
        values = np.linalg.eigvalsh(t[np.abs(k[:, None] - k)])
        found = lowest_energy(way)
        assert values[0] / values[-1] - 1e-12 <= found
        assert (found < 0) == (values[0] < 0)
