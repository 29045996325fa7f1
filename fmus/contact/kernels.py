"""The running contact: velocities and displacements of wheel and rail in, forces out. Kernels.

Contact axes are the contract's, turned about the longitudinal axis by the contact angle: lon, lat in the contact plane,
normal from the rail into the wheel. Forces act on the wheel; the rail has the opposite.

The forces are held over the next step, so they are made for its middle. The normal spring is taken at u + h/2 v, which
cancels the delay of a held force. The creep forces solve

    F = g(v_ahead + Y (F - F_held)),

g the friction law and Y the interface mobility of wheel and rail together: the velocity that the new force itself
causes counts at once (in stick nothing explicit is stable). v_ahead extrapolates the rest of the velocity, see
`prediction`. That makes the coupling second order.
The Newton matrix (I - g' Y)^-1 is kept from step to step and renewed only when it no longer converges.
"""

import math

from ..compile import kernel
from ..creep.blended import spin_flexibility, volumes
from ..creep.fastsim import bound_volume, flexibilities
from ..creep.kalker import creepage_coefficients
from ..creep.memory import series_compliances
from .account import keep_account
from .derivatives import differentiate
from .friction.coefficient import prepare_friction
from .implicit import renew_newton_matrix, solve_creep_forces
from .law import normal_force
from .layout import OUT, STATE_SIZE, D, S
from .memory import keep_forces, keep_tractions
from .operating_point import follow_operating_point, put_operating_point
from .parameters import P
from .ports import put_forces, put_monitors, relative_motion
from .prediction import look_ahead

__all__ = ["differentiate", "do_step", "initialise"]


@kernel
def mean_pulse(parameters, begin, end):  # type: ignore[no-untyped-def]
    """Return the mean of the half-sine force pulse over a step that has passed; it is held over the next one.

    Late by a step, and of the same impulse for every size of the step, one longer than the pulse included.
    """
    duration = parameters[P.pulse_duration]
    if end <= begin or begin >= duration:
        return 0.0
    phase = math.pi / duration
    impulse = (math.cos(phase * begin) - math.cos(phase * min(end, duration))) / phase
    return parameters[P.pulse_force] * impulse / (end - begin)


