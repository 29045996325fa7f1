"""The running contact: velocities and displacements of wheel and rail in, forces out. Kernels.

Contact axes are the contract's, turned about the longitudinal axis by the contact angle: lon, lat in the contact plane,
normal from the rail into the wheel. Forces act on the wheel; the rail has the opposite.

The forces are held over the next step, so they are made for its middle. The normal spring is taken at u + h/2 v, which
cancels the delay of a held force. The creep forces solve

    F = g(v_ahead + Y (F - F_held)),

g the friction law and Y the interface mobility of wheel and rail together: the velocity that the new force itself
causes counts at once (in stick nothing explicit is stable). v_ahead extrapolates the rest of the velocity by half a
step: v + (dv - Y dF)/2, with dv and dF the last changes of velocity and force. That makes the coupling second order.
The Newton matrix (I - g' Y)^-1 is kept from step to step and renewed only when it no longer converges.
"""

import math

from ..compile import kernel, positions
from ..interface import contact_inputs, contact_outputs
from .fastsim import bound_volume, fastsim, flexibilities
from .friction import falling_factor
from .kalker import creepage_coefficients
from .parameters import P

IN = positions("IN", (port.name for port in contact_inputs()))
OUT = positions("OUT", (port.name for port in contact_outputs()))
"""Layout of inputs and outputs."""

S = positions(
    "S",
    (
        *("f_lon", "f_lat", "f_spin", "f_normal"),  # forces that are held now: fluctuations, contact axes
        *("d_lon", "d_lat", "d_spin", "d_normal"),  # how much they changed the last time
        *("v_lon", "v_lat", "v_spin"),  # relative velocities at the end of the step before
        *("elapsed", "deflection", "newton"),  # time, integrated deflection, Newton matrix (3 x 3)
    ),
)
"""Layout of the state."""

D = positions(
    "D", ("f_lon", "f_lat", "f_spin", "approach", "cos", "sin", "L1", "L2", "L3", "spin_arm", "volume", "mobility")
)
"""Layout of the derived quantities: steady creep forces, steady approach, geometry, contact-axes mobility (3 x 4)."""

STATE_SIZE = S.newton + 9
DERIVED_SIZE = D.mobility + 12

MAX_EVALUATIONS = 60
TOLERANCE = 1e-4
"""Largest residual of the creep forces, relative to mu0 N, that is left to a last Newton step without a check."""


@kernel
def normal_force(parameters, derived, deflection):  # type: ignore[no-untyped-def]
    """Return the total normal force [N] at a fluctuation of the deflection [m] (compression positive)."""
    load = parameters[P.normal_load]
    if parameters[P.linear_spring] != 0.0:
        return max(0.0, load + parameters[P.hertz_stiffness] * deflection)
    compression = 1.0 + deflection / derived[D.approach]
    if compression <= 0.0:
        return 0.0
    return load * compression * math.sqrt(compression)


@kernel
def creep_forces(parameters, derived, creep_lon, creep_lat, creep_spin, load):  # type: ignore[no-untyped-def]
    """Return the total creep forces on the wheel [N, N, N.m] at total creepages and total normal force."""
    tau = falling_factor(
        math.sqrt(creep_lon * creep_lon + creep_lat * creep_lat),
        parameters[P.falling_ratio],
        parameters[P.saturation_coefficient],
    )
    lon, lat, moment = fastsim(
        creep_lon,
        creep_lat,
        creep_spin,
        parameters[P.mu0] * load / derived[D.volume],
        parameters[P.semi_axis_lon],
        parameters[P.semi_axis_lat],
        derived[D.L1],
        derived[D.L2],
        derived[D.L3],
        int(parameters[P.grid_cells]),
        int(parameters[P.grid_strips]),
    )
    return tau * lon, tau * lat, tau * moment


@kernel
def _law(parameters, derived, v_lon, v_lat, v_spin, load):  # type: ignore[no-untyped-def]
    """Return the total creep forces at relative velocities that fluctuate about the steady creepages."""
    inverse = 1.0 / parameters[P.rolling_velocity]
    return creep_forces(
        parameters,
        derived,
        parameters[P.steady_creepage_lon] + v_lon * inverse,
        parameters[P.steady_creepage_lat] + v_lat * inverse,
        parameters[P.steady_creepage_spin] + v_spin * inverse,
        load,
    )


