"""Twelve equations of a bogie in a curve: published values, closed forms, invariants."""

from __future__ import annotations

import csv
from math import atan, cos, degrees, hypot, sin, tan
from pathlib import Path

import pytest
from curving_cases import L0, R0, A, W, balanced, linear_bogie, solved, stiffness_of_creep, unbalanced
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.curving.bogie import PLACES, Bogie, BogieState, Curve

CHECK_VALUES = Path(__file__).with_name("check_values.csv")
"""Reference vehicle, balanced speed, left curve, mu 0.3: two programs written apart gave every digit of it."""


def rows() -> list[dict[str, str]]:
    with CHECK_VALUES.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row['radius']}-{row['place']}")
def test_check_values_to_the_digits_printed(row: dict[str, str]) -> None:
    """Tolerance: one unit in the last digit printed. Kalker's coefficients of the patch are given with the vehicle."""
    radius = float(row["radius"])
    state = solved(balanced(radius))
    wheel = state.place(1.0, row["place"])
    axle = 0 if row["place"].startswith("leading") else 1
    found = {
        "y_mm": 1e3 * state.shift[axle], "yaw_mrad": 1e3 * state.yaw[axle],
        "gamma1_milli": 1e3 * wheel.steady_creepage_lon, "gamma2_milli": 1e3 * wheel.steady_creepage_lat,
        "gamma6": wheel.steady_creepage_spin, "load_kn": wheel.normal_load / 1e3,
        "angle_deg": degrees(wheel.contact_angle),
    }  # fmt: skip
    for name, value in found.items():
        digits = len(row[name].partition(".")[2])
        assert value == pytest.approx(float(row[name]), abs=1.01 * 10**-digits), name
    assert state.residual < 1e-12


@pytest.mark.parametrize(
    ("radius", "wanted"),
    [(1000, (-6.9803, -1.9279, -0.0123)), (300, (-8.0493, -7.5952, -0.8965)), (130, (-8.2741, -17.7775, 0.2333))],
)
def test_fastsim_instead_of_the_closed_form(radius: float, wanted: tuple[float, ...]) -> None:
    """Independent FASTSIM on 30 x 30, of first order: 1/30 of the slip is there twice. So 1 % of the largest."""
    state = solved(balanced(radius), use_fastsim=1.0)
    found = (1e3 * state.shift[0], 1e3 * state.yaw[0], 1e3 * state.yaw[1])
    assert found == pytest.approx(wanted, abs=0.01 * max(abs(w) for w in wanted))


def test_cant_deficiency_moves_load_and_hardly_the_angle() -> None:
    state = solved(unbalanced(150, 0.05))
    loads = [state.place(1, p).normal_load / 1e3 for p in PLACES]
    assert loads == pytest.approx([50.489, 76.950, 58.888, 61.575], abs=1.01e-3)
    mm_mrad = (state.shift[0], state.yaw[0], state.shift[1], state.yaw[1])
    assert [1e3 * x for x in mm_mrad] == pytest.approx([-8.3096, -15.8425, 5.4502, -0.7539], abs=1.01e-4)


@pytest.mark.parametrize(
    ("mu", "wanted"),
    [
        (0.1, (-5.16, -9.40, -12.05, -14.48, -16.85, -22.70)),
        (0.5, (-3.25, -6.46, -10.87, -15.67, -19.15, -25.75)),
    ],
)
def test_friction_hardly_changes_the_inner_wheel(mu: float, wanted: tuple[float, ...]) -> None:
    bogie = Bogie()
    radii = (500, 300, 200, 150, 120, 80)
    found = [1e3 * bogie.solve(balanced(r, friction=mu)).place(1, "leading_inner").steady_creepage_lat for r in radii]
    assert found == pytest.approx(wanted, abs=0.0101)


def test_sensitivities_at_150_m() -> None:
    def inner(**parameters: float) -> float:
        return 1e3 * solved(balanced(150), None, **parameters).place(1, "leading_inner").steady_creepage_lat

    yaw_stiffness = [inner(primary_yaw_stiffness=k) for k in (3e6, 10e6, 100e6)]
    assert yaw_stiffness == pytest.approx([-13.1, -16.0, -15.9], abs=0.06)
    assert [inner(conicity=c) for c in (0.025, 0.2)] == pytest.approx([-16.1, -15.6], abs=0.06)
    assert inner(trailing_bogie=1.0) == pytest.approx(-15.2, abs=0.06)


