"""Friction laws: tables against the law that they sample, invariants of the curve, slopes, bad tables."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.component import Instance
from fmus.contact.component import FAILURE, contact
from fmus.contact.friction.coefficient import friction_coefficient, friction_slope
from fmus.contact.friction.named import NAMED, friction_table
from fmus.contact.linearised import linearise
from fmus.creep.friction import falling_factor
from fmus.errors import DataError


def eq_11(creepage: np.ndarray) -> np.ndarray:
    """Return the paper's friction coefficient."""
    return np.array([0.3 * falling_factor(g, 0.1, 0.005) for g in creepage])


def curve(values: Mapping[str, float], creepage: np.ndarray) -> np.ndarray:
    """Return friction coefficients and slopes of a contact, one row each."""
    instance = Instance(contact(), values)
    instance.initialise()
    arrays = (instance.parameters, instance.derived)
    return np.array([(friction_coefficient(*arrays, g), friction_slope(*arrays, g)) for g in creepage]).T


@pytest.mark.parametrize(
    ("over", "points"),
    [
        ("creepage", np.linspace(0.0, 0.03, 49)),  # 0.02 is a point of it
        ("velocity", np.linspace(0.0, 0.03, 49)),
        ("creepage", np.sort(np.concatenate([np.geomspace(1e-4, 0.1, 47), [0.02 - 2e-5, 0.02, 0.02 + 2e-5]]))),
    ],
)
def test_a_table_of_the_papers_law_gives_its_linear_contact(over: str, points: np.ndarray) -> None:
    """Slopes are of fourth order, or taken over close points: H1 and h2 to 1e-6."""
    scale = 10.0 if over == "velocity" else 1.0
    table, law = linearise(friction_table(scale * points, eq_11(points), over)), linearise()
    np.testing.assert_allclose(table.H1, law.H1, rtol=1e-6, atol=1e-6 * abs(law.H1[1, 1]))
    np.testing.assert_allclose(table.h2, law.h2, rtol=1e-6, atol=1e-12)


def test_the_slope_at_a_point_is_of_fourth_order() -> None:
    errors = []
    for n in (13, 25, 49):
        points = np.linspace(0.01, 0.03, n)  # 0.02 is one of them
        _, slope = curve(friction_table(points, eq_11(points)), np.array([0.02]))
        errors.append(abs(slope[0] / (0.3 * -0.9735009788) - 1.0))
    assert errors[0] / errors[1] > 12.0  # 16 in theory
    assert errors[1] / errors[2] > 12.0


@given(
    st.lists(st.tuples(st.floats(1e-4, 0.02), st.floats(0.05, 0.6)), min_size=2, max_size=12),
    st.floats(0.0, 0.01),
)
def test_the_curve_stays_between_its_points_and_has_a_continuous_slope(
    steps: list[tuple[float, float]], begin: float
) -> None:
    x = begin + np.cumsum([dx for dx, _ in steps])
    y = np.array([friction for _, friction in steps])
    values = friction_table(x, y)
    inside = np.linspace(x[0], x[-1], 101)
    mu, _ = curve(values, inside)
    k = np.clip(np.searchsorted(x, inside, side="right") - 1, 0, x.size - 2)
    rounding = 1e-12
    assert np.all(mu >= np.minimum(y[k], y[k + 1]) - rounding)
    assert np.all(mu <= np.maximum(y[k], y[k + 1]) + rounding)
    at, _ = curve(values, x)
    np.testing.assert_allclose(at, y, rtol=1e-12)
    near = 1e-9 * (x[-1] - x[0])  # curvature is bounded by slopes over widths, at least 1e-4 wide
    below, above = curve(values, x - near)[1], curve(values, x + near)[1]
    np.testing.assert_allclose(below, above, atol=1e-3 * np.max(np.abs(np.diff(y) / np.diff(x))) + 1e-12)
    far, _ = curve(values, np.array([0.0, x[-1], 10.0 * x[-1], 1e3 * x[-1]]))
    assert far.min() >= 0.5 * min(y[0], y[-1]) - rounding


