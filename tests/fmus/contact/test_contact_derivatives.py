"""The derivatives that components tell of their outputs, against steps made again with inputs changed a little."""

from __future__ import annotations

import numpy as np
import pytest
from coupled import output
from numpy.typing import NDArray

from fmus.component import Component, Instance
from fmus.contact.component import contact
from fmus.contact.implicit import renew_newton_matrix, renew_with_memory
from fmus.contact.law import law
from fmus.contact.layout import D, S
from fmus.contact.linearised import linearise
from fmus.contact.memory import creep_forces_now, last_change
from fmus.contact.parameters import WITH_MEMORY, P
from fmus.interface import DIRECTIONS, PAIRS
from fmus.rail.component import rail
from fmus.wheel.component import wheel

H = 5e-6
STIFF = {
    "mobility_lon_lon": 2e-6, "mobility_lat_lat": 4.5e-6, "mobility_ver_ver": 4e-6, "mobility_spin_spin": 3e-4,
    "mobility_lat_ver": 5e-7, "mobility_lon_spin": 2e-6, "mobility_lat_spin": -4e-6,
}  # fmt: skip

N_INPUTS = len(contact().of("input"))

Matrix = NDArray[np.float64]


def derivative(instance: Instance) -> Matrix:
    """Return the derivative of all outputs by all inputs, and see that nothing was written."""
    before = instance.memory.copy()
    columns = [instance.differentiate(seed) for seed in np.eye(instance.inputs.size)]
    np.testing.assert_array_equal(instance.memory, before)
    return np.array(columns).T


def repeated_step(instance: Instance, before: Matrix, steps: Matrix) -> Matrix:
    """Return central differences of a step from the state `before` with the inputs that the instance has now."""
    now, inputs = instance.memory.copy(), instance.inputs.copy()
    columns = []
    for change in np.diag(steps):
        found = []
        for sign in (1, -1):
            instance.memory[:] = before
            instance.inputs[:] = inputs + sign * change
            instance.do_step(H)
            found.append(instance.outputs.copy())
        columns.append((found[0] - found[1]) / (2 * abs(change).max()))
    instance.memory[:] = now
    return np.array(columns).T


@pytest.mark.parametrize("component", [wheel(), rail()], ids=lambda c: c.name)
def test_derivative_of_a_structure_is_its_interface_mobility(component: Component) -> None:
    """Velocities by forces: y_*_* itself. Displacements: a step is linear, so differences are exact to rounding."""
    random = np.random.default_rng(1)
    instance = Instance(component)
    instance.initialise()
    assert not derivative(instance).any()  # before the first step no force has acted
    instance.do_step(H)
    before = instance.memory.copy()
    instance.inputs[:] = random.standard_normal(4) * [1e3, 1e3, 1e3, 1]
    instance.do_step(H)
    found = derivative(instance)
    y = np.empty((4, 4))
    for row, column in PAIRS:
        i, j = DIRECTIONS.index(row), DIRECTIONS.index(column)
        y[i, j] = y[j, i] = instance.calculated[f"y_{row}_{column}"]
    np.testing.assert_array_equal(found[:4], y)
    again = repeated_step(instance, before, np.array([1e6, 1e6, 1e6, 1e3]))
    np.testing.assert_allclose(found[:4], again[:4], atol=1e-11 * abs(y).max())
    np.testing.assert_allclose(found[4:], again[4:], atol=1e-11 * abs(found[4:]).max())


SITUATIONS: dict[str, tuple[tuple[float, ...], tuple[float, ...], dict[str, float]]] = {
    # velocities lon, lat, ver, spin and displacements lat, ver of the wheel; what differs from the start values
    "slip": ((0.01, 0.03, 0.0, 0.1), (0.0, -5e-6), {"falling_ratio": 0.0}),
    "slip, falling": ((0.01, 0.03, 0.002, 0.1), (1e-6, -5e-6), {"contact_angle": 0.3}),
    "stick": ((0.002, -0.199, 0.0, 0.3), (0.0, -5e-6), {"saturation_coefficient": 1e-4}),
    "half sliding": ((0.005, -0.183, 0.001, 0.4), (0.0, 2e-6), {"grid_cells": 7, "grid_strips": 9}),
    "lift-off": ((0.01, 0.03, 0.0, 0.1), (0.0, 2e-4), {}),
    "nearly lost": ((0.01, 0.03, 0.0, 0.1), (0.0, 7.4e-5), {}),
    "linear spring": ((0.01, 0.03, 0.001, 0.1), (0.0, -5e-6), {"linear_spring": 1}),
    "linear spring, lift-off": ((0.01, 0.03, 0.0, 0.1), (0.0, 2e-4), {"linear_spring": 1}),
    "slip, late inputs": ((0.01, 0.03, 0.002, 0.1), (1e-6, -5e-6), {"contact_angle": 0.3, "host_delay_steps": 1}),
    "stick, late inputs": (
        (0.002, -0.195, 0.0, 0.3),
        (0.0, -5e-6),
        {"saturation_coefficient": 1e-4, "host_delay_steps": 1},
    ),
    "velocities integrated, late": ((0.01, 0.0, 0.0, 0.1), (0.0, 0.0), {"use_displacements": 0, "host_delay_steps": 1}),
    "memory, slip": ((0.01, 0.03, 0.002, 0.1), (1e-6, -5e-6), {"creep_law": 2}),
    "memory, stick": ((0.002, -0.199, 0.0, 0.3), (0.0, -5e-6), {"creep_law": 2, "saturation_coefficient": 1e-4}),
    "memory, half sliding": ((0.005, -0.183, 0.001, 0.4), (0.0, 2e-6), {"creep_law": 2, "grid_cells": 7}),
    "velocities integrated": ((0.01, 0.0, 0.0, 0.1), (0.0, 0.0), {"use_displacements": 0}),
}


