"""The twelve equations of a two-axle bogie in a curve. Kernel.

Forces and moments of two wheelsets and a frame, in the track's axes at each axle; small yaw and roll, else nonlinear.
"""

import math

from ..compile import kernel
from .layout import FRAME_Y, FRAME_YAW, N_WHEEL, PER_AXLE, D, N, W, X
from .parameters import P
from .wheel_rail import put_geometry, put_wheels

GRAVITY = 9.80665
"""Standard gravity [m/s2]."""

_SMOOTH = 1e-4
"""Angle over which the friction between frame and body comes to its full moment [rad]."""


@kernel
def lateral_load(parameters, curvature, velocity, cant):  # type: ignore[no-untyped-def]
    """Return the lateral force that cant leaves uncompensated, on one bogie and to the left [N]."""
    q = velocity * velocity * curvature / GRAVITY - cant / (2.0 * parameters[P.half_tape_distance])
    return -2.0 * parameters[P.axle_load] * q


@kernel
def unscale(parameters, derived, unknowns, at):  # type: ignore[no-untyped-def]
    """Put the unknowns, which are in mm, mrad and axle loads, into `derived` in SI units from position `at`."""
    for i in range(N):
        derived[at + i] = 1e-3 * unknowns[i]
    for i in range(2):
        axle = i * PER_AXLE
        derived[at + axle + X.load_left] = parameters[P.axle_load] * unknowns[axle + X.load_left]
        derived[at + axle + X.load_right] = parameters[P.axle_load] * unknowns[axle + X.load_right]


@kernel
def put_residual(parameters, derived, unknowns, curvature, load, mu, out):  # type: ignore[no-untyped-def]
    """Put the twelve residuals, relative to axle load and lever, into `derived` from position `out`.

    Parameters
    ----------
    unknowns : (12,) array, scaled as `unscale` says
    curvature : [1/m]
    load : see `lateral_load` [N]
    mu : friction coefficient
    """
    unscale(parameters, derived, unknowns, D.trial)
    for axle in range(2):
        put_geometry(parameters, derived, axle, D.trial + axle * PER_AXLE)
        put_wheels(parameters, derived, axle, D.trial + axle * PER_AXLE, curvature, mu)
    add_up(parameters, derived, curvature, load, out)


@kernel
def add_up(parameters, derived, curvature, load, out):  # type: ignore[no-untyped-def]
    """Put the residuals of the unknowns in `D.trial` and of the wheels as they stand in `derived` from `out`."""
    at = D.trial
    weight = parameters[P.axle_load]
    r0 = parameters[P.wheel_radius]
    l0 = parameters[P.half_tape_distance]
    a = parameters[P.half_wheelbase]
    frame_y = derived[at + FRAME_Y]
    frame_yaw = derived[at + FRAME_YAW]
    force_sum = 0.0
    moment_sum = 0.0
    for axle in range(2):
        g = 1.0 - 2.0 * axle
        x = at + axle * PER_AXLE
        shift = derived[x + X.y] - (frame_y + g * a * frame_yaw) + 0.5 * curvature * a * a
        turn = derived[x + X.yaw] + g * curvature * a - frame_yaw
        spring_force = -parameters[P.primary_lateral_stiffness] * shift
        spring_moment = -parameters[P.primary_yaw_stiffness] * turn
        force_sum += spring_force
        moment_sum += g * a * spring_force + spring_moment
        e = out + axle * PER_AXLE
        _put_wheelset(parameters, derived, axle, derived[x + X.yaw], e)
        derived[e] += spring_force / weight
        derived[e + 1] += spring_moment / (weight * l0)
        derived[e + 4] += -r0 * spring_force / (weight * l0)
    roll = 0.5 * (r0 * force_sum - parameters[P.load_height] * load) / (weight * l0)
    derived[out + 4] += roll
    derived[out + PER_AXLE + 4] += roll
    side = -1.0 if parameters[P.trailing_bogie] != 0.0 else 1.0
    relative = frame_yaw + side * curvature * parameters[P.half_bogie_spacing]
    body_moment = -parameters[P.secondary_yaw_stiffness] * relative
    if parameters[P.secondary_friction_moment] != 0.0:
        fading = math.expm1(-2.0 * abs(relative) / _SMOOTH)  # tanh by what C's mathematics has everywhere
        friction = -parameters[P.secondary_friction_moment] * fading / (2.0 + fading)
        body_moment -= friction if relative > 0.0 else -friction
    derived[out + FRAME_Y] = (load - force_sum) / weight
    derived[out + FRAME_YAW] = (body_moment - moment_sum) / (weight * l0)


@kernel
def _put_wheelset(parameters, derived, axle, yaw, e):  # type: ignore[no-untyped-def]
    """Put what the contacts of an axle give to its five equations: lateral, yaw, torque, vertical, roll."""
    weight = parameters[P.axle_load]
    r0 = parameters[P.wheel_radius]
    l0 = parameters[P.half_tape_distance]
    lateral = moment = torque = vertical = roll = 0.0
    for side in range(2):
        s = 1.0 - 2.0 * side
        w = D.wheels + (2 * axle + side) * N_WHEEL
        f_lon = derived[w + W.creep_force_lon]
        f_y = -s * derived[w + W.lateral_force]
        f_z = derived[w + W.vertical_force]
        radius = derived[w + W.radius]
        lateral += f_y
        moment += derived[w + W.arm] * f_y - s * l0 * f_lon
        torque += radius * f_lon + derived[w + W.lead] * f_z + yaw * radius * f_y
        vertical += f_z
        roll += s * l0 * f_z
    derived[e] = lateral / weight
    derived[e + 1] = moment / (weight * l0)
    derived[e + 2] = torque / (weight * r0)
    derived[e + 3] = vertical / weight - 1.0
    derived[e + 4] = roll / (weight * l0)
