"""Harmonic balance: its Jacobian, its link to the linear system, and what it must not return."""

from __future__ import annotations

import numpy as np
import pytest
from squeal_models import at_rest, class158_case, only, tone_of

from fmus.modal.modes import Modes
from orchestrator.limit_cycles.balance import Balance, Truncation
from orchestrator.limit_cycles.continuation import newton
from orchestrator.limit_cycles.model import LAT, SquealModel
from orchestrator.limit_cycles.refinement import Lost, refine, solve_free
from orchestrator.limit_cycles.tracing import find_poles
from orchestrator.stability.poles import exact_poles


@pytest.mark.parametrize("case", [1, 2])
def test_jacobian_is_the_derivative_of_the_residual(case: int) -> None:
    """Central differences of the residual have an error of the step squared, plus rounding over the step."""
    balance = Balance(class158_case(case), Truncation(3, 32), LAT, omega_scale=70.0)
    random = np.random.default_rng(case)
    x = 0.1 * random.standard_normal(balance.size)
    x[-3:] = 2 * np.pi * 1100 / 70, 1.0, 0.5
    _, jacobian = balance.linearise(x)
    differences = np.empty_like(jacobian)
    for j in range(balance.size):
        step = np.zeros(balance.size)
        step[j] = 1e-6
        differences[:, j] = (balance.residual(x + step) - balance.residual(x - step)) / 2e-6
    # forward differences of the law at its kinks: 1e-4 of the largest entry, which is 1e4
    np.testing.assert_allclose(jacobian, differences, atol=1e-4 * np.abs(differences).max())


def test_poles_are_those_of_the_linear_system() -> None:
    """Two routes to the same eigenvalues; poles without contact motion are left out."""
    model = class158_case(1)
    exact = exact_poles(model.wheel, model.rail, model.linear).below(6000.0)
    found = [p for p in find_poles(model) if p.frequency_hz < 6000.0]
    values = np.array([p.growth_rate + 2j * np.pi * p.frequency_hz for p in found])
    wanted = exact.growth_rate + 2j * np.pi * exact.frequency_hz
    distance = np.abs(values[:, None] - wanted[None]).min(axis=1)
    assert distance.max() < 1e-5  # eigenvalues of a matrix with entries to 1e10: rounding times condition


def test_growth_rate_at_small_amplitude_is_the_pole() -> None:
    """The curve starts at the pole: at 2 % of the sliding velocity the law is linear to (A / V gamma)^2."""
    found = tone_of(3, 1100.0)
    curve = next(c for c in found.traces if c.crossings)
    pole = curve.pole
    assert curve.amplitude[0] == pytest.approx(0.004)
    assert curve.sigma[0] == pytest.approx(pole.growth_rate, rel=1e-3)
    assert curve.frequency_hz[0] == pytest.approx(pole.frequency_hz, rel=1e-6)


def test_rest_is_never_returned() -> None:
    """Rest solves the equations, too: whoever refines a cycle must refuse it."""
    cycle = only(tone_of(1, 1100.0))
    small = cycle.balance.at(6, 64)
    rest, residual = solve_free(small, at_rest(cycle).resized(6)) or (None, 1.0)
    assert rest is not None
    assert residual < 1e-9
    assert abs(rest.amplitude) < 1e-6  # so the solver does find it
    near_rest = cycle.state.resized(6)
    near_rest = type(near_rest)(0.05 * near_rest.forces, near_rest.omega, 0.05 * near_rest.amplitude, 0.0)
    refined = refine(small, near_rest)
    assert isinstance(refined, Lost) or abs(refined.state.amplitude / cycle.amplitude - 1) < 0.01


def test_what_is_not_solved_is_not_called_a_solution() -> None:
    """A residual that stands still above the tolerance is no solution."""

    class Unsolvable:
        weights = np.ones(2)

        def residual(self, x: np.ndarray) -> np.ndarray:
            return np.array([x[0] ** 2 + 1.0])

        def linearise(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return self.residual(x), np.array([[2 * x[0], 0.0]])

    found = newton(Unsolvable(), np.array([0.7, 0.3]), np.array([0.0, 1.0]), 0.3)
    assert not found.solved


def test_directions_that_nothing_moves_are_left_out() -> None:
    """A wheel that moves in its cross-section only has two directions; the law is asked for these."""
    model = class158_case(2)
    assert isinstance(model.wheel, Modes)
    shape = model.wheel.shape.copy()
    shape[:, [0, 3]] = 0.0
    wheel = Modes(model.wheel.omega, model.wheel.zeta, shape)
    assert SquealModel(wheel, model.rail, model.contact).active == (1, 2)