@given(st.floats(1e-7, 2e-4), st.floats(0.02, 0.3))
@settings(max_examples=20, deadline=None)
def test_free_wheelsets_follow_the_rolling_line(curvature: float, conicity: float) -> None:
    """Springs of 1 N/m and 1 N.m/rad: y = -r0 l0 kappa / lambda and no yaw; 1e-9 is what such springs leave."""
    bogie = linear_bogie(
        curvature, conicity, primary_yaw_stiffness=1.0, primary_lateral_stiffness=1.0, secondary_yaw_stiffness=1.0
    )
    line = -R0 * L0 * curvature / conicity
    assert bogie.shift == pytest.approx((line, line), rel=0, abs=1e-9)
    assert bogie.yaw == pytest.approx((0, 0), abs=1e-9)


@pytest.mark.parametrize("yaw_stiffness", [1e5, 1e6, 1e7, 1e8])
@pytest.mark.parametrize("lateral_stiffness", [1e6, 8e6])
def test_linear_bogie_has_its_closed_form(yaw_stiffness: float, lateral_stiffness: float) -> None:
    """At R = 1e6 m what is not linear is below 1e-8 of the result."""
    radius, conicity = 1e6, 0.05
    f11, f22 = stiffness_of_creep()
    bogie = linear_bogie(
        1 / radius, conicity, primary_yaw_stiffness=yaw_stiffness, primary_lateral_stiffness=lateral_stiffness,
        secondary_yaw_stiffness=0.0,
    )  # fmt: skip
    softness = 1 / lateral_stiffness + A**2 / yaw_stiffness
    wanted = -(A / radius) / (1 + 4 * f11 * f22 * L0 * conicity / (R0 * yaw_stiffness) * softness)
    assert bogie.yaw == pytest.approx((wanted, -wanted), rel=1e-8)


@pytest.mark.parametrize("radius", [500, 200, 100])
def test_rigid_unit_keeps_its_axles_parallel(radius: float) -> None:
    """Parallel axles differ by the angle of the track between them, 2a/R, but for what the springs give.

    Creep forces of at most mu N on four wheels twist them by less than 1e5 N.m over 1e12 N.m/rad.
    """
    state = solved(
        balanced(radius), None, half_wheelbase=1.0, primary_yaw_stiffness=1e12, primary_lateral_stiffness=1e11,
        secondary_yaw_stiffness=0.0,
    )  # fmt: skip
    assert state.yaw[1] - state.yaw[0] == pytest.approx(2 * 1.0 / radius, abs=1e-7)


curves = st.builds(
    unbalanced,
    st.floats(150, 3000),
    st.floats(-0.04, 0.06),
    st.floats(2, 14),
    friction=st.floats(0.1, 0.5),
)


@given(curves)
@settings(max_examples=8, deadline=None)
def test_friction_bound_and_power_balance(curve: Curve) -> None:
    """The power that traction puts in is what creep takes out, per wheelset; it closes to the torque's residual."""
    bogie = Bogie()
    state = bogie.solve(curve)
    for axle in ("leading", "trailing"):
        left, right = state.wheels[f"{axle}_left"], state.wheels[f"{axle}_right"]
        work = -(left.creep_force_lon + right.creep_force_lon)
        work += curve.curvature * L0 * (left.creep_force_lon - right.creep_force_lon)
        lost = -sum(
            w.creep_force_lon * w.steady_creepage_lon + w.creep_force_lat * w.steady_creepage_lat for w in (left, right)
        )
        assert work == pytest.approx(lost, abs=1e-9 * W)
        assert lost >= 0
    for w in state.wheels.values():
        assert hypot(w.creep_force_lon, w.creep_force_lat) <= curve.friction * w.normal_load * (1 + 1e-12)
        assert w.friction_utilisation <= 1 + 1e-12


