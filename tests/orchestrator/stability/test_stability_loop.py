"""The loop in the frequency domain against the scalar formula, the closed-loop poles and symmetries."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.modal.data import read_modal_data
from fmus.modal.modes import Modes
from fmus.rail.component import DATA as RAIL_DATA
from fmus.wheel.wheelset import DATA, read_wheelset
from orchestrator.errors import InputError
from orchestrator.stability.analysis import Structures, analyse
from orchestrator.stability.cases import NONE, find_case, find_rail, find_wheel
from orchestrator.stability.eigenloci import Eigenloci, _tracked
from orchestrator.stability.loop import Loop, linear_contact, of_modes, rigid

WHEEL = read_wheelset(DATA / "generic840.toml").modes
RAIL = read_modal_data(RAIL_DATA / "rail.toml").modes
CONTACTS = {"falling": linear_contact(), "constant": linear_contact({"falling_ratio": 0.0})}


def structures(rail: Modes) -> Structures:
    return Structures(of_modes(WHEEL), of_modes(rail) if len(rail) else rigid, WHEEL, rail)


def random_wheel(seed: int, n: int) -> Modes:
    """Return a wheel of cosine and sine modes: lateral and vertical, or longitudinal and spin."""
    random = np.random.default_rng(seed)
    shape = random.normal(0, 0.1, (n, 4)) * np.where(np.arange(n)[:, None] % 2, [1, 0, 0, 1], [0, 1, 1, 0])
    return Modes(2 * np.pi * random.uniform(50, 4000, n), random.uniform(1e-4, 1e-2, n), shape)


@given(st.integers(0, 10_000), st.integers(1, 12))
def test_scalar_formula_is_an_eigenvalue_of_the_matrix(seed: int, n: int) -> None:
    """For an axisymmetric wheel the lateral locus is on its own; 1e-12 of the largest eigenvalue: rounding."""
    wheel = random_wheel(seed, n)
    omega = 2 * np.pi * np.geomspace(20, 5000, 60)
    for law in CONTACTS.values():
        loop = Loop(of_modes(wheel), of_modes(RAIL), law)
        eigenvalues = np.linalg.eigvals(loop.open_loop(omega))
        distance = np.abs(eigenvalues - loop.lateral(omega)[:, None]).min(axis=1)
        assert (distance < 1e-12 * np.maximum(np.abs(eigenvalues).max(axis=1), 1)).all()


@pytest.mark.parametrize("rail", [RAIL, NONE], ids=["modal rail", "rigid rail"])
@pytest.mark.parametrize("law", CONTACTS)
def test_encirclements_count_the_unstable_poles(law: str, rail: Modes) -> None:
    """Generalised Nyquist criterion against eigenvalues of the coupled state matrix: the same number of pairs."""
    result = analyse(structures(rail), CONTACTS[law])
    assert result.poles is not None
    assert result.unstable_pairs == result.poles.unstable().frequency_hz.size
    assert abs(result.turns.sum() - result.unstable_pairs) < 0.05  # the loci end near, not on, the real axis
    assert all(crossing.crossing.clockwise for crossing in result.instabilities)


def test_sliding_to_the_other_side_is_stable_under_constant_friction() -> None:
    """The sign of the creepage decides: flipped, nothing is unstable at or above 150 Hz with or without the rail."""
    law = linear_contact({"falling_ratio": 0.0, "steady_creepage_lat": -0.02})
    for rail in (RAIL, NONE):
        poles = analyse(structures(rail), law).poles
        assert poles is not None
        assert not (poles.unstable().frequency_hz >= 150).any()


@pytest.mark.parametrize("rail", [RAIL, NONE], ids=["modal rail", "rigid rail"])
def test_without_friction_nothing_is_unstable(rail: Modes) -> None:
    """With mu = 0 wheel, rail and spring are passive: the loop is zero."""
    result = analyse(structures(rail), linear_contact({"mu0": 0.0}))
    assert result.unstable_pairs == 0
    assert not result.instabilities


@given(st.integers(0, 1000))
def test_tracking_undoes_any_exchange_of_eigenvalues(seed: int) -> None:
    """Three smooth loci that are shuffled at every frequency come back, up to one order for all."""
    random = np.random.default_rng(seed)
    t = np.linspace(0, 1, 200)[:, None]
    smooth = np.exp(2j * np.pi * t * [0.3, 0.7, 1.0]) * [1.0, 2.0, 3.5]
    shuffled = np.array([row[random.permutation(3)] for row in smooth])
    tracked = _tracked(shuffled)
    order = np.abs(tracked[0]).argsort()
    np.testing.assert_array_equal(tracked[:, order], smooth)


def test_dominant_locus_is_the_largest() -> None:
    loci = Eigenloci(np.array([1.0, 2.0]), np.array([[1.0, 2j, 0.5], [-3.0, 2j, 0.5]], dtype=complex))
    assert loci.dominant.tolist() == [1, 0]


def test_slope_at_a_corner_of_the_friction_law_is_refused() -> None:
    """Friction that falls to nothing within a creepage of 1e-8 has no slope at rest."""
    with pytest.raises(InputError, match="slope of the friction law is undefined at steady_creepage_lat = 0"):
        linear_contact({"steady_creepage_lat": 0.0, "saturation_coefficient": 1e-7, "falling_ratio": 1.0})


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: find_wheel("no-such-wheel"), "neither class158"),
        (
            lambda: find_rail("steel"),
            "must be analytic, modal, one of bs113a, default, rail-dampers, slab, soft-pads, a track file or",
        ),
        (lambda: find_case("case9"), "neither a case"),
        (lambda: linear_contact({"mu0": -1.0}), "mu0 = -1: must be in the range"),
    ],
)
def test_bad_input_is_one_sentence(call: object, text: str) -> None:
    assert callable(call)
    with pytest.raises(InputError, match=text) as error:
        call()
    assert "\n" not in str(error.value)
