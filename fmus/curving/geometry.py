"""Contact geometry of one wheel: shift towards the flange in; radius, angle, place, patch out. Kernels.

Either a cone with an arc to the flange, on a rail that is always touched at one place, or a table that was made from
real profiles (see `contact_table`), by monotone cubic interpolation.
"""

import math

from ..compile import kernel
from ..creep.kalker import creepage_coefficients
from .layout import N_COLUMNS, N_GEOMETRY, D, G
from .parameters import N_FIXED, P


@kernel
def prepare_table(parameters, derived):  # type: ignore[no-untyped-def]
    """Put values and slopes of the table's columns, and Kalker's coefficients, into `derived`."""
    n = (parameters.size - N_FIXED) // N_COLUMNS
    step = parameters[P.table_spacing]
    for i in range(n):
        for column in range(N_COLUMNS):
            derived[D.table + column * n + i] = parameters[N_FIXED + column * n + i]
        c11, c22, c23, _ = creepage_coefficients(
            parameters[N_FIXED + G.semi_axis_lon * n + i],
            parameters[N_FIXED + G.semi_axis_lat * n + i],
            parameters[P.poisson_ratio],
        )
        derived[D.table + G.c11 * n + i] = c11
        derived[D.table + G.c22 * n + i] = c22
        derived[D.table + G.c23 * n + i] = c23
    for column in range(N_GEOMETRY):
        v = D.table + column * n
        m = D.table + (N_GEOMETRY + column) * n
        for i in range(n):  # Fritsch and Butland's slopes: no overshoot between the nodes
            before = (derived[v + i] - derived[v + i - 1]) / step if i > 0 else 0.0
            after = (derived[v + i + 1] - derived[v + i]) / step if i < n - 1 else 0.0
            derived[m + i] = 2.0 * before * after / (before + after) if before * after > 0.0 else 0.0
        if n > 1:  # at the ends the slope of the last interval, so that going on beyond them goes straight on
            derived[m] = (derived[v + 1] - derived[v]) / step
            derived[m + n - 1] = (derived[v + n - 1] - derived[v + n - 2]) / step


@kernel
def find_geometry(parameters, derived, shift, at):  # type: ignore[no-untyped-def]
    """Put the geometry at a shift towards the flange [m] into `derived` from position `at`, in the order of `G`.

    The contact angle of a table has the wheelset's roll in it, that of cone and arc has not.
    """
    n = (parameters.size - N_FIXED) // N_COLUMNS
    if n > 1:
        _interpolate(parameters, derived, n, shift, at)
        return
    slope = parameters[P.conicity]
    tread_end = parameters[P.flange_clearance]
    rho = parameters[P.flange_arc_radius]
    change = slope * shift
    angle = math.atan(slope)
    if shift > tread_end:
        steepest = math.sin(parameters[P.flange_angle])
        sine = math.sin(angle) + (shift - tread_end) / rho
        straight = max(sine - steepest, 0.0) * rho  # beyond the arc the flange goes on as a cone
        flange = math.asin(min(sine, steepest))
        change = slope * tread_end + rho * (math.cos(angle) - math.cos(flange)) + straight * math.tan(flange)
        angle = flange
    derived[at + G.radius_change] = change
    derived[at + G.contact_angle] = angle
    derived[at + G.wheel_position] = -shift
    derived[at + G.rail_position] = 0.0
    derived[at + G.semi_axis_lon] = parameters[P.semi_axis_lon]
    derived[at + G.semi_axis_lat] = parameters[P.semi_axis_lat]
    derived[at + G.hertz_stiffness] = parameters[P.hertz_stiffness]
    derived[at + G.c11] = parameters[P.c11]
    derived[at + G.c22] = parameters[P.c22]
    derived[at + G.c23] = parameters[P.c23]


@kernel
def _interpolate(parameters, derived, n, shift, at):  # type: ignore[no-untyped-def]
    """Interpolate all columns by cubics through values and slopes, straight on beyond the ends."""
    step = parameters[P.table_spacing]
    place = (shift - parameters[P.table_start]) / step
    i = min(max(int(math.floor(place)), 0), n - 2)  # noqa: RUF046 - in C floor gives a real number
    t = place - i
    beyond = 0.0
    if t < 0.0:
        beyond, t = t * step, 0.0
    elif t > 1.0:
        beyond, t = (t - 1.0) * step, 1.0
    u = 1.0 - t
    for column in range(N_GEOMETRY):
        v = D.table + column * n + i
        m = D.table + (N_GEOMETRY + column) * n + i
        value = u * u * (1.0 + 2.0 * t) * derived[v] + t * t * (1.0 + 2.0 * u) * derived[v + 1]
        value += step * t * u * (u * derived[m] - t * derived[m + 1])
        if beyond != 0.0 and column <= G.rail_position:
            value += beyond * (derived[m] if beyond < 0.0 else derived[m + 1])
        derived[at + column] = value
