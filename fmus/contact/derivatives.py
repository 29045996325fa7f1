"""The running contact differentiated: a change of the inputs in, the change of the outputs it makes out. Kernels.

With f_n the normal force and v the velocities without the new forces, the law F = g(v + Y_t F + Y_n f_n, f_n) gives

    dF = (I - g' Y_t)^-1 (g' (dv + Y_n df_n) + g_N dN + dg - dF_0),

g' and g_N by central differences of the law at the velocities it was solved at. dg and dF_0, the steady creep forces,
are what a moved steady state makes of the law; N = f_n + its load. With memory g depends on F as well.
"""

import math

from ..compile import kernel
from .friction.coefficient import friction_factor, friction_slope
from .law import normal_force, normal_stiffness
from .layout import IN, OUT, D, S
from .memory import creep_forces_now, last_change
from .operating_point import put_steady_state
from .parameters import WITH_MEMORY, P
from .ports import put_forces, relative_motion
from .prediction import look_ahead_change

STEP = 1e-6
"""Step of the central differences, relative to the rolling velocity and to the load."""


@kernel
def differentiate(parameters, derived, state, inputs, outputs, h, seed, sensitivity):  # type: ignore[no-untyped-def]
    """Differentiate the outputs at the end of the last step, of size h (0: none yet), along the inputs `seed`."""
    d_v, d_v_normal, d_v_integrated, d_u = relative_motion(parameters, derived, seed)
    d_ahead, d_deflection = look_ahead_change(parameters, state, d_v, d_v_normal, d_v_integrated, d_u, h)
    d_g, d_steady, d_total = _moved(parameters, derived, state, outputs[OUT.deflection], seed)
    d_load = normal_stiffness(parameters, derived, outputs[OUT.deflection]) * d_deflection + d_total
    d_normal = d_load - seed[IN.normal_load_change]
    implicit = 1.0 if h > 0.0 else 0.0  # at the start the forces are explicit
    d_x = _creep_force_change(parameters, derived, state, d_ahead, d_normal, d_load, d_g, d_steady, implicit)
    put_forces(derived, sensitivity, d_x, d_normal)
    d_force = (d_x[0] + d_steady[0], d_x[1] + d_steady[1], d_x[2] + d_steady[2])
    _put_monitor_changes(parameters, derived, outputs, sensitivity, seed, d_v, d_force, d_load)
    sensitivity[OUT.deflection] = d_deflection
    sensitivity[OUT.force_evaluations] = 0.0


@kernel
def _moved(parameters, derived, state, deflection, seed):  # type: ignore[no-untyped-def]
    """Return dg, dF_0 and the change of the normal force at this deflection of a moved steady state."""
    lon, lat = seed[IN.steady_creepage_lon_change], seed[IN.steady_creepage_lat_change]
    spin, load, mu0 = seed[IN.steady_creepage_spin_change], seed[IN.normal_load_change], seed[IN.mu0_change]
    load_0 = derived[D.load]
    size = max(abs(lon), abs(lat), abs(spin) * derived[D.spin_arm], abs(load) / load_0, abs(mu0))
    if size == 0.0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0
    e = STEP / size
    at = (derived[D.steady_lon], derived[D.steady_lat], derived[D.steady_spin])
    mu = derived[D.mu0]
    d_at = (e * lon, e * lat, e * spin)
    put_steady_state(parameters, derived, _minus(at, d_at, -1.0), load_0 + e * load, mu + e * mu0)
    g_a, f_a, n_a = _state_of_law(parameters, derived, state, deflection, load_0)
    put_steady_state(parameters, derived, _minus(at, d_at, 1.0), load_0 - e * load, mu - e * mu0)
    g_b, f_b, n_b = _state_of_law(parameters, derived, state, deflection, load_0)
    put_steady_state(parameters, derived, at, load_0, mu)
    return _slope(g_a, g_b, e), _slope(f_a, f_b, e), 0.5 / e * (n_a - n_b)


