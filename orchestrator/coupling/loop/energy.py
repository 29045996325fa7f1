"""Energies at the bonds, step by step."""

from __future__ import annotations

from numba import njit


@njit(inline="always")
def remember_motion(plan):  # type: ignore[no-untyped-def]
    """Remember the motion at the bonds before the next step."""
    for b in range(plan.bond_force.size):
        plan.bond_before[b, 0] = plan.y[plan.bond_velocity[b]]
        if plan.bond_way[b] >= 0:
            plan.bond_before[b, 1] = plan.y[plan.bond_way[b]]


@njit(inline="always")
def count_energy(plan, number, h):  # type: ignore[no-untyped-def]
    """Add the step's energy into the structures, and what holding the forces adds; remember the motion.

    Into a structure: the held force times the way, which is exact; where there is no displacement the way is that of
    the trapezoidal rule. Holding adds (F_held - F_new)/2 times the way, if the forces that a contact puts out are those
    at the communication point; one that makes them for the step ahead keeps an account of its own.
    """
    for b in range(plan.bond_force.size):
        c = plan.bond_owner[b]
        if (number + 1) % plan.period[c] != 0:
            continue
        i = plan.bond_force[b]
        velocity = plan.y[plan.bond_velocity[b]]
        way = 0.5 * plan.period[c] * h * plan.bond_gain[b, 0] * (velocity + plan.bond_before[b, 0])
        if plan.bond_way[b] >= 0:
            displacement = plan.y[plan.bond_way[b]]
            way = plan.bond_gain[b, 1] * (displacement - plan.bond_before[b, 1])
            plan.bond_before[b, 1] = displacement
        plan.bond_before[b, 0] = velocity
        new = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
        plan.energy[b, 0] += 0.5 * (plan.u[i] - new) * way
        plan.energy[b, 1] += plan.u[i] * way
