"""One wheelset on its rails: shift, yaw, speed and loads in; creepages and forces of both wheels out. Kernels.

Vehicle axes: x forward, y left, z up; s = +1 for the left, -1 for the right wheel. A wheel's own values are in the axes
of the contact: lateral to the gauge side, which on the left wheel makes a mirror image of the right one.
"""

import math

from ..compile import kernel
from ..creep.closed_form import closed_form
from ..creep.fastsim import bound_volume, fastsim, flexibilities
from ..creep.friction import falling_factor
from .geometry import find_geometry
from .layout import N_COLUMNS, N_GEOMETRY, N_WHEEL, D, G, W, X
from .parameters import N_FIXED, P


@kernel
def put_geometry(parameters, derived, axle, x):  # type: ignore[no-untyped-def]
    """Put the contact geometry of both wheels of an axle (0 leading, 1 trailing) into `derived`.

    Parameters
    ----------
    x : position of the axle's unknowns in `derived`, unscaled, in the order of `X`
    """
    y = derived[x + X.y]
    left = D.geometry + 2 * axle * N_GEOMETRY
    right = left + N_GEOMETRY
    find_geometry(parameters, derived, y, left)
    find_geometry(parameters, derived, -y, right)
    if (parameters.size - N_FIXED) // N_COLUMNS < 2:  # cone and arc: the wheelset's roll turns the contact planes
        roll = (derived[left] - derived[right]) / (2.0 * parameters[P.half_tape_distance])
        derived[left + G.contact_angle] += roll
        derived[right + G.contact_angle] -= roll


@kernel
def put_wheels(parameters, derived, axle, x, curvature, mu):  # type: ignore[no-untyped-def]
    """Put the state of both wheels of an axle into `derived`, their geometry being there.

    Parameters
    ----------
    x : see `put_geometry`
    curvature : of the track, positive to the left [1/m]
    mu : friction coefficient
    """
    for side in range(2):
        wheel = 2 * axle + side
        g = D.geometry + wheel * N_GEOMETRY
        _put_wheel(parameters, derived, g, 1.0 - 2.0 * side, D.wheels + wheel * N_WHEEL, x, curvature, mu)


@kernel
def _put_wheel(parameters, derived, g, s, w, x, curvature, mu):  # type: ignore[no-untyped-def]
    """Put creepages and forces of one wheel into `derived` from position `w`."""
    yaw = derived[x + X.yaw]
    load = derived[x + X.load_left] if s > 0.0 else derived[x + X.load_right]
    r0 = parameters[P.wheel_radius]
    l0 = parameters[P.half_tape_distance]
    radius = r0 + derived[g + G.radius_change]
    angle = derived[g + G.contact_angle]
    cos = math.cos(angle)
    sin = math.sin(angle)
    turning = (1.0 + derived[x + X.omega]) / r0
    lon = 1.0 - s * curvature * l0 - turning * radius
    lat = s * turning * radius * yaw / cos
    spin = sin / r0 - s * curvature * cos
    growth = (max(load, 0.0) / parameters[P.patch_load]) ** (1.0 / 3.0)
    a = derived[g + G.semi_axis_lon] * growth
    b = derived[g + G.semi_axis_lat] * growth
    f_lon, f_lat = _creep_forces(parameters, derived, g, lon, lat, spin, mu * load, a, b)
    lead = s * radius * yaw * sin / cos  # keeps the velocity along the normal zero
    derived[w + W.steady_creepage_lon] = lon
    derived[w + W.steady_creepage_lat] = lat
    derived[w + W.steady_creepage_spin] = spin
    derived[w + W.normal_load] = load
    derived[w + W.contact_angle] = angle
    derived[w + W.wheel_position] = derived[g + G.wheel_position]
    derived[w + W.rail_position] = derived[g + G.rail_position]
    derived[w + W.semi_axis_lon] = a
    derived[w + W.semi_axis_lat] = b
    derived[w + W.hertz_stiffness] = derived[g + G.hertz_stiffness] * growth
    derived[w + W.creep_force_lon] = f_lon
    derived[w + W.creep_force_lat] = f_lat
    derived[w + W.friction_utilisation] = (
        math.sqrt(f_lon * f_lon + f_lat * f_lat) / (mu * load) if mu * load > 0 else 0.0
    )
    derived[w + W.lateral_force] = load * sin + f_lat * cos
    derived[w + W.vertical_force] = load * cos - f_lat * sin
    derived[w + W.radius] = radius
    derived[w + W.lead] = lead
    derived[w + W.arm] = lead - s * l0 * yaw


@kernel
def _creep_forces(parameters, derived, g, lon, lat, spin, bound, a, b):  # type: ignore[no-untyped-def]
    """Return longitudinal and lateral creep force on the wheel [N]."""
    modulus = parameters[P.shear_modulus]
    c11, c22, c23 = derived[g + G.c11], derived[g + G.c22], derived[g + G.c23]
    tau = 1.0
    if parameters[P.falling_ratio] != 0.0:
        tau = falling_factor(
            math.sqrt(lon * lon + lat * lat), parameters[P.falling_ratio], parameters[P.saturation_coefficient]
        )
    if parameters[P.use_fastsim] == 0.0:
        f_lon, f_lat = closed_form(lon, lat, spin, bound, a, b, modulus, c11, c22, c23)
        return tau * f_lon, tau * f_lat
    if a <= 0.0 or bound <= 0.0:
        return 0.0, 0.0
    cells, strips = int(parameters[P.grid_cells]), int(parameters[P.grid_strips])
    L1, L2, L3 = flexibilities(a, b, modulus, c11, c22, c23)
    volume = bound_volume(a, b, cells, strips)
    f_lon, f_lat, _ = fastsim(lon, lat, spin, bound, volume, a, b, L1, L2, L3, cells, strips, derived, D.scratch)
    return tau * f_lon, tau * f_lat