@kernel
def _renew_newton_matrix(parameters, derived, state, v, g, load):  # type: ignore[no-untyped-def]
    """Put (I - g' Y)^-1 into the state, g' by forward differences at the velocities `v` where the forces are `g`."""
    delta = 1e-7 * parameters[P.rolling_velocity]
    turn = delta / derived[D.spin_arm]
    a = _law(parameters, derived, v[0] + delta, v[1], v[2], load)
    b = _law(parameters, derived, v[0], v[1] + delta, v[2], load)
    c = _law(parameters, derived, v[0], v[1], v[2] + turn, load)
    y = D.mobility
    s = S.newton
    for i in range(3):
        s_lon = (a[i] - g[i]) / delta
        s_lat = (b[i] - g[i]) / delta
        s_spin = (c[i] - g[i]) / turn
        for j in range(3):
            product = s_lon * derived[y + j] + s_lat * derived[y + 4 + j] + s_spin * derived[y + 8 + j]
            state[s + 3 * i + j] = (1.0 if i == j else 0.0) - product
    _invert(state, s)


@kernel
def _invert(m, s):  # type: ignore[no-untyped-def]
    """Invert in place the 3 x 3 matrix that stands row by row in `m` from position `s`."""
    a, b, c = m[s], m[s + 1], m[s + 2]
    d, e, f = m[s + 3], m[s + 4], m[s + 5]
    g, h, i = m[s + 6], m[s + 7], m[s + 8]
    x, y, z = e * i - f * h, f * g - d * i, d * h - e * g
    w = 1.0 / (a * x + b * y + c * z)
    m[s], m[s + 1], m[s + 2] = x * w, (c * h - b * i) * w, (b * f - c * e) * w
    m[s + 3], m[s + 4], m[s + 5] = y * w, (a * i - c * g) * w, (c * d - a * f) * w
    m[s + 6], m[s + 7], m[s + 8] = z * w, (b * g - a * h) * w, (a * e - b * d) * w


@kernel
def _residual(parameters, derived, state, v, x, f_normal, pulse):  # type: ignore[no-untyped-def]
    """Return g - x, scaled size of it, the velocities that the forces `x` cause, and the law's forces there."""
    y = D.mobility
    d0, d1, d2 = x[0] - state[S.f_lon], x[1] - state[S.f_lat], x[2] - state[S.f_spin]
    d3 = f_normal - state[S.f_normal]
    w = (
        v[0] + derived[y] * d0 + derived[y + 1] * d1 + derived[y + 2] * d2 + derived[y + 3] * d3,
        v[1] + derived[y + 4] * d0 + derived[y + 5] * d1 + derived[y + 6] * d2 + derived[y + 7] * d3,
        v[2] + derived[y + 8] * d0 + derived[y + 9] * d1 + derived[y + 10] * d2 + derived[y + 11] * d3,
    )
    g = _law(parameters, derived, w[0], w[1], w[2], f_normal + parameters[P.normal_load])
    r = (g[0] - derived[D.f_lon] - x[0], g[1] - derived[D.f_lat] + pulse - x[1], g[2] - derived[D.f_spin] - x[2])
    scale = parameters[P.mu0] * parameters[P.normal_load] + 1e-30
    size = max(abs(r[0]), abs(r[1]), abs(r[2]) / derived[D.spin_arm]) / scale
    return r, size, w, g


@kernel
def _newton_step(state, r, x, part):  # type: ignore[no-untyped-def]
    """Return x + part M r with the kept Newton matrix M."""
    s = S.newton
    return (
        x[0] + part * (state[s] * r[0] + state[s + 1] * r[1] + state[s + 2] * r[2]),
        x[1] + part * (state[s + 3] * r[0] + state[s + 4] * r[1] + state[s + 5] * r[2]),
        x[2] + part * (state[s + 6] * r[0] + state[s + 7] * r[1] + state[s + 8] * r[2]),
    )