@pytest.mark.parametrize("name", [*NAMED, "table"])
def test_slopes_are_those_of_the_curves(name: str) -> None:
    values = friction_table([0.0, 0.01, 0.03, 0.05], [0.3, 0.28, 0.2, 0.22]) if name == "table" else NAMED[name].values
    creepage = np.array([0.001, 0.004, 0.02, 0.04, 0.2])
    step = 1e-6
    above, below = curve(values, creepage + step)[0], curve(values, creepage - step)[0]
    # the third derivative of the steepest law is below 1e7: error of the difference below 1e-5
    np.testing.assert_allclose(curve(values, creepage)[1], (above - below) / (2 * step), atol=1e-5)


def test_named_laws_have_the_values_of_their_formulas() -> None:
    at = np.array([0.02])  # 0.2 m/s
    expected = {
        "paper": 0.3 * 0.922120,
        "constant": 0.3,
        "de-beer": 0.3 * (1 - 0.5 * np.exp(-0.138 / 0.2) - 0.5 * np.exp(-6.9 / 0.2)),
        "polach-dry": 0.55 * (0.6 * np.exp(-0.12) + 0.4),
        "polach-wet": 0.3 * (0.6 * np.exp(-0.04) + 0.4),
        "friction-modifier": 0.2 * (1 + 0.75 * np.exp(-0.5)),
    }
    assert {name: curve(law.values, at)[0][0] for name, law in NAMED.items()} == pytest.approx(expected, rel=1e-6)
    assert curve(NAMED["friction-modifier"].values, at)[1][0] > 0
    assert all(law.source for law in NAMED.values())


def test_forces_in_full_sliding_are_the_tables() -> None:
    """Whatever mu0 is."""
    instance = Instance(contact(), {**friction_table([0.001, 0.05], [0.4, 0.2]), "mu0": 0.1, "contact_angle": 0.0})
    instance.initialise()
    outputs = dict(zip((v.name for v in instance.component.of("output")), instance.outputs, strict=True))
    expected = 0.4 - 0.2 * 0.019 / 0.049
    assert outputs["friction_coefficient"] == pytest.approx(expected, rel=1e-12)
    assert outputs["tangential_force_lat"] == pytest.approx(-60e3 * expected, rel=1e-12)


@pytest.mark.parametrize(
    ("x", "y", "words"),
    [
        ([0.0, 0.02, 0.01], [0.3, 0.2, 0.2], "point 3: creepage must rise from point to point; got 0.01 after 0.02"),
        ([0.0, 0.02], [0.3, -0.2], "point 2: friction must be above 0 and at most 2; got -0.2"),
        ([-0.1, 0.02], [0.3, 0.2], "point 1: creepage must be 0 or more, a magnitude; got -0.1"),
        ([0.02], [0.3], "must have 2 to 50 points; has 1"),
        (np.linspace(0, 1, 51), np.full(51, 0.3), "must have 2 to 50 points; has 51"),
        ([0.0, np.nan], [0.3, 0.2], "point 2: creepage and friction must be finite numbers; got nan, 0.2"),
    ],
)
def test_bad_tables_are_refused(x: list[float], y: list[float], words: str) -> None:
    with pytest.raises(DataError, match=words):
        friction_table(x, y)


@pytest.mark.parametrize(
    "values",
    [
        {"friction_law": 3},
        {**friction_table([0.0, 0.02], [0.3, 0.2]), "friction_abscissa_002": 0.0},
        {**friction_table([0.0, 0.02], [0.3, 0.2]), "friction_ordinate_001": 0.0},
    ],
)
def test_a_component_says_that_its_table_is_none(values: dict[str, float]) -> None:
    instance = Instance(contact(), values)
    with pytest.raises(DataError) as caught:
        instance.initialise()
    assert str(caught.value) == FAILURE