@kernel
def _apply(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Evaluate the contact at the inputs, for forces that are held over the next `h` seconds; update the state."""
    v, v_normal, v_integrated, u_normal = relative_motion(parameters, derived, inputs)
    keep_account(parameters, derived, state, v, v_integrated, u_normal, h)
    ahead, deflection = look_ahead(parameters, derived, state, v, v_normal, v_integrated, u_normal, h)
    load = normal_force(parameters, derived, deflection)
    f_normal = load - derived[D.load]
    pulse = mean_pulse(parameters, state[S.elapsed] - h, state[S.elapsed])
    x, w, evaluations = solve_creep_forces(parameters, derived, state, ahead, f_normal, pulse)
    for i in range(3):
        state[S.d_lon + i] = x[i] - state[S.f_lon + i]
        state[S.f_lon + i] = x[i]
        state[S.v_lon + i] = v[i]
        state[S.w_lon + i] = w[i]
    state[S.d_normal] = f_normal - state[S.f_normal]
    state[S.f_normal] = f_normal
    keep_forces(derived, state, x, pulse)

    put_forces(derived, outputs, x, f_normal)
    put_monitors(parameters, derived, outputs, v, (x[0], x[1] - pulse, x[2]), load, deflection)
    outputs[OUT.force_evaluations] = evaluations


@kernel
def turn_mobility(parameters, derived):  # type: ignore[no-untyped-def]
    """Put the mobility, rows and columns lon, lat, spin, normal, into `derived`, contact axes."""
    c = derived[D.cos]
    s = derived[D.sin]
    lon_lon = parameters[P.mobility_lon_lon]
    lon_lat = parameters[P.mobility_lon_lat]
    lon_ver = parameters[P.mobility_lon_ver]
    lon_spin = parameters[P.mobility_lon_spin]
    lat_lat = parameters[P.mobility_lat_lat]
    lat_ver = parameters[P.mobility_lat_ver]
    lat_spin = parameters[P.mobility_lat_spin]
    ver_ver = parameters[P.mobility_ver_ver]
    ver_spin = parameters[P.mobility_ver_spin]
    spin_spin = parameters[P.mobility_spin_spin]
    y = D.mobility
    derived[y] = lon_lon
    derived[y + 1] = c * lon_lat - s * lon_ver
    derived[y + 2] = lon_spin
    derived[y + 3] = s * lon_lat + c * lon_ver
    derived[y + 4] = derived[y + 1]
    derived[y + 5] = c * c * lat_lat - 2.0 * c * s * lat_ver + s * s * ver_ver
    derived[y + 6] = c * lat_spin - s * ver_spin
    derived[y + 7] = c * s * (lat_lat - ver_ver) + (c * c - s * s) * lat_ver
    derived[y + 8] = derived[y + 2]
    derived[y + 9] = derived[y + 6]
    derived[y + 10] = spin_spin
    derived[y + 11] = s * lat_spin + c * ver_spin
    derived[y + 12] = derived[y + 3]
    derived[y + 13] = derived[y + 7]
    derived[y + 14] = derived[y + 11]
    derived[y + 15] = s * s * lat_lat + 2.0 * c * s * lat_ver + c * c * ver_ver


@kernel
def initialise(parameters, derived, state, inputs, outputs):  # type: ignore[no-untyped-def]
    """Find the steady state and evaluate the contact at the initial inputs."""
    a = parameters[P.semi_axis_lon]
    b = parameters[P.semi_axis_lat]
    c11, c22, c23, c33 = creepage_coefficients(a, b, parameters[P.poisson_ratio])
    derived[D.L1], derived[D.L2], derived[D.L3] = flexibilities(a, b, parameters[P.shear_modulus], c11, c22, c23)
    derived[D.L4] = spin_flexibility(b, parameters[P.shear_modulus], c33)
    cells, strips = int(parameters[P.grid_cells]), int(parameters[P.grid_strips])
    derived[D.volume] = bound_volume(a, b, cells, strips)
    derived[D.elliptic_volume], derived[D.parabolic_volume] = volumes(a, b, cells, strips)
    derived[D.series_lon], derived[D.series_lat] = series_compliances(
        a, b, parameters[P.shear_modulus], parameters[P.poisson_ratio], derived[D.L1], derived[D.L2]
    )
    derived[D.spin_arm] = math.sqrt(a * b)
    derived[D.cos] = math.cos(parameters[P.contact_angle])
    derived[D.sin] = math.sin(parameters[P.contact_angle])
    prepare_friction(parameters, derived)
    put_operating_point(parameters, derived, inputs)
    for i in range(16):
        derived[D.mobility + i] = 0.0
    for i in range(STATE_SIZE):
        state[i] = 0.0
    for i in range(3):
        state[S.newton + 4 * i] = 1.0
    v, v_normal, _, _ = relative_motion(parameters, derived, inputs)
    for i in range(3):
        state[S.v_lon + i] = v[i]  # as if it had been so before
    state[S.v_normal] = v_normal
    # without mobility the first evaluation is explicit: nothing is held before the start
    _apply(parameters, derived, state, inputs, outputs, 0.0)
    for i in range(S.d_lon, S.d_normal + 1):
        state[i] = 0.0
    turn_mobility(parameters, derived)
    rest = (0.0, 0.0, 0.0)
    steady = (derived[D.f_lon], derived[D.f_lat], derived[D.f_spin])
    renew_newton_matrix(parameters, derived, state, rest, steady, derived[D.load])


@kernel
def do_step(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Advance to the end of the step, where the inputs are given, and put out the forces for the next one."""
    state[S.elapsed] += h
    keep_tractions(parameters, derived, state)  # as it was in the last step, at the steady state of then
    follow_operating_point(parameters, derived, inputs)
    state[S.step] = h
    _apply(parameters, derived, state, inputs, outputs, h)