@given(curves)
@settings(max_examples=25, deadline=None)
def test_contacts_carry_weight_and_lateral_load(curve: Curve) -> None:
    """All contact forces together: two axle loads, the lateral load and its moment about the track's axis."""
    q = curve.speed**2 * curve.curvature / 9.80665 - curve.cant / (2 * L0)
    state = Bogie().solve(curve)
    vertical = lateral = roll = 0.0
    for name, w in state.wheels.items():
        s = 1 if name.endswith("left") else -1
        vertical += w.normal_load * cos(w.contact_angle) - w.creep_force_lat * sin(w.contact_angle)
        lateral += -s * w.lateral_force
        roll += s * L0 * (w.normal_load * cos(w.contact_angle) - w.creep_force_lat * sin(w.contact_angle))
    assert vertical == pytest.approx(2 * W, rel=1e-11)
    assert lateral == pytest.approx(2 * W * q, abs=1e-11 * W)
    assert roll == pytest.approx(-1.5 * 2 * W * q, abs=1e-10 * W * L0)


@given(curves)
@settings(max_examples=10, deadline=None)
def test_a_right_curve_is_the_mirror_image(curve: Curve) -> None:
    """Shift and yaw change sign, left and right wheel change places, to what a residual of 1e-12 leaves.

    Creep makes ten axle loads of force per hundredth of creepage, so forces are right to ten times that.
    """
    left = Bogie().solve(curve)
    right = Bogie().solve(Curve(-curve.curvature, curve.speed, curve.cant, curve.friction))
    assert right.shift == pytest.approx([-y for y in left.shift], abs=1e-12)
    assert right.yaw == pytest.approx([-y for y in left.yaw], abs=1e-12)
    for place in PLACES:
        one, other = vars(left.place(1, place)), vars(right.place(-1, place))
        for name, value in one.items():
            size = 10 * W if "force" in name or "load" in name or "stiffness" in name else 1.0
            assert other[name] == pytest.approx(value, rel=1e-12, abs=1e-12 * size), name


def flange_ratio(state: BogieState) -> tuple[float, float, float]:
    """Return Y/Q of the leading outer wheel, what its forces say, and Nadal's lower bound."""
    w = state.place(1, "leading_outer")
    lateral = w.lateral_force
    vertical = w.normal_load * cos(w.contact_angle) - w.creep_force_lat * sin(w.contact_angle)
    mu_y = -w.creep_force_lat / w.normal_load
    nadal = (tan(w.contact_angle) - 0.3) / (1 + 0.3 * tan(w.contact_angle))
    return lateral / vertical, tan(w.contact_angle - atan(mu_y)), nadal


def test_flange_force_is_that_of_its_angle() -> None:
    ratio, identity, nadal = flange_ratio(solved(balanced(150)))
    assert ratio == pytest.approx(identity, rel=1e-12)
    assert ratio == pytest.approx(0.5361, abs=5e-5)
    assert nadal == pytest.approx(0.5329, abs=5e-5)
    assert nadal < ratio


def test_warm_and_cold_starts_meet() -> None:
    """Back and forth through other curves, then the same curve: the same solution to the solver's tolerance."""
    bogie = Bogie()
    for radius in (3000, 100, -200, 400):
        bogie.solve(Curve(1 / radius, 10.0, 0.05))
    warm = bogie.solve(balanced(150))
    cold = solved(balanced(150))
    assert warm.shift == pytest.approx(cold.shift, rel=1e-9)
    assert warm.yaw == pytest.approx(cold.yaw, rel=1e-9)


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        (Curve(1 / 15), "15 m radius: .*; found down to a radius of 2"),
        (Curve(1 / 150, 40.0), "150 m radius: a wheel lifts off its rail"),
        (Curve(-1 / 400, 60.0), "400 m radius: a wheel lifts off its rail"),
    ],
)
def test_what_has_no_steady_state_is_said(curve: Curve, words: str) -> None:
    bogie = Bogie()
    with pytest.raises(ValueError, match=words):
        bogie.solve(curve)
    again = bogie.solve(balanced(150))  # nothing of the failure is kept
    assert again.shift == pytest.approx(solved(balanced(150)).shift, rel=1e-12)


def test_inputs_out_of_range_are_refused() -> None:
    for values in ((0.2, 10.0, 0.0, 0.3), (0.01, 0.0, 0.0, 0.3), (0.01, 10.0, 0.5, 0.3), (0.01, 10.0, 0.0, 0.0)):
        with pytest.raises(ValueError, match="must be in the range"):
            Curve(*values)
    with pytest.raises(ValueError, match="primary_yaw_stiffness = -1: must be in the range"):
        Bogie({"primary_yaw_stiffness": -1.0})
