"""Damping by label and tuned absorbers: closed forms, and what they do to the squeal of Case 1."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.cases import read_cases
from fmus.modal.modes import Modes
from fmus.wheel.class158 import class158
from fmus.wheel.treatment import Absorber, damped, matching, read_rule, with_absorber
from orchestrator.stability.cases import NONE, case_inputs, find_rail, find_wheel
from orchestrator.stability.poles import Poles, exact_poles

OWN = 2 * np.pi * 1100.0


def one_mode(amplitude: float) -> Modes:
    return Modes(np.array([OWN]), np.array([1e-4]), np.array([[0, amplitude, 0.01, 0]]), ("(3,0) cosine",))


def case1(modes: Modes) -> Poles:
    """Return the poles of Case 1 with a wheel, below 6.5 kHz."""
    structures, contact = case_inputs(read_cases()[0], find_wheel("class158"), find_rail("modal"))
    return exact_poles(modes, NONE if structures.rail_modes is None else structures.rail_modes, contact).below(6500.0)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.02, 0.3), st.floats(0.1, 5.0), st.floats(0.5, 2.0))
def test_an_absorber_splits_a_mode_as_two_masses_on_springs_do(amplitude: float, mass: float, tuning: float) -> None:
    """Both natural frequencies in closed form: w^4 - w^2 (w0^2 + wa^2 (1 + mu)) + w0^2 wa^2 = 0, mu = m a^2 / 2."""
    own, tuned = OWN, tuning * OWN
    mu = 0.5 * mass * amplitude**2
    b, c = own**2 + tuned**2 * (1 + mu), own**2 * tuned**2
    root = np.sqrt(b * b - 4 * c)
    treated = with_absorber(one_mode(amplitude), Absorber("(3,0)", mass, 0.0001, tuned / (2 * np.pi)))
    # 1e-9: b^2 - 4 c loses half of the digits where the two are near each other
    np.testing.assert_allclose(np.sort(treated.modes.omega**2), [2 * c / (b + root), (b + root) / 2], rtol=1e-9)
    assert treated.mass_ratio == pytest.approx(mu, rel=1e-12)
    assert sorted(treated.modes.labels) == ["(3,0) cosine", "(3,0) cosine absorber"]
    # mass is added, none lost: the rigid-body response psi^2 summed over the modes is the mode's own
    np.testing.assert_allclose((treated.modes.shape**2).sum(axis=0), [0, amplitude**2, 1e-4, 0], rtol=1e-9)


def test_the_default_tuning_is_den_hartogs() -> None:
    treated = with_absorber(one_mode(0.117), Absorber("(3,0)", 2.0, 0.1))
    assert treated.frequency_hz == pytest.approx(1100.0 / (1 + 0.117**2), rel=1e-12)


def test_damping_of_an_absorber_is_the_share_of_the_energy_in_its_spring() -> None:
    """On a mode so heavy that it does not move, the absorber is its own spring: zeta = eta/2. Elsewhere below it."""
    heavy = with_absorber(one_mode(1e-6), Absorber("(3,0)", 1.0, 0.1, 500.0)).modes
    assert heavy.zeta[0] == pytest.approx(0.05, rel=1e-6)
    both = with_absorber(one_mode(0.117), Absorber("(3,0)", 2.0, 0.02))
    assert (both.modes.zeta < 0.01).all()
    assert both.modes.zeta.sum() == pytest.approx(0.01, rel=0.05)  # shared between the two, near their common frequency
    assert abs(both.error_db) < 0.2
    assert with_absorber(one_mode(0.117), Absorber("(3,0)", 2.0, 0.3)).error_db < -3  # and it says so where it is rough


def test_both_families_of_a_wheel_get_their_absorber() -> None:
    wheel = class158().modes
    treated = with_absorber(wheel, Absorber("(3,0)", 2.0, 0.1)).modes
    assert len(treated) == len(wheel) + 2
    assert (np.diff(treated.omega) >= 0).all()
    assert len(matching(treated.labels, "(3,0)")) == 4
    np.testing.assert_allclose((treated.shape**2).sum(axis=0), (wheel.shape**2).sum(axis=0), rtol=1e-9)


def test_damping_every_unstable_mode_silences_case_1_and_one_moves_the_tone() -> None:
    """Growth rates: the largest belongs to (3,0); with it damped another one wins; with all damped there is none."""
    wheel = class158().modes
    free = case1(wheel)
    worst = free.frequency_hz[np.argmax(free.growth_rate)]
    assert worst == pytest.approx(1101, abs=2)
    moved = case1(damped(wheel, [read_rule("(3,0)=2e-2")]))
    assert moved.growth_rate.max() > 0
    assert abs(moved.frequency_hz[np.argmax(moved.growth_rate)] - worst) > 100
    # (1,0) takes up to 2 x its 1e-2, the others less; 5e-2 is beyond what any of them needs
    silent = case1(damped(wheel, [read_rule("(*,0)=5e-2"), read_rule("(0,*)=5e-2")]))
    assert silent.growth_rate.max() < 0


def test_an_absorber_stabilises_its_mode() -> None:
    """2 kg on each wheel: no growing pole within a sixth of (3,0), the others grow as before."""
    treated = case1(with_absorber(class158().modes, Absorber("(3,0)", 2.0, 0.1)).modes).unstable()
    free = case1(class158().modes).unstable()
    near = np.abs(np.log(treated.frequency_hz / 1102.0)) < 1 / 6
    assert not near.any()
    assert treated.frequency_hz.size == free.frequency_hz.size - 1


@pytest.mark.parametrize(
    ("text", "old", "new"), [("(3,0)=1e-3", 5e-4, 1e-3), ("(*,0)=+1e-4", 5e-4, 6e-4), ("wheel=x2", 5e-4, 1e-3)]
)
def test_rules_set_add_and_multiply(text: str, old: float, new: float) -> None:
    assert read_rule(text).of(old) == pytest.approx(new, rel=1e-12)


@pytest.mark.parametrize("text", ["(3,0)", "(3,0)=fast", "=1", "(3,0)=-1", "(3,0)=xx2", "(3,0)=inf"])
def test_bad_rules_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"damping .*(must be|must be >= 0)"):
        read_rule(text)


def test_what_does_not_fit_is_refused() -> None:
    wheel = one_mode(0.117)
    with pytest.raises(ValueError, match=r"no mode is called \(9,0\); the labels are \(3,0\) cosine"):
        damped(wheel, [read_rule("(9,0)=1")])
    with pytest.raises(ValueError, match="absorber: mass = -1; must be > 0"):
        Absorber("(3,0)", -1.0, 0.1)
    with pytest.raises(ValueError, match="has no axial motion at the tread"):
        with_absorber(one_mode(0.0), Absorber("(3,0)", 1.0, 0.1))
    bare = Modes(wheel.omega, wheel.zeta, wheel.shape, ("417 Hz",))
    with pytest.raises(ValueError, match="'417 Hz' has no number of nodal diameters"):
        with_absorber(bare, Absorber("417 Hz", 1.0, 0.1))
