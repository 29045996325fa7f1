"""The contact's account of energy: what the structures got, less what the law gives. Kernels.

Forces are held over steps, made for velocities and a deflection ahead. The law takes the power F w out of the sliding
at the velocity w that the forces were solved at, and the spring gives what its potential loses. The structures get the
held force times the way that they really go. What they get beyond the law is energy that the coupling has added:

    sum of F (h v - h w) in the contact plane, F_n du_n + dV in the normal direction,

with v the mean of the velocities at both ends of a step. It tends to 0 like h^2, and to the bit it is what would be
missing in a balance of the whole system, but for the trapezoidal rule of the ways in the contact plane, which leaves
(omega h)^2/12 of the work.
"""

import math

from ..compile import kernel
from .layout import D, S
from .parameters import P


@kernel
def _potential(parameters, derived, deflection):  # type: ignore[no-untyped-def]
    """Return the energy [J] of the fluctuation of the normal force at a fluctuation of the deflection."""
    load = derived[D.load]
    if parameters[P.linear_spring] != 0.0:
        stiffness = derived[D.stiffness]
        pressed = max(deflection, -load / stiffness)
        return 0.5 * stiffness * pressed * pressed + load * (pressed - deflection)
    compression = max(0.0, 1.0 + deflection / derived[D.approach])
    return load * (0.4 * derived[D.approach] * (compression * compression * math.sqrt(compression) - 1.0) - deflection)


@kernel
def keep_account(parameters, derived, state, v, v_integrated, u_normal, h):  # type: ignore[no-untyped-def]
    """Add what the last step, of size h (0: none yet), added; `state` still has the forces that were held over it."""
    late = parameters[P.host_delay_steps]
    way = state[S.way_integrated] + 0.5 * h * (v_integrated + state[S.v_integrated])
    place = u_normal + way
    if h > 0.0 and (late == 0.0 or state[S.steps] > 0.0):
        for i in range(3):
            # a late host shows the end of the step before
            held = state[S.f_lon + i] - late * state[S.d_lon + i]
            solved = state[S.was_lon + i] if late != 0.0 else state[S.w_lon + i]
            state[S.energy_added_lon + i] += h * held * (0.5 * (v[i] + state[S.v_lon + i]) - solved)
        held = state[S.f_normal] - late * state[S.d_normal]
        state[S.energy_added_normal] += (
            held * (place - state[S.place])
            + _potential(parameters, derived, -place)
            - _potential(parameters, derived, -state[S.place])
        )
    state[S.place] = place
    state[S.way_integrated] = way
    state[S.v_integrated] = v_integrated
    for i in range(3):
        state[S.was_lon + i] = state[S.w_lon + i]
