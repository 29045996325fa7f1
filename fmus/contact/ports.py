"""Between the contact's ports, in track axes, and its own axes: motion in, forces and monitors out. Kernels."""

import math

from ..compile import kernel
from .friction.coefficient import friction_coefficient
from .layout import IN, OUT, D
from .parameters import P


@kernel
def relative_motion(parameters, derived, values):  # type: ignore[no-untyped-def]
    """Return the relative motion that inputs say, in contact axes.

    Velocities (lon, lat, spin); normal velocity of both sides, and of those whose velocities are integrated; normal
    displacement of the other sides.
    """
    cos = derived[D.cos]
    sin = derived[D.sin]
    v_lon = values[IN.wheel_v_lon] - values[IN.rail_v_lon]
    v_y = values[IN.wheel_v_lat] - values[IN.rail_v_lat]
    v_z = values[IN.wheel_v_ver] - values[IN.rail_v_ver]
    v_spin = values[IN.wheel_v_spin] - values[IN.rail_v_spin]
    v_normal = sin * v_y + cos * v_z
    v_integrated = 0.0
    u_normal = 0.0
    both = parameters[P.use_displacements] == 0.0
    if both or parameters[P.integrate_wheel] != 0.0:
        v_integrated += sin * values[IN.wheel_v_lat] + cos * values[IN.wheel_v_ver]
    else:
        u_normal += sin * values[IN.wheel_u_lat] + cos * values[IN.wheel_u_ver]
    if both or parameters[P.integrate_rail] != 0.0:
        v_integrated -= sin * values[IN.rail_v_lat] + cos * values[IN.rail_v_ver]
    else:
        u_normal -= sin * values[IN.rail_u_lat] + cos * values[IN.rail_u_ver]
    return (v_lon, cos * v_y - sin * v_z, v_spin), v_normal, v_integrated, u_normal


@kernel
def put_forces(derived, target, x, f_normal):  # type: ignore[no-untyped-def]
    """Put creep forces `x` (lon, lat, spin) and the normal force into the force outputs; linear."""
    cos = derived[D.cos]
    sin = derived[D.sin]
    f_lat = cos * x[1] + sin * f_normal
    f_ver = -sin * x[1] + cos * f_normal
    target[OUT.wheel_f_lon] = x[0]
    target[OUT.wheel_f_lat] = f_lat
    target[OUT.wheel_f_ver] = f_ver
    target[OUT.wheel_f_spin] = x[2]
    target[OUT.rail_f_lon] = -x[0]
    target[OUT.rail_f_lat] = -f_lat
    target[OUT.rail_f_ver] = -f_ver
    target[OUT.rail_f_spin] = -x[2]


@kernel
def put_monitors(parameters, derived, outputs, v, x, load, deflection):  # type: ignore[no-untyped-def]
    """Put totals and monitors into the outputs, of velocities `v`, creep-force fluctuations `x` and the total load."""
    velocity = parameters[P.rolling_velocity]
    creep_lon = derived[D.steady_lon] + v[0] / velocity
    creep_lat = derived[D.steady_lat] + v[1] / velocity
    creep_spin = derived[D.steady_spin] + v[2] / velocity
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
    creepage = math.sqrt(creep_lon * creep_lon + creep_lat * creep_lat)
    outputs[OUT.friction_coefficient] = friction_coefficient(parameters, derived, creepage)
    outputs[OUT.deflection] = deflection
    outputs[OUT.power_dissipated] = -velocity * (total_lon * creep_lon + total_lat * creep_lat + moment * creep_spin)
