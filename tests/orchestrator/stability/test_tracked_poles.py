"""Poles of neighbouring systems: the same as eigenvalues computed anew, for any modes and contacts."""

from __future__ import annotations

import numpy as np
import pytest
from coupled import linear_contact, modes_of, rail_of, wheel
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes
from orchestrator.stability.poles import exact_poles
from orchestrator.stability.tracking import TrackedPoles


def test_poles_of_case_3_along_friction() -> None:
    """Six digits beyond what a table shows: both are the roots of one polynomial, up to rounding."""
    tracked, the_wheel, the_rail = TrackedPoles(), modes_of(wheel()), modes_of(rail_of(3))
    for mu0 in np.linspace(0.1, 0.4, 12):
        contact = linear_contact(3, mu0=float(mu0))
        found, exact = tracked.poles(the_wheel, the_rail, contact), exact_poles(the_wheel, the_rail, contact)
        np.testing.assert_allclose(found.frequency_hz, exact.frequency_hz, rtol=1e-9)
        np.testing.assert_allclose(found.growth_rate, exact.growth_rate, rtol=1e-8, atol=1e-6)
    assert tracked.fresh < 12


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 6), st.integers(0, 4))
def test_poles_of_random_systems(seed: int, n_wheel: int, n_rail: int) -> None:
    """However far the next system is, nothing is missed: the traces are checked, else eigenvalues are computed."""
    random = np.random.default_rng(seed)

    def modes(n: int) -> Modes:
        shape = random.normal(size=(n, 4)) * (random.random((n, 4)) < 0.7)
        return Modes(random.uniform(100, 2e4, n), random.uniform(0, 0.05, n), shape)

    tracked = TrackedPoles()
    wheel_modes, rail_modes = modes(n_wheel), modes(n_rail)
    for _ in range(3):
        contact = LinearContact(100 * random.normal(size=(3, 3)), random.normal(size=3), 1e7 * random.random(), 0.1)
        found, exact = (f(wheel_modes, rail_modes, contact) for f in (tracked.poles, exact_poles))
        assert found.frequency_hz.size == exact.frequency_hz.size
        order = [np.lexsort((p.growth_rate.round(3), p.frequency_hz.round(3))) for p in (found, exact)]
        np.testing.assert_allclose(found.growth_rate[order[0]], exact.growth_rate[order[1]], rtol=1e-6, atol=1e-3)


@pytest.mark.parametrize("slope", [-0.05, 0.05, 0.15, 0.29, 0.31, 0.45])
def test_border_of_mode_coupling_at_a_dashpot(slope: float) -> None:
    """One wheel mode on a dashpot rail is unstable if and only if 0 < s psi3/psi2 < mu.

    A heavily damped rail stands for the dashpot. The mode gives lateral motion psi2 and normal motion psi3; constant
    friction gives f2 = -mu f3 for a rubbing contact without slope.
    """
    mu, psi2 = 0.3, 0.4
    contact = LinearContact(np.zeros((3, 3)), np.array([0.0, mu, 0.0]), 1e9, 0.0)
    mode = Modes(np.array([2 * np.pi * 1000]), np.array([0.0]), np.array([[0, psi2, -slope * psi2, 0]]))
    dashpot = Modes(np.array([1.0]), np.array([5e3]), np.array([[0, 0, 0.1, 0]]))
    growth = TrackedPoles().poles(mode, dashpot, contact)
    near = np.abs(growth.frequency_hz / 1000 - 1) < 0.2
    assert (growth.growth_rate[near].max() > 0) == (0 < slope < mu)
