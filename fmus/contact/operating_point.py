"""The steady state of the contact: parameters and the inputs added to them in, what the law needs out. Kernels.

It may move while the contact runs; wheel and rail go on to feel only what fluctuates about it, so the forces on them do
not jump.
"""

import math

from ..compile import kernel
from .friction.coefficient import own_friction
from .law import law
from .layout import IN, D
from .parameters import HIGHEST, LOWEST, P


@kernel
def put_operating_point(parameters, derived, inputs):  # type: ignore[no-untyped-def]
    """Put the steady state and its creep forces into `derived`; the friction law is prepared."""
    derived[D.velocity] = parameters[P.rolling_velocity]
    derived[D.falling_ratio] = parameters[P.falling_ratio]
    derived[D.saturation] = parameters[P.saturation_coefficient]
    creepages = (
        parameters[P.steady_creepage_lon] + inputs[IN.steady_creepage_lon_change],
        parameters[P.steady_creepage_lat] + inputs[IN.steady_creepage_lat_change],
        parameters[P.steady_creepage_spin] + inputs[IN.steady_creepage_spin_change],
    )
    load = parameters[P.normal_load] + inputs[IN.normal_load_change]
    put_steady_state(parameters, derived, creepages, load, own_friction(parameters, derived) + inputs[IN.mu0_change])


@kernel
def follow_operating_point(parameters, derived, inputs):  # type: ignore[no-untyped-def]
    """Do the same if an input or a parameter has changed."""
    if not (
        derived[D.steady_lat] == parameters[P.steady_creepage_lat] + inputs[IN.steady_creepage_lat_change]
        and derived[D.mu0] == own_friction(parameters, derived) + inputs[IN.mu0_change]
        and derived[D.load] == parameters[P.normal_load] + inputs[IN.normal_load_change]
        and derived[D.steady_lon] == parameters[P.steady_creepage_lon] + inputs[IN.steady_creepage_lon_change]
        and derived[D.steady_spin] == parameters[P.steady_creepage_spin] + inputs[IN.steady_creepage_spin_change]
        and derived[D.velocity] == parameters[P.rolling_velocity]
        and derived[D.falling_ratio] == parameters[P.falling_ratio]
        and derived[D.saturation] == parameters[P.saturation_coefficient]
    ):
        put_operating_point(parameters, derived, inputs)


@kernel
def _outside(value, k):  # type: ignore[no-untyped-def]
    """Return whether number `k` of the steady state may not be `value`."""
    return value < LOWEST[k] or value > HIGHEST[k]


@kernel
def put_steady_state(parameters, derived, creepages, load, mu0):  # type: ignore[no-untyped-def]
    """Put a steady state and its creep forces into `derived`; the forces are no numbers where it may not be so.

    `creepages` are (lon, lat, spin). The elastic constant of the Hertzian contact stays, so the steady approach follows
    the load to the power 2/3. The contact patch keeps its size.
    """
    lon, lat, spin = creepages
    derived[D.steady_lon], derived[D.steady_lat], derived[D.steady_spin] = lon, lat, spin
    derived[D.load], derived[D.mu0] = load, mu0
    nominal = parameters[P.normal_load]
    derived[D.stiffness] = parameters[P.hertz_stiffness]
    derived[D.approach] = 1.5 * nominal / derived[D.stiffness]
    too_rough = mu0 > max(HIGHEST[4], own_friction(parameters, derived))  # a table may begin higher
    if _outside(lon, 0) or _outside(lat, 1) or _outside(spin, 2) or _outside(load, 3) or mu0 < LOWEST[4] or too_rough:
        derived[D.f_lon] = derived[D.f_lat] = derived[D.f_spin] = math.nan
        return
    if load != nominal:
        derived[D.approach] *= (load / nominal) ** (2.0 / 3.0)
        derived[D.stiffness] = 1.5 * load / derived[D.approach]
    derived[D.f_lon], derived[D.f_lat], derived[D.f_spin] = law(parameters, derived, 0.0, 0.0, 0.0, load)
