"""The contact with memory: tractions of the particles in the state, forces that agree with them out. Kernels.

Forces are made for the middle of steps, so the particles travel for a step between one evaluation and the next, at the
mean of both velocities. The tractions of the state belong to the evaluation before the last: those of the last are made
again when the next one comes, so that a step can be tried, and differentiated, without a second set.

What all strips share moves with the force itself: over a step of size h it takes C dF/h off the sliding velocity.
"""

import math

from ..compile import kernel
from ..creep.memory import carry
from .friction.coefficient import friction_factor
from .law import law
from .layout import SCRATCH, D, S
from .parameters import MEMORY_ROOM, WITH_MEMORY, P

FOREVER = 1e300
"""Way of the particles [m] after which the contact is steady."""


@kernel
def creep_forces_now(parameters, derived, state, v, load, change, keep):  # type: ignore[no-untyped-def]
    """Return the total creep forces of the law that the parameters mean, steady or with memory.

    Parameters
    ----------
    v : (lon, lat, spin) relative velocities that fluctuate about the steady creepages
    load : total normal force
    change : (lon, lat) of the creep forces from the evaluation before to this one
    keep : whether to let the particles travel; the state is not touched otherwise

    Notes
    -----
    No numbers where the state has no room for the tractions of the grid.
    """
    if parameters[P.creep_law] != WITH_MEMORY:
        return law(parameters, derived, v[0], v[1], v[2], load)
    if parameters[P.grid_cells] * parameters[P.grid_strips] > MEMORY_ROOM:
        return math.nan, math.nan, math.nan
    h = state[S.step]
    velocity = parameters[P.rolling_velocity]
    lon = derived[D.steady_lon] + v[0] / velocity
    lat = derived[D.steady_lat] + v[1] / velocity
    spin = derived[D.steady_spin] + v[2] / velocity
    tau = friction_factor(parameters, derived, math.sqrt(lon * lon + lat * lat))
    way = FOREVER
    if h > 0.0:
        way = velocity * h
        lon += (0.5 * (state[S.was_lon] - v[0]) + derived[D.series_lon] * change[0] / h) / velocity
        lat += (0.5 * (state[S.was_lat] - v[1]) + derived[D.series_lat] * change[1] / h) / velocity
        spin += 0.5 * (state[S.was_spin] - v[2]) / velocity
    # the steady law is tau times FASTSIM, where it sticks too
    return carry(
        tau * lon / derived[D.L1],
        tau * lat / derived[D.L2],
        tau * spin / derived[D.L3],
        tau * derived[D.mu0] * load / derived[D.volume],
        parameters[P.semi_axis_lon], parameters[P.semi_axis_lat],
        int(parameters[P.grid_cells]), int(parameters[P.grid_strips]),
        way, state, S.tractions, keep, derived, SCRATCH,
    )  # fmt: skip


@kernel
def change_to(derived, state, x, pulse):  # type: ignore[no-untyped-def]
    """Return the change (lon, lat) of the creep forces to the fluctuations `x`, of which `pulse` comes from outside."""
    return derived[D.f_lon] + x[0] - state[S.t_lon], derived[D.f_lat] + x[1] - pulse - state[S.t_lat]


@kernel
def last_change(state):  # type: ignore[no-untyped-def]
    """Return the last change (lon, lat) of the creep forces."""
    return state[S.t_lon] - state[S.t_lon_before], state[S.t_lat] - state[S.t_lat_before]


@kernel
def keep_forces(derived, state, x, pulse):  # type: ignore[no-untyped-def]
    """Remember the creep forces of fluctuations `x`, of which `pulse` comes from outside."""
    state[S.t_lon_before] = state[S.t_lon]
    state[S.t_lat_before] = state[S.t_lat]
    state[S.t_lon] = derived[D.f_lon] + x[0]
    state[S.t_lat] = derived[D.f_lat] + x[1] - pulse


@kernel
def keep_tractions(parameters, derived, state):  # type: ignore[no-untyped-def]
    """Let the particles travel as the last evaluation found that they do."""
    if parameters[P.creep_law] == WITH_MEMORY:
        w = (state[S.w_lon], state[S.w_lat], state[S.w_spin])
        load = state[S.f_normal] + derived[D.load]
        creep_forces_now(parameters, derived, state, w, load, last_change(state), True)
