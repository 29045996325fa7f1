"""Where the contact will be in the middle of the step that its new forces are held over. Kernels.

The forces of a step are known, and so is the velocity that they cause at its end, by the interface mobility Y. The rest
of the change of a velocity over a step, r, is smooth and is extrapolated.

With `host_delay_steps` = 0 the inputs are those at the end of the step, t(k+1), and the forces are held over the next.
The rest goes on as it did: half a step ahead v is v + (dv - Y dF)/2, dv and dF the last changes.

With 1, the inputs are a step old, those at t(k). Then v(k+1) = v(k) + Y F(k) - (1 - m) Y F(k-1) + r(k), where F(k) has
been held since t(k), and m = `MEMORY` is the part of Y that a force leaves behind one step later. r is extrapolated as
a parabola while the friction force follows the velocity weakly. In stick no more than a part of the last r, `DECAY`,
may be carried on, or the prediction feeds on itself.
"""

from ..compile import kernel
from .layout import D, S
from .parameters import P

MEMORY = 0.75
"""Velocity one step after a force has gone, relative to Y; 0.4 with the rails here, 0.95 for a wheel alone. One
number between serves both: the spectral radius in stick is 1.000 from 5 to 20 us (docs/adr/0009)."""

DECAY = 0.5
"""Part of the rest that goes on from step to step in stick; all of it would grow by 1.12 to 1.15 a step at 5 and 20 us
(docs/adr/0009)."""

STICK, SLIP = 0.7, 0.85
"""Smallest diagonal element of (I - g' Y)^-1 up to which the rest decays, and from which on it is a parabola,
which grows by 1.75 a step in stick and is the most exact in slip, where the element is near 1 (docs/adr/0009)."""

TURN = 0.2
"""Largest change of the part of the parabola in one step: a jump of it is a jump of the forces, and five steps are
short against the period of a tone."""

HISTORY = 3
"""Steps after which a parabola is known: it goes through three values."""


@kernel
def look_ahead(parameters, derived, state, v, v_normal, v_integrated, u_normal, h):  # type: ignore[no-untyped-def]
    """Return velocities (lon, lat, spin) and deflection ahead, for the forces held now; remember what comes next."""
    if parameters[P.host_delay_steps] != 0.0 and h > 0.0:
        return _look_further(parameters, derived, state, v, v_normal, v_integrated, u_normal, h)
    state[S.deflection] -= h * v_integrated  # the backward rectangle is half a step ahead by itself
    deflection = state[S.deflection] - u_normal - 0.5 * h * (v_normal - v_integrated)
    return (_half(derived, state, v[0], 0), _half(derived, state, v[1], 1), _half(derived, state, v[2], 2)), deflection


@kernel
def look_ahead_change(parameters, state, d_v, d_v_normal, d_v_integrated, d_u_normal, h):  # type: ignore[no-untyped-def]
    """Return the changes of what `look_ahead` returned for changes of its inputs; `h` is 0 at the start."""
    if h <= 0.0:
        return d_v, -d_u_normal
    if parameters[P.host_delay_steps] == 0.0:
        d_deflection = -d_u_normal - 0.5 * h * (d_v_normal + d_v_integrated)
        return (1.5 * d_v[0], 1.5 * d_v[1], 1.5 * d_v[2]), d_deflection
    part = state[S.part]
    d_rest, d_rest2 = _extrapolate(part, 1.0, 0.0, 0.0)
    share = _middle(part, 1.0, 0.0, 0.0, d_rest, d_rest2)
    n_rest, n_rest2 = _extrapolate(state[S.part_normal], d_v_normal, 0.0, 0.0)
    if parameters[P.use_displacements] != 0.0:
        d_u = d_u_normal + 0.5 * h * d_v_integrated
        d_deflection = -_displacement(d_u, d_v_normal, 0.0, 0.0, d_v_normal, n_rest, n_rest2, h)
    else:
        d_deflection = -h * (2.0 * d_v_normal + n_rest)
    return (share * d_v[0], share * d_v[1], share * d_v[2]), d_deflection


