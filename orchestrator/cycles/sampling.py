"""The contact over a period: samples of the relative motion in, contact forces and their slopes out. Kernels.

The law is the contact's own; nothing of it is repeated here.
"""

import numpy as np

from fmus.compile import kernel
from fmus.contact.law import law, normal_force
from fmus.contact.layout import OUT, D
from fmus.contact.parameters import P
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
def _forces(parameters, derived, y0, y1, y2, y3):  # type: ignore[no-untyped-def]
    """Return the contact forces (lon, lat, normal, spin) on the wheel as fluctuations."""
    load = normal_force(parameters, derived, -y2)
    lon, lat, spin = law(parameters, derived, y0, y1, y3, load)
    return (
        lon - derived[D.f_lon],
        lat - derived[D.f_lat],
        load - parameters[P.normal_load],
        spin - derived[D.f_spin],
    )


@kernel
def sample_forces(parameters, derived, active, motion, forces):  # type: ignore[no-untyped-def]
    """Put the contact forces at every sample into `forces`.

    Parameters
    ----------
    active : (d,) directions that move, of lon 0, lat 1, normal 2, spin 3
    motion : (N, 4) relative velocities lon and lat [m/s], normal displacement [m], spin velocity [rad/s]
    forces : (N, d), written
    """
    for j in range(motion.shape[0]):
        f = _forces(parameters, derived, motion[j, 0], motion[j, 1], motion[j, 2], motion[j, 3])
        for a in range(active.size):
            forces[j, a] = f[active[a]]


@kernel
def sample_slopes(parameters, derived, active, motion, slopes):  # type: ignore[no-untyped-def]
    """Put the Jacobian of the contact forces, by forward differences, at every sample into `slopes`, (N, d, d)."""
    for j in range(motion.shape[0]):
        y0, y1, y2, y3 = motion[j, 0], motion[j, 1], motion[j, 2], motion[j, 3]
        f = _forces(parameters, derived, y0, y1, y2, y3)
        for b in range(active.size):
            step = VELOCITY_STEP
            if active[b] == 0:
                g = _forces(parameters, derived, y0 + step, y1, y2, y3)
            elif active[b] == 1:
                g = _forces(parameters, derived, y0, y1 + step, y2, y3)
            elif active[b] == 2:
                step = DISPLACEMENT_STEP
                g = _forces(parameters, derived, y0, y1, y2 + step, y3)
            else:
                step = SPIN_STEP
                g = _forces(parameters, derived, y0, y1, y2, y3 + step)
            for a in range(active.size):
                slopes[j, a, b] = (g[active[a]] - f[active[a]]) / step


@kernel
def sample_monitors(parameters, derived, motion, monitors):  # type: ignore[no-untyped-def]
    """Put what the contact's outputs would be at every sample into `monitors`, (N, number of outputs)."""
    for j in range(motion.shape[0]):
        y0, y1, y2, y3 = motion[j, 0], motion[j, 1], motion[j, 2], motion[j, 3]
        lon, lat, normal, spin = _forces(parameters, derived, y0, y1, y2, y3)
        load = normal + parameters[P.normal_load]
        put_monitors(parameters, derived, monitors[j], (y0, y1, y3), (lon, lat, spin), load, -y2)
        monitors[j, OUT.force_evaluations] = 1.0


@kernel
def step_perturbations(tables, shapes, mean, answers, state):  # type: ignore[no-untyped-def]
    """Carry perturbations over one period: each mode steps exactly, the forces are held over a step.

    Parameters
    ----------
    tables : (6, n) exact step of each mode: velocity per velocity, displacement, force; displacement per the same
    shapes : (d, n) motion of each mode in the directions that move
    mean : (d, 2n) relative motion at the start of a step plus that at its end without new forces, per state
    answers : (N, d, d) force of each step per such motion
    state : (2n, m) perturbations: modal velocities, then displacements; overwritten
    """
    d, n = shapes.shape
    seen = np.empty((d, BLOCK))
    force = np.empty((d, BLOCK))
    total = np.empty(BLOCK)
    block = np.empty((2 * n, BLOCK))
    for first in range(0, state.shape[1], BLOCK):  # a few columns at a time stay in the cache
        count = min(BLOCK, state.shape[1] - first)
        block[:, count:] = 0.0
        block[:, :count] = state[:, first : first + count]
        for j in range(answers.shape[0]):
            for a in range(d):
                for c in range(BLOCK):
                    seen[a, c] = 0.0
            for i in range(2 * n):
                for a in range(d):
                    w = mean[a, i]
                    if w != 0.0:
                        for c in range(BLOCK):
                            seen[a, c] += w * block[i, c]
            for a in range(d):
                for c in range(BLOCK):
                    force[a, c] = 0.0
                for b in range(d):
                    w = answers[j, a, b]
                    for c in range(BLOCK):
                        force[a, c] += w * seen[b, c]
            for i in range(n):
                for c in range(BLOCK):
                    total[c] = 0.0
                for a in range(d):
                    w = shapes[a, i]
                    if w != 0.0:
                        for c in range(BLOCK):
                            total[c] += w * force[a, c]
                vv, vu, vf = tables[0, i], tables[1, i], tables[2, i]
                uv, uu, uf = tables[3, i], tables[4, i], tables[5, i]
                for c in range(BLOCK):
                    v = block[i, c]
                    u = block[n + i, c]
                    block[i, c] = vv * v + vu * u + vf * total[c]
                    block[n + i, c] = uv * v + uu * u + uf * total[c]
        state[:, first : first + count] = block[:, :count]
