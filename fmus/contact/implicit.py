"""Creep forces that agree with the velocities they cause: a Newton iteration in three unknowns. Kernels."""

from ..compile import kernel
from .law import law
from .layout import D, S
from .memory import change_to, creep_forces_now
from .parameters import WITH_MEMORY, P

MAX_EVALUATIONS = 60
TOLERANCE = 1e-4
"""Largest residual of the creep forces, relative to mu0 N, that is left to a last Newton step without a check."""

TOLERANCE_WITH_MEMORY = 1e-6
"""The same with memory, where what is left would be a force that no traction carries."""


@kernel
def renew_newton_matrix(parameters, derived, state, v, g, load):  # type: ignore[no-untyped-def]
    """Put (I - g' Y)^-1 into the state, g' by forward differences at the velocities `v` where the forces are `g`."""
    delta = 1e-7 * parameters[P.rolling_velocity]
    turn = delta / derived[D.spin_arm]
    a = law(parameters, derived, v[0] + delta, v[1], v[2], load)
    b = law(parameters, derived, v[0], v[1] + delta, v[2], load)
    c = law(parameters, derived, v[0], v[1], v[2] + turn, load)
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
def renew_with_memory(parameters, derived, state, v, g, load, change):  # type: ignore[no-untyped-def]
    """Put the inverse of minus the slope of the residual into the state, by forward differences in the forces."""
    delta = 1e-6 * (derived[D.mu0] * derived[D.load] + 1.0)
    y = D.mobility
    s = S.newton
    for j in range(3):
        step = delta * derived[D.spin_arm] if j == 2 else delta
        w = (
            v[0] + derived[y + j] * step,
            v[1] + derived[y + 4 + j] * step,
            v[2] + derived[y + 8 + j] * step,
        )
        more = (change[0] + (step if j == 0 else 0.0), change[1] + (step if j == 1 else 0.0))
        f = creep_forces_now(parameters, derived, state, w, load, more, False)
        for i in range(3):
            state[s + 3 * i + j] = (1.0 if i == j else 0.0) - (f[i] - g[i]) / step
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
def _with_forces(derived, state, v, x, f_normal):  # type: ignore[no-untyped-def]
    """Return the velocities `v` plus what the changes of the creep forces to `x` and of the normal force cause."""
    y = D.mobility
    d0, d1, d2 = x[0] - state[S.f_lon], x[1] - state[S.f_lat], x[2] - state[S.f_spin]
    d3 = f_normal - state[S.f_normal]
    return (
        v[0] + derived[y] * d0 + derived[y + 1] * d1 + derived[y + 2] * d2 + derived[y + 3] * d3,
        v[1] + derived[y + 4] * d0 + derived[y + 5] * d1 + derived[y + 6] * d2 + derived[y + 7] * d3,
        v[2] + derived[y + 8] * d0 + derived[y + 9] * d1 + derived[y + 10] * d2 + derived[y + 11] * d3,
    )


@kernel
def _residual(parameters, derived, state, v, x, f_normal, pulse):  # type: ignore[no-untyped-def]
    """Return g - x, scaled size of it, the velocities that the forces `x` cause, and the law's forces there."""
    w = _with_forces(derived, state, v, x, f_normal)
    load = f_normal + derived[D.load]
    g = creep_forces_now(parameters, derived, state, w, load, change_to(derived, state, x, pulse), False)
    r = (g[0] - derived[D.f_lon] - x[0], g[1] - derived[D.f_lat] + pulse - x[1], g[2] - derived[D.f_spin] - x[2])
    scale = derived[D.mu0] * derived[D.load] + 1e-30
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
def solve_creep_forces(parameters, derived, state, v, f_normal, pulse):  # type: ignore[no-untyped-def]
    """Return the creep-force fluctuations, the velocities that they cause and agree with, and the evaluations taken.

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
    load = f_normal + derived[D.load]
    memory = parameters[P.creep_law] == WITH_MEMORY
    tolerance = TOLERANCE_WITH_MEMORY if memory else TOLERANCE
    x = (state[S.f_lon] + state[S.d_lon], state[S.f_lat] + state[S.d_lat], state[S.f_spin] + state[S.d_spin])
    r, size, w, g = _residual(parameters, derived, state, v, x, f_normal, pulse)
    evaluations = 1
    fresh = False
    part = 1.0
    while size > tolerance and evaluations < MAX_EVALUATIONS:
        x_new = _newton_step(state, r, x, part)
        r_new, size_new, w_new, g_new = _residual(parameters, derived, state, v, x_new, f_normal, pulse)
        evaluations += 1
        if size_new <= 0.33 * size or (fresh and size_new < (1.0 - 0.1 * part) * size):
            x, r, size, w, g = x_new, r_new, size_new, w_new, g_new
            fresh = False
            part = 1.0
        elif not fresh:
            if memory:
                renew_with_memory(parameters, derived, state, w, g, load, change_to(derived, state, x, pulse))
            else:
                renew_newton_matrix(parameters, derived, state, w, g, load)
            evaluations += 3
            fresh = True
        else:
            part *= 0.5
    x = _newton_step(state, r, x, part)
    return x, _with_forces(derived, state, v, x, f_normal), evaluations