@kernel
def _solve_creep_forces(parameters, derived, state, v, f_normal, pulse):  # type: ignore[no-untyped-def]
    """Return the creep-force fluctuations that agree with the velocities they cause, and how many evaluations it took.

    Parameters
    ----------
    v : (lon, lat, spin) relative velocities that the held forces would cause
    f_normal : fluctuation of the normal force
    pulse : lateral force from outside that acts together with the creep forces

    Notes
    -----
    The friction law dissipates and the mobility is positive, so the error of `x` is at most its residual, and a Newton
    step with the matrix of the place goes downhill. The kept matrix is used while it brings the residual down by two
    thirds; then it is renewed; then the step is halved until the residual falls.
    """
    load = f_normal + parameters[P.normal_load]
    x = (state[S.f_lon] + state[S.d_lon], state[S.f_lat] + state[S.d_lat], state[S.f_spin] + state[S.d_spin])
    r, size, w, g = _residual(parameters, derived, state, v, x, f_normal, pulse)
    evaluations = 1
    fresh = False
    part = 1.0
    while size > TOLERANCE and evaluations < MAX_EVALUATIONS:
        x_new = _newton_step(state, r, x, part)
        r_new, size_new, w_new, g_new = _residual(parameters, derived, state, v, x_new, f_normal, pulse)
        evaluations += 1
        if size_new <= 0.33 * size or (fresh and size_new < (1.0 - 0.1 * part) * size):
            x, r, size, w, g = x_new, r_new, size_new, w_new, g_new
            fresh = False
            part = 1.0
        elif not fresh:
            _renew_newton_matrix(parameters, derived, state, w, g, load)
            evaluations += 3
            fresh = True
        else:
            part *= 0.5
    x = _newton_step(state, r, x, part)
    return x[0], x[1], x[2], evaluations


@kernel
def _ahead(derived, state, v, row):  # type: ignore[no-untyped-def]
    """Return velocity number `row` (lon, lat, spin) half a step ahead, the held forces going on."""
    y = D.mobility + 4 * row
    caused = (
        derived[y] * state[S.d_lon]
        + derived[y + 1] * state[S.d_lat]
        + derived[y + 2] * state[S.d_spin]
        + derived[y + 3] * state[S.d_normal]
    )
    return v + 0.5 * (v - state[S.v_lon + row] - caused)


