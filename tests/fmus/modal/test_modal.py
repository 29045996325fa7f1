"""The modal structure against closed forms and against independent routes."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from coupled import modes_of
from hypothesis import given
from hypothesis import strategies as st

from fmus.component import Instance
from fmus.modal.component import structure
from fmus.modal.kernels import _impulse_response
from fmus.modal.modes import Modes, mobility, receptance, state_space
from fmus.rail.component import rail
from fmus.wheel.component import wheel

FREQUENCIES = np.geomspace(10, 6000, 50) * 2 * np.pi


def modes(n: int, seed: int = 0) -> Modes:
    random = np.random.default_rng(seed)
    return Modes(2 * np.pi * random.uniform(50, 5000, n), random.uniform(1e-4, 2.0, n), random.normal(0, 0.1, (n, 4)))


def test_frequency_response_of_the_state_space_equals_the_modal_sum() -> None:
    """C (j w - A)^-1 B is the mobility and C_d (j w - A)^-1 B the receptance; rounding of a 6 x 6 solve only."""
    system = modes(3)
    A, B, C, C_d = state_space(system)
    for omega, Y, alpha in zip(
        FREQUENCIES, mobility(FREQUENCIES, system), receptance(FREQUENCIES, system), strict=True
    ):
        x = np.linalg.solve(1j * omega * np.eye(6) - A, B)
        np.testing.assert_allclose(C @ x, Y, atol=1e-10 * abs(Y).max())
        np.testing.assert_allclose(C_d @ x, alpha, atol=1e-10 * abs(alpha).max())


@pytest.mark.parametrize("component", [wheel(), rail()], ids=["wheel", "rail"])
def test_shipped_structures_are_positive_real(component: object) -> None:
    """The Hermitian part of the mobility is positive semidefinite; the limit is rounding."""
    Y = mobility(FREQUENCIES, modes_of(component))  # type: ignore[arg-type]
    hermitian = 0.5 * (Y + Y.conj().transpose(0, 2, 1))
    scale = abs(Y).max()
    assert np.linalg.eigvalsh(hermitian).min() > -1e-14 * scale


@given(st.integers(0, 10_000), st.integers(1, 6))
def test_receptance_is_reciprocal(seed: int, n: int) -> None:
    """alpha_jk = alpha_kj; tolerance relative to the largest element."""
    alpha = receptance(FREQUENCIES[:3], modes(n, seed))
    np.testing.assert_allclose(alpha, alpha.transpose(0, 2, 1), atol=1e-12 * abs(alpha).max())


@given(
    st.floats(1e-3, 2e5),
    st.one_of(st.floats(0, 3), st.sampled_from([0.0, 1.0, 1 - 1e-9, 1 + 1e-9, 15.0, 60.0])),
    st.floats(1e-7, 1e-4),
)
def test_exact_step_equals_the_matrix_exponential(omega: float, zeta: float, h: float) -> None:
    """g, g' and the integral of g against 50-digit arithmetic, for every kind of damping."""
    with mp.workdps(50):
        block = mp.matrix([[0, 1, 0], [-(mp.mpf(omega) ** 2), -2 * mp.mpf(zeta) * mp.mpf(omega), 1], [0, 0, 0]])
        e = mp.expm(block * mp.mpf(h))
        exact = [float(e[0, 1]), float(e[1, 1]), float(e[0, 2])]
    g, slope, integral = _impulse_response(omega, zeta, h)
    assert g == pytest.approx(exact[0], rel=1e-13, abs=1e-13 * h)
    assert slope == pytest.approx(exact[1], abs=1e-13)
    # displacement per force: its part in a step is of order h^2, cancellation costs some digits of that
    assert integral == pytest.approx(exact[2], rel=1e-9, abs=1e-12 * h * h)


def test_free_mass_accelerates_uniformly() -> None:
    """A mode of frequency 0 under a constant force: v = f t, u = f t^2 / 2 (unit modal mass)."""
    free = structure("free", "", Modes(np.zeros(1), np.zeros(1), np.array([[0, 0, 1.0, 0]])))
    instance = Instance(free)
    instance.initialise()
    instance.inputs[2] = 3.0
    for _ in range(10):
        instance.do_step(1e-3)
    assert instance.outputs[2] == pytest.approx(0.03, rel=1e-12)
    assert instance.outputs[6] == pytest.approx(1.5e-4, rel=1e-12)


def test_interface_mobility_is_the_velocity_after_one_step_of_unit_force() -> None:
    """Published y against the step itself, all ten entries."""
    for component in (wheel(), rail()):
        instance = Instance(component, {"step_size": 7e-6})
        instance.initialise()
        published = np.zeros((4, 4))
        published[np.triu_indices(4)] = list(instance.calculated.values())
        for column in range(4):
            instance.initialise()
            instance.inputs[:] = np.eye(4)[column]
            instance.do_step(7e-6)
            full = published + np.triu(published, 1).T
            np.testing.assert_allclose(instance.outputs[:4], full[:, column], atol=1e-15 * abs(full).max())


def test_unused_modes_change_nothing() -> None:
    """A component with room for more modes gives the same outputs, bit for bit."""
    small, large = (Instance(structure("s", "", modes(3), capacity)) for capacity in (3, 5))
    for instance in (small, large):
        instance.initialise()
        instance.inputs[:] = [1.0, 2.0, 3.0, 4.0]
        for _ in range(20):
            instance.do_step(5e-6)
    np.testing.assert_array_equal(small.outputs, large.outputs)


def test_capacity_below_the_modes_is_refused() -> None:
    with pytest.raises(ValueError, match="capacity is 2; must be at least its 3 modes"):
        structure("s", "", modes(3), 2)


def test_variable_step_gives_the_same_as_one_step() -> None:
    """Steps of any lengths with a held force are exact, so their sum counts only."""
    one, two = (Instance(structure("s", "", modes(3))) for _ in range(2))
    for instance in (one, two):
        instance.initialise()
        instance.inputs[:] = [1.0, -2.0, 3.0, 0.5]
    one.do_step(9e-5)
    for h in (2e-5, 3e-5, 4e-5):
        two.do_step(h)
    np.testing.assert_allclose(two.outputs, one.outputs, rtol=1e-11)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"omega": np.array([-1.0])}, "mode 1: omega = -1; must be finite and >= 0"),
        ({"zeta": np.array([np.nan])}, "mode 1: zeta = nan; must be finite and >= 0"),
        ({"shape": np.array([[0, np.inf, 0, 0]])}, "mode 1: the shape is not finite"),
        ({"shape": np.zeros((1, 3))}, r"must be \(n,\), \(n,\), \(n, 4\)"),
        ({"labels": ("a", "b")}, "2 labels for 1 modes"),
    ],
)
def test_bad_modes_are_refused(change: dict[str, object], message: str) -> None:
    good = {"omega": np.ones(1), "zeta": np.ones(1), "shape": np.ones((1, 4))}
    with pytest.raises(ValueError, match=message):
        Modes(**{**good, **change})  # type: ignore[arg-type]