@kernel
def _state_of_law(parameters, derived, state, deflection, load):  # type: ignore[no-untyped-def]
    """Return the law's forces where it was solved, the steady ones, and the normal force, of a steady state.

    `load` is the one that the fluctuation of the normal force belongs to.
    """
    w = (state[S.w_lon], state[S.w_lat], state[S.w_spin])
    g = _law(parameters, derived, state, w, state[S.f_normal] + load, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    steady = (derived[D.f_lon], derived[D.f_lat], derived[D.f_spin])
    return g, steady, normal_force(parameters, derived, deflection)


@kernel
def _creep_force_change(parameters, derived, state, d_v, d_normal, d_load, d_g, d_steady, implicit):  # type: ignore[no-untyped-def]
    """Return dF for changes of velocities, normal force (fluctuation and all of it) and steady state.

    `implicit` is 1, or 0 to leave the mobility out.
    """
    w = (state[S.w_lon], state[S.w_lat], state[S.w_spin])
    load = state[S.f_normal] + derived[D.load]
    delta = STEP * parameters[P.rolling_velocity]
    turn = delta / derived[D.spin_arm]
    a = _slope(
        _law(parameters, derived, state, w, load, delta, 0.0, 0.0, 0.0, 0.0, 0.0),
        _law(parameters, derived, state, w, load, -delta, 0.0, 0.0, 0.0, 0.0, 0.0),
        delta,
    )
    b = _slope(
        _law(parameters, derived, state, w, load, 0.0, delta, 0.0, 0.0, 0.0, 0.0),
        _law(parameters, derived, state, w, load, 0.0, -delta, 0.0, 0.0, 0.0, 0.0),
        delta,
    )
    c = _slope(
        _law(parameters, derived, state, w, load, 0.0, 0.0, turn, 0.0, 0.0, 0.0),
        _law(parameters, derived, state, w, load, 0.0, 0.0, -turn, 0.0, 0.0, 0.0),
        turn,
    )
    more = STEP * max(load, STEP * derived[D.load])
    g_n = _slope(
        _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, more, 0.0, 0.0),
        _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, -more, 0.0, 0.0),
        more,
    )
    y = D.mobility
    k0 = d_v[0] + implicit * derived[y + 3] * d_normal
    k1 = d_v[1] + implicit * derived[y + 7] * d_normal
    k2 = d_v[2] + implicit * derived[y + 11] * d_normal
    known = _minus(_minus(_sum(a, b, c, k0, k1, k2), g_n, -d_load), _minus(d_steady, d_g, 1.0), 1.0)
    x = _minus((1.0, 0.0, 0.0), _sum(a, b, c, derived[y], derived[y + 4], derived[y + 8]), implicit)
    z = _minus((0.0, 1.0, 0.0), _sum(a, b, c, derived[y + 1], derived[y + 5], derived[y + 9]), implicit)
    if parameters[P.creep_law] == WITH_MEMORY and implicit != 0.0:  # forces move what the strips share
        force = STEP * (derived[D.mu0] * derived[D.load] + 1.0)
        own = _slope(
            _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, 0.0, force, 0.0),
            _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, 0.0, -force, 0.0),
            force,
        )
        x = _minus(x, own, 1.0)
        known = _minus(known, own, -d_steady[0])
        own = _slope(
            _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, 0.0, 0.0, force),
            _law(parameters, derived, state, w, load, 0.0, 0.0, 0.0, 0.0, 0.0, -force),
            force,
        )
        z = _minus(z, own, 1.0)
        known = _minus(known, own, -d_steady[1])
    return _solve(
        x,
        z,
        _minus((0.0, 0.0, 1.0), _sum(a, b, c, derived[y + 2], derived[y + 6], derived[y + 10]), implicit),
        known,
    )


@kernel
def _law(parameters, derived, state, w, load, lon, lat, spin, more, change_lon, change_lat):  # type: ignore[no-untyped-def]
    """Return the creep forces next to where they were solved: other velocities, load and changes of the forces."""
    change = last_change(state)
    return creep_forces_now(
        parameters,
        derived,
        state,
        (w[0] + lon, w[1] + lat, w[2] + spin),
        load + more,
        (change[0] + change_lon, change[1] + change_lat),
        False,
    )


@kernel
def _slope(above, below, delta):  # type: ignore[no-untyped-def]
    """Return the central difference of two values that are 2 delta apart."""
    part = 0.5 / delta
    return part * (above[0] - below[0]), part * (above[1] - below[1]), part * (above[2] - below[2])


@kernel
def _sum(a, b, c, p, q, r):  # type: ignore[no-untyped-def]
    """Return a p + b q + c r of three vectors."""
    return a[0] * p + b[0] * q + c[0] * r, a[1] * p + b[1] * q + c[1] * r, a[2] * p + b[2] * q + c[2] * r


@kernel
def _minus(a, b, part):  # type: ignore[no-untyped-def]
    """Return a - part b."""
    return a[0] - part * b[0], a[1] - part * b[1], a[2] - part * b[2]


@kernel
def _cross(a, b):  # type: ignore[no-untyped-def]
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@kernel
def _dot(a, b):  # type: ignore[no-untyped-def]
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def _solve(a, b, c, r):  # type: ignore[no-untyped-def]
    """Solve a x0 + b x1 + c x2 = r by Cramer's rule."""
    b_c = _cross(b, c)
    a_r = _cross(a, r)
    determinant = _dot(a, b_c)
    return _dot(r, b_c) / determinant, _dot(c, a_r) / determinant, -_dot(b, a_r) / determinant


@kernel
def _put_monitor_changes(parameters, derived, outputs, sensitivity, seed, d_v, d_x, d_load):  # type: ignore[no-untyped-def]
    """Differentiate totals and monitors."""
    velocity = parameters[P.rolling_velocity]
    lon, lat, spin = outputs[OUT.creepage_lon], outputs[OUT.creepage_lat], outputs[OUT.creepage_spin]
    f_lon, f_lat, moment = (
        outputs[OUT.tangential_force_lon],
        outputs[OUT.tangential_force_lat],
        outputs[OUT.spin_moment],
    )
    d_lon = d_v[0] / velocity + seed[IN.steady_creepage_lon_change]
    d_lat = d_v[1] / velocity + seed[IN.steady_creepage_lat_change]
    d_spin = d_v[2] / velocity + seed[IN.steady_creepage_spin_change]
    sensitivity[OUT.normal_force] = d_load
    sensitivity[OUT.tangential_force_lon] = d_x[0]
    sensitivity[OUT.tangential_force_lat] = d_x[1]
    sensitivity[OUT.spin_moment] = d_x[2]
    sensitivity[OUT.creepage_lon] = d_lon
    sensitivity[OUT.creepage_lat] = d_lat
    sensitivity[OUT.creepage_spin] = d_spin
    creepage = math.sqrt(lon * lon + lat * lat)
    factor = friction_factor(parameters, derived, creepage)
    sensitivity[OUT.friction_coefficient] = factor * seed[IN.mu0_change]
    if creepage > 0.0:
        slope = friction_slope(parameters, derived, creepage)
        sensitivity[OUT.friction_coefficient] += slope * (lon * d_lon + lat * d_lat) / creepage
    sensitivity[OUT.power_dissipated] = -velocity * (
        d_x[0] * lon + d_x[1] * lat + d_x[2] * spin + f_lon * d_lon + f_lat * d_lat + moment * d_spin
    )
