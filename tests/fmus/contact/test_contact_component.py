"""The running contact: spring, loss of contact, monitors, implicit solution, options."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.layout import S
from fmus.contact.parameters import PARAMETERS, P

H = 5e-6
STIFF = {"mobility_lon_lon": 2e-6, "mobility_lat_lat": 4.5e-6, "mobility_ver_ver": 4e-6, "mobility_spin_spin": 3e-4}


def started(**parameters: float) -> Instance:
    instance = Instance(contact(), parameters)
    instance.initialise()
    return instance


def outputs(instance: Instance) -> dict[str, float]:
    names = [v.name for v in instance.component.of("output")]
    return dict(zip(names, instance.outputs.tolist(), strict=True))


def stepped(instance: Instance, **inputs: float) -> dict[str, float]:
    names = [v.name for v in instance.component.of("input")]
    for name, value in inputs.items():
        instance.inputs[names.index(name)] = value
    instance.do_step(H)
    return outputs(instance)


def test_positions_of_the_parameters_are_their_order() -> None:
    assert [PARAMETERS[i].name for i in P] == list(P._fields)


def test_at_rest_nothing_fluctuates() -> None:
    """Totals are the steady state; the forces on wheel and rail, fluctuations, are zero."""
    out = outputs(started())
    assert out["normal_force"] == 60e3
    assert out["tangential_force_lat"] == pytest.approx(-0.3 * 60e3 * (1 - 0.1 * math.exp(-0.25)), rel=1e-12)
    assert out["creepage_lat"] == 0.02
    assert [out[f"{s}_f_{d}"] for s in ("wheel", "rail") for d in ("lon", "lat", "ver", "spin")] == [0.0] * 8


def test_power_is_dissipated_by_sliding() -> None:
    out = outputs(started())
    assert out["power_dissipated"] == pytest.approx(-out["tangential_force_lat"] * 0.02 * 10, rel=1e-12)


@pytest.mark.parametrize("linear", [0, 1])
def test_spring_follows_its_law(linear: int) -> None:
    """N = N0 (1 + d/d0)^(3/2) with d0 = 3/2 N0/K, or N0 + K d; without contact angle d = -(u_wheel - u_rail)."""
    for depth in (-20e-6, 5e-6, 40e-6):
        out = stepped(started(linear_spring=linear, contact_angle=0.0), wheel_u_ver=-depth, rail_u_ver=0.0)
        d0 = 1.5 * 60e3 / 1.2e9
        law = 60e3 + 1.2e9 * depth if linear else 60e3 * (1 + depth / d0) ** 1.5
        assert out["normal_force"] == pytest.approx(law, rel=1e-12)
        assert out["wheel_f_ver"] == pytest.approx(law - 60e3, rel=1e-9)
        assert out["deflection"] == pytest.approx(depth, rel=1e-12)


@pytest.mark.parametrize("linear", [0, 1])
def test_lost_contact_carries_nothing(linear: int) -> None:
    out = stepped(started(linear_spring=linear), wheel_u_ver=1e-3)
    assert out["normal_force"] == 0.0
    assert out["tangential_force_lat"] == pytest.approx(0.0, abs=1e-9)
    assert out["wheel_f_ver"] == pytest.approx(-60e3, rel=0.02)


def test_spring_is_taken_at_the_half_step_ahead() -> None:
    """A wheel that moves down compresses the spring by h/2 times its velocity more."""
    out = stepped(started(contact_angle=0.0), wheel_v_ver=-0.1)
    assert out["deflection"] == pytest.approx(0.5 * H * 0.1, rel=1e-12)


def test_without_displacements_the_velocities_are_integrated() -> None:
    instance = started(contact_angle=0.0, use_displacements=0)
    for k in range(1, 4):
        assert stepped(instance, wheel_v_ver=-0.1)["deflection"] == pytest.approx(k * H * 0.1, rel=1e-12)


def test_forces_turn_with_the_contact_angle() -> None:
    """The contact force on the wheel in track axes, turned by the angle, is (creep force, normal force)."""
    angle = 0.3
    out = stepped(started(contact_angle=angle), wheel_u_ver=-10e-6, wheel_v_lat=0.05)
    steady = outputs(started(contact_angle=angle))
    c, s = math.cos(angle), math.sin(angle)
    lat, ver = out["wheel_f_lat"], out["wheel_f_ver"]
    assert c * lat - s * ver == pytest.approx(out["tangential_force_lat"] - steady["tangential_force_lat"], rel=1e-9)
    assert s * lat + c * ver == pytest.approx(out["normal_force"] - 60e3, rel=1e-9)


@given(st.lists(st.floats(-0.5, 0.5), min_size=8, max_size=8), st.floats(-5e-5, 5e-5))
def test_force_on_the_rail_is_opposite(velocities: list[float], depth: float) -> None:
    instance = started(**STIFF)
    instance.inputs[:8] = velocities
    instance.inputs[9] = -depth
    instance.do_step(H)
    np.testing.assert_array_equal(instance.outputs[0:4], -instance.outputs[4:8])


@given(
    st.lists(
        st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-3, 3), st.floats(-9e-5, 9e-5)),
        min_size=3,
        max_size=8,
    ),
    st.floats(0.0, 2.0),
)
def test_implicit_forces_agree_with_the_velocities_they_cause(
    moves: list[tuple[float, float, float, float]], mobility: float
) -> None:
    """F = g(v_ahead + Y dF) to a thousandth of mu N for any history, from sliding to stick to loss of contact.

    The new forces are put into the law once more: a second contact, explicit, at the velocity that they cause.
    """
    Y = {name: mobility * value for name, value in STIFF.items()}
    instance = started(contact_angle=0.0, **Y)
    explicit = started(contact_angle=0.0)
    for lon, lat, spin, depth in moves:
        before = instance.outputs[[0, 1, 3]].copy()
        seen = instance.state.copy()
        instance.inputs[[0, 1, 3]] = lon, lat - 0.2, spin
        instance.inputs[9] = -depth
        instance.do_step(H)
        change = instance.outputs[[0, 1, 3]] - before
        y = np.array([Y["mobility_lon_lon"], Y["mobility_lat_lat"], Y["mobility_spin_spin"]])
        v = instance.inputs[[0, 1, 3]]
        ahead = v + 0.5 * (v - seen[S.v_lon : S.v_lon + 3] - y * seen[S.d_lon : S.d_lon + 3])
        again = creep_forces(explicit, ahead + y * change, depth)
        scale = 18e3 * np.array([1, 1, 0.007])
        assert abs((again - instance.outputs[[0, 1, 3]]) / scale).max() < 1e-3


def creep_forces(explicit: Instance, velocity: np.ndarray, depth: float) -> np.ndarray:
    """Return the creep-force fluctuations at given relative velocities, without any implicit part."""
    explicit.initialise()
    explicit.state[S.v_lon : S.v_lon + 3] = velocity  # nothing to extrapolate
    explicit.inputs[[0, 1, 3]] = velocity
    explicit.inputs[9] = -depth
    explicit.do_step(H)
    return explicit.outputs[[0, 1, 3]].copy()


def test_sliding_needs_one_evaluation() -> None:
    """A small disturbance of full sliding is solved by the kept Newton matrix at once."""
    instance = started(**STIFF)
    stepped(instance, wheel_v_lat=1e-6)
    counts = [stepped(instance, wheel_v_lat=1e-6 * math.sin(0.1 * k))["force_evaluations"] for k in range(50)]
    assert np.mean(counts) == 1.0


def test_pulse_is_a_half_sine_on_both_bodies() -> None:
    instance = started(pulse_force=100.0, pulse_duration=10 * H, contact_angle=0.0)
    for k in range(1, 15):
        out = stepped(instance)
        mean = (math.cos(math.pi * (k - 1) / 10) - math.cos(math.pi * k / 10)) * 10 / math.pi
        expected = 100 * mean if k <= 10 else 0.0
        assert out["wheel_f_lat"] == pytest.approx(expected, abs=1e-9)
        assert out["tangential_force_lat"] == pytest.approx(outputs(started())["tangential_force_lat"], rel=1e-12)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("mu0", -0.1, r"mu0 = -0.1: must be in the range 0 to 2"),
        ("grid_cells", 2.5, "grid_cells = 2.5: must be a whole number"),
        ("normal_load", math.nan, "normal_load = nan: must be a finite number"),
        ("mass", 1.0, "contact has no parameter 'mass'"),
    ],
)
def test_bad_parameters_are_refused(name: str, value: float, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Instance(contact(), {name: value})


@pytest.mark.parametrize("step", [1e-6, 5e-6, 3.3e-5, 1e-4, 2.5e-4])
def test_the_pulse_has_its_impulse_whatever_the_step(step: float) -> None:
    """Closed form of a half-sine: 2 A T / pi. Sampled at the steps instead, one of 1e-4 s sees none of it."""
    amplitude, duration = 100.0, 1e-4
    instance = started(contact_angle=0.0, pulse_force=amplitude, pulse_duration=duration)
    place = [v.name for v in instance.component.of("output")].index("wheel_f_lat")
    impulse = 0.0
    for _ in range(int(duration / step) + 3):
        impulse += step * instance.outputs[place]
        instance.do_step(step)
    assert impulse == pytest.approx(2 * amplitude * duration / math.pi, rel=1e-9)


@pytest.mark.parametrize("delay", [0, 1])
def test_integrating_both_sides_is_taking_no_displacements(delay: int) -> None:
    """Per side or for both: the same forces; with the delay of other hosts, to its first order."""
    random = np.random.default_rng(3)
    each = started(host_delay_steps=delay, integrate_wheel=1, integrate_rail=1)
    both = started(host_delay_steps=delay, use_displacements=0)
    for _ in range(200):
        each.inputs[:8] = both.inputs[:8] = 1e-3 * random.standard_normal(8)
        for instance in (each, both):
            instance.do_step(5e-6)
    scale = np.abs(both.outputs).max()
    np.testing.assert_allclose(each.outputs, both.outputs, atol=(1e-12 if delay == 0 else 1e-3) * scale)


@given(st.floats(-1e-5, 1e-5), st.floats(-1e-5, 1e-5))
def test_one_side_integrated_is_that_side_s_displacement(wheel: float, rail: float) -> None:
    """A rail that moves at one velocity, given as displacement half a step ahead or integrated: the same deflection."""
    h = 5e-6
    plain, integrated = started(contact_angle=0.0), started(contact_angle=0.0, integrate_rail=1)
    names = [v.name for v in plain.component.of("input")]
    put = [v.name for v in plain.component.of("output")].index("deflection")
    for k in range(1, 4):
        for instance in (plain, integrated):
            instance.inputs[names.index("wheel_u_ver")] = k * wheel
            instance.inputs[names.index("wheel_v_ver")] = wheel / h
            instance.inputs[names.index("rail_v_ver")] = rail / h
        plain.inputs[names.index("rail_u_ver")] = (k - 0.5) * rail
        for instance in (plain, integrated):
            instance.do_step(h)
    assert integrated.outputs[put] == pytest.approx(plain.outputs[put], rel=1e-9, abs=1e-18)
