"""Closed forms of one wheel mode on a contact spring: what the loop must show whatever the wheel."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes
from orchestrator.paper.consistency import implied_r
from orchestrator.stability.eigenloci import Crossing, crossings, eigenloci, encirclements, frequency_grid
from orchestrator.stability.loop import Loop, Mobility, of_modes, rigid

STIFFNESS = 1.2e9
FRICTION = 0.3


def contact(slope: float, friction: float = FRICTION) -> LinearContact:
    """Return a contact without angle, sliding to the gauge side."""
    return LinearContact(np.diag([-9e4, slope, -0.5]), np.array([0.0, -friction, 0.0]), STIFFNESS, 0.0)


def one_mode(lateral: float, normal: float, frequency_hz: float = 1000.0, zeta: float = 1e-4) -> Modes:
    return Modes(np.array([2 * np.pi * frequency_hz]), np.array([zeta]), np.array([[0.0, lateral, normal, 0.0]]))


def dashpot(mobility: float) -> Mobility:
    """Return a rail that takes energy in the normal direction: velocity = mobility times force."""

    def rail(omega: np.ndarray) -> np.ndarray:
        Y = np.zeros((omega.size, 4, 4), dtype=complex)
        Y[:, 2, 2] = mobility
        return Y

    return rail


def found(wheel: Modes, rail: Mobility, law: LinearContact) -> tuple[tuple[Crossing, ...], float]:
    """Return the crossings and the number of encirclements."""
    loop = Loop(of_modes(wheel), rail, law)
    loci = eigenloci(loop.open_loop, frequency_grid(wheel.omega / (2 * np.pi), wheel.zeta))
    return crossings(loop.open_loop, loci), float(encirclements(loci).sum())


@settings(max_examples=40)
@given(
    st.floats(0.05, 0.15), st.floats(-0.02, 0.02), st.floats(500.0, 4000.0), st.sampled_from([1e-4, 3e-4, 1e-3]),
)  # fmt: skip
def test_gain_of_one_mode_on_a_rigid_rail(lateral: float, normal: float, frequency_hz: float, zeta: float) -> None:
    """The gain is H22 psi2^2 / (2 zeta w0) whatever psi3 is; 0.1 %: the resonance is not quite at w0."""
    wheel = one_mode(lateral, normal, frequency_hz, zeta)
    slope = 1752.0
    gain = slope * lateral**2 / (2 * zeta * wheel.omega[0])
    got, _ = found(wheel, rigid, contact(slope))
    w0, D3 = wheel.omega[0], STIFFNESS
    if gain > 1.05:
        (crossing,) = got
        pole2 = w0**2 + normal**2 * D3
        # lambda real: numerator j w g psi2^2 + mu psi2 psi3 D3 over (wp^2 - w^2) + 2 j zeta w0 w
        assert crossing.gain == pytest.approx(gain, rel=1e-3)
        expected = np.sqrt(pole2 - FRICTION * lateral * normal * D3 / gain) / (2 * np.pi)
        assert crossing.frequency_hz == pytest.approx(expected, rel=1e-6)
    elif gain < 0.95:
        assert not got


@settings(max_examples=30)
@given(st.floats(0.05, 0.15), st.floats(-0.05, 0.05))
def test_one_mode_on_a_rigid_rail_is_stable_under_constant_friction(lateral: float, normal: float) -> None:
    """D3 is real, so nothing feeds energy in: no crossing and no encirclement."""
    got, turns = found(one_mode(lateral, normal), rigid, contact(0.0))
    assert not got
    assert round(turns) == 0


@pytest.mark.parametrize(
    ("ratio", "unstable"), [(-0.05, False), (0.02, True), (0.15, True), (0.28, True), (0.32, False), (0.6, False)]
)
def test_rail_that_takes_energy_makes_one_mode_unstable_between_zero_and_mu(ratio: float, unstable: bool) -> None:
    """Constant friction, normal mobility with a real part: unstable where 0 < psi3/psi2 < mu."""
    wheel = one_mode(0.1, ratio * 0.1, zeta=1e-6)
    _, turns = found(wheel, dashpot(4e-6), contact(0.0))
    assert round(turns) == int(unstable)


@given(st.floats(0.05, 0.12), st.floats(0.002, 0.02), st.floats(1e-6, 8e-6), st.floats(0.5e9, 3e9))
def test_gains_of_three_cases_give_back_the_normal_mobility(
    lateral: float, normal: float, rail_mobility: float, stiffness: float
) -> None:
    """The ratio |D|^2 / Re D follows from three gains of an isolated mode, with no amplitude or damping in it.

    The gains are those of the resonance circles, evaluated on the loop at w0; the identity itself is exact.
    """
    w0, zeta, slope, mu1, mu0 = 2 * np.pi * 1000.0, 1e-4, 1752.0, 0.277, 0.3
    D = rail_mobility + 1j * w0 / stiffness
    r = abs(D) ** 2 / D.real
    loss = 2 * zeta * w0 * r
    second = slope * lateral**2 / (2 * zeta * w0)
    third = mu0 * lateral * normal / (normal**2 + loss)
    first = mu1 / mu0 * third + second * loss / (normal**2 + loss)
    got = implied_r(np.array([[first], [second], [third]]), slope, mu1, mu0)
    np.testing.assert_allclose(got, r, rtol=1e-9)


def test_the_identity_holds_for_crossings_of_the_loop() -> None:
    """The same from crossings of the loop itself; 2 %: D varies over the resonance, whose width is zeta."""
    lateral, normal, rail_mobility = 0.1, 0.008, 5e-6
    wheel = one_mode(lateral, normal)
    gains = [
        found(wheel, rail, law)[0][0].gain
        for rail, law in (
            (dashpot(rail_mobility), contact(1752.0, 0.277)), (rigid, contact(1752.0, 0.277)),
            (dashpot(rail_mobility), contact(0.0)),
        )
    ]  # fmt: skip
    D = rail_mobility + 1j * wheel.omega[0] / STIFFNESS
    got = implied_r(np.array(gains)[:, None], 1752.0, 0.277, FRICTION)
    np.testing.assert_allclose(got, abs(D) ** 2 / D.real, rtol=0.02)
