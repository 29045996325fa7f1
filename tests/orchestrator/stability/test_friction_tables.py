"""Friction tables in the linear analysis: the paper's law as a table, and the slope at which a mode begins to grow."""

from __future__ import annotations

import numpy as np
import pytest
from squeal_models import RIGID, rail_modes

from fmus.contact.friction.named import friction_table
from fmus.contact.linearised import linearise
from fmus.creep.friction import falling_factor
from fmus.modal.modes import Modes
from fmus.wheel.class158 import class158, identified_stiffness
from orchestrator.stability.poles import exact_poles


def growth_rates(wheel: Modes, rail: Modes, values: dict[str, float]) -> np.ndarray:
    """Return the growth rates of oscillations, by rising frequency."""
    return exact_poles(wheel, rail, linearise(values)).growth_rate


def test_case_1_with_its_law_as_a_table_has_the_same_growth_rates() -> None:
    """To 1e-4 1/s: the slope is right to 1e-6 and adds at most some 100 1/s to a mode."""
    points = np.linspace(0.0, 0.03, 49)
    friction = [0.3 * falling_factor(x, 0.1, 0.005) for x in points]
    spring = {"hertz_stiffness": identified_stiffness()}
    wheel, rail = class158().modes, rail_modes(1)
    law = growth_rates(wheel, rail, spring)
    table = growth_rates(wheel, rail, {**spring, **friction_table(points, friction)})
    np.testing.assert_allclose(table, law, atol=1e-4)
    assert law.max() > 1.0


@pytest.mark.parametrize(("zeta", "lateral"), [(1e-4, 0.1), (1e-3, 0.2)])
def test_an_isolated_mode_grows_beyond_its_threshold_slope(zeta: float, lateral: float) -> None:
    """On a rigid rail: dF/dv = 2 zeta omega/psi2^2, F = mu N and v = gamma V; 1 part in 1000 on either side."""
    omega, load, velocity, mu = 2 * np.pi * 1000.0, 60e3, 10.0, 0.3
    wheel = Modes(np.array([omega]), np.array([zeta]), np.array([[0.0, lateral, 0.0, 0.0]]))
    threshold = 2 * zeta * omega / lateral**2 * velocity / load  # of mu by creepage
    growth = []
    for part in (0.999, 1.001):
        fall = part * threshold * 0.01
        table = friction_table([0.01, 0.02, 0.03], [mu + fall, mu, mu - fall])
        growth.append(growth_rates(wheel, RIGID, {**table, "contact_angle": 0.0}).max())
    assert growth[0] < 0.0 < growth[1]
    assert growth == pytest.approx([-1e-3 * zeta * omega, 1e-3 * zeta * omega], rel=1e-3)
