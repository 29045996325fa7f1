"""The contact's steady state: parameters, and inputs that are added to them while it runs."""

from __future__ import annotations

import numpy as np
import pytest
from coupled import output
from hypothesis import given
from hypothesis import strategies as st

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.friction.named import friction_table
from fmus.contact.layout import IN, D
from fmus.contact.linearised import linearise
from fmus.contact.parameters import with_changes
from fmus.errors import DataError
from fmus.interface import CHANGE, OPERATING_POINT, contact_inputs

H = 5e-6
STIFF = {"mobility_lon_lon": 2e-6, "mobility_lat_lat": 4.5e-6, "mobility_ver_ver": 4e-6, "mobility_spin_spin": 3e-4}
START = {v.name: v.start or 0.0 for v in contact().of("parameter")}
PARTS = {"steady_creepage_lon": 3e-3, "steady_creepage_lat": -0.015, "steady_creepage_spin": 0.4, "mu0": 0.15}


def run(parameters: dict[str, float], changes: dict[str, float], steps: int = 40) -> Instance:
    """Return a contact that has been shaken, with inputs beside parameters from the start."""
    instance = Instance(contact(), {**STIFF, **parameters})
    for name, change in changes.items():
        instance.inputs[getattr(IN, name + CHANGE)] = change
    instance.initialise()
    motion = np.random.default_rng(3).standard_normal((steps, 12)) * ([0.02] * 8 + [2e-6] * 4)
    for row in motion:
        instance.inputs[:12] = row
        instance.do_step(H)
    return instance


@given(st.dictionaries(st.sampled_from(sorted(PARTS)), st.floats(-1.0, 1.0), min_size=1))
def test_inputs_are_added_to_the_parameters(parts: dict[str, float]) -> None:
    """The sum as the parameter, or a part of it as the input: one contact, to rounding."""
    changes = {name: part * PARTS[name] for name, part in parts.items()}
    whole = run({name: START[name] + change for name, change in changes.items()}, {})
    both = run({}, changes)
    np.testing.assert_allclose(both.outputs, whole.outputs, rtol=1e-8, atol=1e-9)


def test_inputs_left_alone_change_no_bit() -> None:
    parameters = {"mu0": 0.41, "steady_creepage_lat": -0.0137, "normal_load": 51e3}
    instance = run(parameters, {})
    names = ("steady_lat", "load", "mu0", "stiffness", "approach")
    found = [instance.derived[getattr(D, name)] for name in names]
    assert found == [-0.0137, 51e3, 0.41, START["hertz_stiffness"], 1.5 * 51e3 / START["hertz_stiffness"]]


@pytest.mark.parametrize("linear", [0, 1])
def test_a_change_of_the_load_keeps_the_elastic_constant(linear: int) -> None:
    """N ~ d^(3/2), so the stiffness at the steady load follows its cube root."""
    both = run({"linear_spring": linear}, {"normal_load": -20e3})
    stiffness = START["hertz_stiffness"] * (40 / 60) ** (1 / 3)
    whole = run({"linear_spring": linear, "normal_load": 40e3, "hertz_stiffness": stiffness}, {})
    np.testing.assert_allclose(both.outputs, whole.outputs, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("name", [port.name for port in OPERATING_POINT])
def test_forces_do_not_jump_when_the_steady_state_moves(name: str) -> None:
    """At rest wheel and rail feel nothing of it; the totals are those of the new steady state."""
    instance = Instance(contact(), STIFF)
    instance.initialise()
    change = {**PARTS, "normal_load": 5e3}[name]
    for k in range(1, 21):
        instance.inputs[getattr(IN, name + CHANGE)] = change * k / 20
        instance.do_step(H)
        # the last Newton step leaves some 1e-9 of the friction force
        assert abs(instance.outputs[:8]).max() < 1e-7 * 18e3
    values = with_changes({**START, name + CHANGE: change})
    moved = Instance(contact(), {n: values[n] for n in (name, "hertz_stiffness")})
    moved.initialise()
    for total in ("normal_force", "tangential_force_lon", "tangential_force_lat", "spin_moment"):
        at = output(contact(), total)
        assert instance.outputs[at] == pytest.approx(moved.outputs[at], rel=1e-6, abs=1e-6)


def test_a_friction_table_moves_as_a_whole() -> None:
    """Each law is friction without sliding times a factor: of a level table only the first is there."""
    table = friction_table([0.0, 0.05], [0.4, 0.4])
    instance = run(table, {"mu0": -0.1}, steps=1)
    assert instance.outputs[output(contact(), "friction_coefficient")] == pytest.approx(0.3, rel=1e-12)
    with pytest.raises(DataError, match=r"mu0_change = -0\.1 moves a friction table"):
        with_changes({**START, **table, "mu0_change": -0.1})


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("mu0", -0.31),
        ("mu0", 1.71),
        ("steady_creepage_lat", 0.49),
        ("steady_creepage_lon", -0.51),
        ("steady_creepage_spin", 51.0),
        ("normal_load", -60e3),
    ],
)
def test_a_sum_outside_the_range_of_the_parameter_is_an_error(name: str, change: float) -> None:
    with pytest.raises(DataError, match="a parameter and its change together are out of the parameter's range"):
        run({}, {name: change})
    late = run({}, {}, steps=1)
    late.inputs[getattr(IN, name + CHANGE)] = change
    with pytest.raises(DataError, match="a parameter and its change together"):
        late.do_step(H)


def test_the_linear_contact_is_that_of_the_sum() -> None:
    """Slopes by `linearise` against the running contact's own directional derivative before the first step."""
    changes = {"mu0": 0.1, "steady_creepage_lat": -0.005}
    instance = Instance(contact())
    for name, change in changes.items():
        instance.inputs[getattr(IN, name + CHANGE)] = change
    instance.initialise()
    seed = np.zeros(instance.inputs.size)
    seed[IN.wheel_v_lon] = 1.0
    found = instance.differentiate(seed)[output(contact(), "tangential_force_lon")]
    law = with_changes({**START, **{name + CHANGE: change for name, change in changes.items()}})
    assert found == pytest.approx(linearise(law).H1[0, 0], rel=1e-6)


def test_the_contract_names_both_kinds() -> None:
    declared = {v.name: v for v in contact().variables}
    for port in OPERATING_POINT:
        assert declared[port.name].causality == "parameter"
        assert (declared[port.name + CHANGE].causality, declared[port.name + CHANGE].start) == ("input", 0.0)
        assert declared[port.name + CHANGE].unit == declared[port.name].unit
    assert len(contact().of("input")) == len(contact_inputs()) + len(OPERATING_POINT)