@kernel
def _half(derived, state, v, row):  # type: ignore[no-untyped-def]
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
def _look_further(parameters, derived, state, v, v_normal, v_integrated, u_normal, h):  # type: ignore[no-untyped-def]
    """Look ahead from inputs that are one step old: by one and a half steps."""
    n = S.newton
    smallest = min(state[n], state[n + 4], state[n + 8])
    known_parabola = state[S.steps] >= HISTORY
    state[S.steps] += 1.0
    wanted = min(1.0, max(0.0, (smallest - STICK) / (SLIP - STICK))) if known_parabola else 0.0
    part = min(max(wanted, state[S.part] - TURN), state[S.part] + TURN)
    part_normal = 1.0 if known_parabola else 0.0
    state[S.part] = part
    state[S.part_normal] = part_normal
    held, known, b0, rest, rest2 = _step_further(derived, state, v_normal, 3, part_normal)
    state[S.deflection] -= h * v_integrated
    if parameters[P.use_displacements] != 0.0:  # what is integrated is half a step ahead
        u = u_normal - state[S.deflection] - 0.5 * h * v_integrated
        deflection = -_displacement(u, v_normal, held, known, b0, rest, rest2, h)
    else:
        deflection = state[S.deflection] - h * (v_normal + known + rest)
    state[S.v_normal] = v_normal
    ahead = (
        _velocity(derived, state, v[0], 0, part),
        _velocity(derived, state, v[1], 1, part),
        _velocity(derived, state, v[2], 2, part),
    )
    return ahead, deflection


@kernel
def _step_further(derived, state, v, row, part):  # type: ignore[no-untyped-def]
    """Return what a velocity changes by over the running step: by held forces for ever, by known forces, and the rest.

    Of the rest: the last one, that of the running step and that of the step after.
    """
    y = D.mobility + 4 * row
    held = (
        derived[y] * state[S.f_lon]
        + derived[y + 1] * state[S.f_lat]
        + derived[y + 2] * state[S.f_spin]
        + derived[y + 3] * state[S.f_normal]
    )
    b0 = v - state[S.v_lon + row] - state[S.known_lon + row]
    rest, rest2 = _extrapolate(part, b0, state[S.rest_lon + row], state[S.older_rest_lon + row])
    known = held - (1.0 - MEMORY) * state[S.held_lon + row]
    state[S.older_rest_lon + row] = state[S.rest_lon + row]
    state[S.rest_lon + row] = b0
    state[S.held_lon + row] = held
    state[S.known_lon + row] = known
    return held, known, b0, rest, rest2


@kernel
def _extrapolate(part, b0, b1, b2):  # type: ignore[no-untyped-def]
    """Return the rest of the next step and of the one after, from the last three."""
    rest = part * (3.0 * b0 - 3.0 * b1 + b2) + (1.0 - part) * DECAY * b0
    rest2 = part * (6.0 * b0 - 8.0 * b1 + 3.0 * b2) + (1.0 - part) * DECAY * DECAY * b0
    return rest, rest2


@kernel
def _velocity(derived, state, v, row, part):  # type: ignore[no-untyped-def]
    """Return velocity number `row` in the middle of the step after the running one."""
    held, known, _, rest, rest2 = _step_further(derived, state, v, row, part)
    return _middle(part, v, held, known, rest, rest2)


@kernel
def _middle(part, v, held, known, rest, rest2):  # type: ignore[no-untyped-def]
    """Put a velocity together; linear. The last term makes up for holding a force that follows a parabola."""
    return v + known + rest + 0.5 * (rest2 + MEMORY * held) - part * (rest2 - rest) / 6.0


@kernel
def _displacement(u, v, held, known, b0, rest, rest2, h):  # type: ignore[no-untyped-def]
    """Return the displacement in the middle of the step after the running one, likewise; linear."""
    following = v + known + rest
    return u + h * (0.5 * v + following + (rest2 + MEMORY * held - rest + b0) / 12.0)