@kernel
def _apply(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Evaluate the contact at the inputs, for forces that are held over the next `h` seconds; update the state."""
    cos = derived[D.cos]
    sin = derived[D.sin]
    v_lon = inputs[IN.wheel_v_lon] - inputs[IN.rail_v_lon]
    v_y = inputs[IN.wheel_v_lat] - inputs[IN.rail_v_lat]
    v_z = inputs[IN.wheel_v_ver] - inputs[IN.rail_v_ver]
    v_lat = cos * v_y - sin * v_z
    v_nor = sin * v_y + cos * v_z
    v_spin = inputs[IN.wheel_v_spin] - inputs[IN.rail_v_spin]
    if parameters[P.use_displacements] != 0.0:
        u_y = inputs[IN.wheel_u_lat] - inputs[IN.rail_u_lat]
        u_z = inputs[IN.wheel_u_ver] - inputs[IN.rail_u_ver]
        deflection = -(sin * u_y + cos * u_z) - 0.5 * h * v_nor
    else:  # the backward rectangle is half a step ahead by itself
        deflection = state[S.deflection] - h * v_nor
    state[S.deflection] = deflection

    load = normal_force(parameters, derived, deflection)
    f_normal = load - parameters[P.normal_load]
    pulse = 0.0
    if state[S.elapsed] < parameters[P.pulse_duration]:
        pulse = parameters[P.pulse_force] * math.sin(math.pi * state[S.elapsed] / parameters[P.pulse_duration])
    ahead = (
        _ahead(derived, state, v_lon, 0),
        _ahead(derived, state, v_lat, 1),
        _ahead(derived, state, v_spin, 2),
    )
    x0, x1, x2, evaluations = _solve_creep_forces(parameters, derived, state, ahead, f_normal, pulse)
    state[S.d_lon] = x0 - state[S.f_lon]
    state[S.d_lat] = x1 - state[S.f_lat]
    state[S.d_spin] = x2 - state[S.f_spin]
    state[S.f_lon] = x0
    state[S.f_lat] = x1
    state[S.f_spin] = x2
    state[S.d_normal] = f_normal - state[S.f_normal]
    state[S.f_normal] = f_normal
    state[S.v_lon] = v_lon
    state[S.v_lat] = v_lat
    state[S.v_spin] = v_spin

    f_lat = cos * x1 + sin * f_normal
    f_ver = -sin * x1 + cos * f_normal
    outputs[OUT.wheel_f_lon] = x0
    outputs[OUT.wheel_f_lat] = f_lat
    outputs[OUT.wheel_f_ver] = f_ver
    outputs[OUT.wheel_f_spin] = x2
    outputs[OUT.rail_f_lon] = -x0
    outputs[OUT.rail_f_lat] = -f_lat
    outputs[OUT.rail_f_ver] = -f_ver
    outputs[OUT.rail_f_spin] = -x2
    _monitor(parameters, derived, outputs, (v_lon, v_lat, v_spin), (x0, x1 - pulse, x2), load, deflection)
    outputs[OUT.force_evaluations] = evaluations


@kernel
def _monitor(parameters, derived, outputs, v, x, load, deflection):  # type: ignore[no-untyped-def]
    """Put out totals and monitors."""
    velocity = parameters[P.rolling_velocity]
    creep_lon = parameters[P.steady_creepage_lon] + v[0] / velocity
    creep_lat = parameters[P.steady_creepage_lat] + v[1] / velocity
    creep_spin = parameters[P.steady_creepage_spin] + v[2] / velocity
    total_lon = derived[D.f_lon] + x[0]
    total_lat = derived[D.f_lat] + x[1]
    moment = derived[D.f_spin] + x[2]
    outputs[OUT.normal_force] = load
    outputs[OUT.tangential_force_lon] = total_lon
    outputs[OUT.tangential_force_lat] = total_lat
    outputs[OUT.spin_moment] = moment
    outputs[OUT.creepage_lon] = creep_lon
    outputs[OUT.creepage_lat] = creep_lat
    outputs[OUT.creepage_spin] = creep_spin
    outputs[OUT.friction_coefficient] = parameters[P.mu0] * falling_factor(
        math.sqrt(creep_lon * creep_lon + creep_lat * creep_lat),
        parameters[P.falling_ratio],
        parameters[P.saturation_coefficient],
    )
    outputs[OUT.deflection] = deflection
    outputs[OUT.power_dissipated] = -velocity * (total_lon * creep_lon + total_lat * creep_lat + moment * creep_spin)


@kernel
def _turn_mobility(parameters, derived):  # type: ignore[no-untyped-def]
    """Put the mobility rows lon, lat, spin over the columns lon, lat, spin, normal into `derived`, contact axes."""
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


@kernel
def initialise(parameters, derived, state, inputs, outputs):  # type: ignore[no-untyped-def]
    """Find the steady state and evaluate the contact at the initial inputs."""
    a = parameters[P.semi_axis_lon]
    b = parameters[P.semi_axis_lat]
    c11, c22, c23 = creepage_coefficients(a, b, parameters[P.poisson_ratio])
    derived[D.L1], derived[D.L2], derived[D.L3] = flexibilities(a, b, parameters[P.shear_modulus], c11, c22, c23)
    derived[D.volume] = bound_volume(a, b, int(parameters[P.grid_cells]), int(parameters[P.grid_strips]))
    derived[D.spin_arm] = math.sqrt(a * b)
    derived[D.cos] = math.cos(parameters[P.contact_angle])
    derived[D.sin] = math.sin(parameters[P.contact_angle])
    derived[D.approach] = 1.5 * parameters[P.normal_load] / parameters[P.hertz_stiffness]
    load = parameters[P.normal_load]
    derived[D.f_lon], derived[D.f_lat], derived[D.f_spin] = _law(parameters, derived, 0.0, 0.0, 0.0, load)
    for i in range(12):
        derived[D.mobility + i] = 0.0
    for i in range(STATE_SIZE):
        state[i] = 0.0
    for i in range(3):
        state[S.newton + 4 * i] = 1.0
    # without mobility the first evaluation is explicit: nothing is held before the start
    _apply(parameters, derived, state, inputs, outputs, 0.0)
    for i in range(S.d_lon, S.d_normal + 1):
        state[i] = 0.0
    _turn_mobility(parameters, derived)
    rest = (0.0, 0.0, 0.0)
    steady = (derived[D.f_lon], derived[D.f_lat], derived[D.f_spin])
    _renew_newton_matrix(parameters, derived, state, rest, steady, load)


@kernel
def do_step(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Advance to the end of the step, where the inputs are given, and put out the forces for the next one."""
    state[S.elapsed] += h
    _apply(parameters, derived, state, inputs, outputs, h)
