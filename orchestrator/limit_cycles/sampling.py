"""The contact over a period: samples of the relative motion in, contact forces and their slopes out. Kernels.

The law is the contact's own; nothing of it is repeated here.
"""

import numpy as np

from fmus.compile import kernel
from fmus.contact.law import law, normal_force
from fmus.contact.layout import D
from fmus.contact.ports import put_monitors

VELOCITY_STEP = 1e-6
"""Step of the forward differences in the velocities [m/s]."""

SPIN_STEP = 1e-6 / 0.007
"""Step in the spin velocity [rad/s]: the same velocity at the edge of the contact patch."""

DISPLACEMENT_STEP = 1e-11
"""Step in the normal displacement [m]."""

BLOCK = 32
"""Perturbations that are followed side by side."""


@kernel
def sample_law(parameters, derived, active, motion, forces, slopes):  # type: ignore[no-untyped-def]
    """Put the contact forces and, by forward differences, their Jacobian at every sample into arrays.

    Parameters
    ----------
    active : (d,) directions that are asked for, of lon 0, lat 1, normal 2, spin 3
    motion : (N, 4) relative velocities lon and lat [m/s], normal displacement [m], spin velocity [rad/s]
    forces : (N, d), written: fluctuations of the forces on the wheel
    slopes : (N, d, d), written; (0, d, d) where they are not wanted
    """
    d = active.size
    for j in range(motion.shape[0]):
        for b in range(-1, d if slopes.shape[0] > 0 else 0):  # -1: without a difference; one call keeps compiling short
            step0 = step1 = step2 = step3 = 0.0
            step = 1.0
            if b >= 0 and active[b] == 0:
                step0 = step = VELOCITY_STEP
            if b >= 0 and active[b] == 1:
                step1 = step = VELOCITY_STEP
            if b >= 0 and active[b] == 2:
                step2 = step = DISPLACEMENT_STEP
            if b >= 0 and active[b] == 3:
                step3 = step = SPIN_STEP
            load = normal_force(parameters, derived, -motion[j, 2] - step2)
            lon, lat, spin = law(
                parameters, derived, motion[j, 0] + step0, motion[j, 1] + step1, motion[j, 3] + step3, load
            )
            f = (
                lon - derived[D.f_lon],
                lat - derived[D.f_lat],
                load - derived[D.load],
                spin - derived[D.f_spin],
            )
            for a in range(d):
                if b < 0:
                    forces[j, a] = f[active[a]]
                else:
                    slopes[j, a, b] = (f[active[a]] - forces[j, a]) / step


@kernel
def sample_monitors(parameters, derived, motion, forces, monitors):  # type: ignore[no-untyped-def]
    """Put what the contact's outputs would be at every sample into `monitors`, (N, number of outputs).

    Parameters
    ----------
    forces : (N, 4) as `sample_law` puts them
    """
    for j in range(motion.shape[0]):
        v = (motion[j, 0], motion[j, 1], motion[j, 3])
        x = (forces[j, 0], forces[j, 1], forces[j, 3])
        load = forces[j, 2] + derived[D.load]
        put_monitors(parameters, derived, monitors[j], v, x, load, -motion[j, 2])


@kernel
def step_perturbations(advance, drive, mean, answers, state):  # type: ignore[no-untyped-def]
    """Carry perturbations over one period: each pair of states steps exactly, the forces are held over a step.

    Parameters
    ----------
    advance : (n, 2, 2) exact step of each pair without force
    drive : (2n, d) what a force held over the step adds
    mean : (d, 2n) relative motion at the start of a step plus that at its end without new forces, per state
    answers : (N, d, d) force of each step per such motion
    state : (2n, m) perturbations, the first of every pair before the second; overwritten
    """
    d, n = answers.shape[1], advance.shape[0]
    seen = np.empty((d, BLOCK))
    force = np.empty((d, BLOCK))
    block = np.empty((2 * n, BLOCK))
    for first in range(0, state.shape[1], BLOCK):  # a few columns at a time stay in the cache
        count = min(BLOCK, state.shape[1] - first)
        block[:, count:] = 0.0
        block[:, :count] = state[:, first : first + count]
        for j in range(answers.shape[0]):
            _add_products(mean, block, seen, True)
            _add_products(answers[j], seen, force, True)
            for i in range(n):
                vv, vu, uv, uu = advance[i, 0, 0], advance[i, 0, 1], advance[i, 1, 0], advance[i, 1, 1]
                for c in range(BLOCK):
                    v = block[i, c]
                    u = block[n + i, c]
                    block[i, c] = vv * v + vu * u
                    block[n + i, c] = uv * v + uu * u
            _add_products(drive, force, block, False)
        state[:, first : first + count] = block[:, :count]


@kernel
def _add_products(left, right, target, from_zero):  # type: ignore[no-untyped-def]
    """Add a matrix product to `target`, or write it there; zeros on the left cost nothing."""
    for a in range(left.shape[0]):
        if from_zero:
            for c in range(BLOCK):
                target[a, c] = 0.0
        for i in range(left.shape[1]):
            w = left[a, i]
            if w != 0.0:
                for c in range(BLOCK):
                    target[a, c] += w * right[i, c]
