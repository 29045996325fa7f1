"""The contact law: deflection to normal force, velocities to creep forces. Kernels."""

import math

from ..compile import kernel
from ..creep.blended import blended
from ..creep.fastsim import fastsim
from .friction.coefficient import friction_factor
from .layout import SCRATCH, D
from .parameters import BLENDED, P


@kernel
def normal_force(parameters, derived, deflection):  # type: ignore[no-untyped-def]
    """Return the total normal force [N] at a fluctuation of the deflection [m] (compression positive)."""
    load = derived[D.load]
    if parameters[P.linear_spring] != 0.0:
        return max(0.0, load + derived[D.stiffness] * deflection)
    compression = 1.0 + deflection / derived[D.approach]
    if compression <= 0.0:
        return 0.0
    return load * compression * math.sqrt(compression)


@kernel
def normal_stiffness(parameters, derived, deflection):  # type: ignore[no-untyped-def]
    """Return the slope of `normal_force` [N/m]; 0 where contact is lost."""
    stiffness = derived[D.stiffness]
    if normal_force(parameters, derived, deflection) <= 0.0:
        return 0.0
    if parameters[P.linear_spring] != 0.0:
        return stiffness
    return stiffness * math.sqrt(1.0 + deflection / derived[D.approach])


@kernel
def creep_forces(parameters, derived, creep_lon, creep_lat, creep_spin, load):  # type: ignore[no-untyped-def]
    """Return the total creep forces on the wheel [N, N, N.m] at total creepages and total normal force.

    `derived` lends scratch space, which is zero again afterwards.
    """
    tau = friction_factor(parameters, derived, math.sqrt(creep_lon * creep_lon + creep_lat * creep_lat))
    friction = derived[D.mu0] * load
    a, b = parameters[P.semi_axis_lon], parameters[P.semi_axis_lat]
    cells, strips = int(parameters[P.grid_cells]), int(parameters[P.grid_strips])
    L1, L2, L3 = derived[D.L1], derived[D.L2], derived[D.L3]
    if parameters[P.creep_law] == BLENDED:
        lon, lat, moment = blended(
            creep_lon, creep_lat, creep_spin, friction, derived[D.elliptic_volume], derived[D.parabolic_volume],
            a, b, L1, L2, L3, derived[D.L4], cells, strips, derived, SCRATCH,
        )  # fmt: skip
    else:
        lon, lat, moment = fastsim(
            creep_lon, creep_lat, creep_spin, friction, derived[D.volume],
            a, b, L1, L2, L3, cells, strips, derived, SCRATCH,
        )  # fmt: skip
    return tau * lon, tau * lat, tau * moment


@kernel
def law(parameters, derived, v_lon, v_lat, v_spin, load):  # type: ignore[no-untyped-def]
    """Return the total creep forces at relative velocities that fluctuate about the steady creepages."""
    inverse = 1.0 / parameters[P.rolling_velocity]
    return creep_forces(
        parameters,
        derived,
        derived[D.steady_lon] + v_lon * inverse,
        derived[D.steady_lat] + v_lat * inverse,
        derived[D.steady_spin] + v_spin * inverse,
        load,
    )