def settled(situation: str) -> Instance:
    """Return a contact that has come to rest at its inputs, with a Newton matrix of that place."""
    velocities, displacements, parameters = SITUATIONS[situation]
    instance = Instance(contact(), {**STIFF, **parameters})
    instance.initialise()
    instance.inputs[:4] = velocities
    instance.inputs[8:10] = displacements
    for _ in range(1500):
        instance.do_step(H)
    w = tuple(instance.state[S.w_lon : S.w_lon + 3])
    load = instance.state[S.f_normal] + instance.derived[D.load]
    arrays = (instance.parameters, instance.derived, instance.state)
    if instance.parameters[P.creep_law] == WITH_MEMORY:
        change = last_change(instance.state)
        g = creep_forces_now(*arrays, w, load, change, False)
        renew_with_memory(*arrays, w, g, load, change)
        return instance
    g = law(instance.parameters, instance.derived, *w, load)
    renew_newton_matrix(*arrays, w, g, load)
    return instance


@pytest.mark.parametrize("situation", SITUATIONS)
def test_derivative_of_the_contact_is_that_of_its_step(situation: str) -> None:
    """Central differences of a step from the same state, each output relative to its largest derivative by an input.

    The step's last Newton iteration uses forward differences over 1e-6 m/s, of velocities of 1e-2 m/s: 1e-4 of error.
    """
    instance = settled(situation)
    before = instance.memory.copy()
    instance.do_step(H)
    steps = np.array([1e-6, 1e-6, 1e-6, 1e-4] * 2 + [1e-11] * 4 + [1e-7, 1e-7, 1e-5, 1e-1, 1e-6])
    found, again = derivative(instance), repeated_step(instance, before, steps)
    largest = abs(found * steps).max(axis=1, keepdims=True) + 1e-300
    np.testing.assert_allclose(found * steps / largest, again * steps / largest, atol=2e-4)


def test_every_derivative_of_the_outputs_is_tested() -> None:
    """In some situation each output but the number of evaluations depends on an input."""
    depends = np.zeros(len(contact().of("output")), dtype=bool)
    for situation in SITUATIONS:
        depends |= derivative(settled(situation)).any(axis=1)
    assert np.flatnonzero(~depends).tolist() == [output(contact(), "force_evaluations")]


def test_derivative_at_rest_in_closed_form() -> None:
    """Before a step dF = H1 dv; after one, dF = (I - H1 Y)^-1 (H1 (3/2 dv + Y_n df_n) + h2 df_n), df_n = -K du."""
    linear = linearise(STIFF)
    instance = Instance(contact(), STIFF)
    instance.initialise()
    tangential = [output(contact(), f"tangential_force_{d}") for d in ("lon", "lat")] + [
        output(contact(), "spin_moment")
    ]
    t = np.array([0, 1, 3])
    seed = np.zeros((4, N_INPUTS))
    seed[:, :4] = linear.turn  # the wheel's velocity in contact axes
    found = np.array([instance.differentiate(s) for s in seed])[:, tangential].T
    scale = abs(linear.H1).max()
    np.testing.assert_allclose(found[:, t], linear.H1, atol=1e-8 * scale)
    instance.do_step(H)
    Y = instance.derived[D.mobility : D.mobility + 12].reshape(3, 4)
    solve = np.linalg.inv(np.eye(3) - linear.H1 @ Y[:, :3])
    found = np.array([instance.differentiate(s) for s in seed])[:, tangential].T
    np.testing.assert_allclose(found[:, t], 1.5 * solve @ linear.H1, atol=1e-8 * scale)
    depth = np.zeros(N_INPUTS)
    depth[8:10] = linear.turn[2, 1:3]  # the wheel's displacement along the normal
    found = instance.differentiate(depth)[tangential]
    expected = -linear.stiffness * solve @ (linear.H1 @ Y[:, 3] + linear.h2)
    np.testing.assert_allclose(found, expected, atol=1e-8 * abs(expected).max())


def test_a_seed_of_the_wrong_length_is_refused() -> None:
    instance = Instance(contact())
    instance.initialise()
    with pytest.raises(ValueError, match=r"seed has shape \(4,\); must be \(17,\), one value per input"):
        instance.differentiate(np.zeros(4))
