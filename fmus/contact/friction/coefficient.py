"""The friction of the contact: its parameters in, friction coefficient and slope out. Kernels.

The only place that knows which law the parameters mean. Each law is the friction without sliding times a factor.
"""

from ...compile import kernel
from ...creep.friction import falling_factor, falling_slope
from ..friction_parameters import FALLING, POLACH, TABLE_OF_CREEPAGE, TABLE_OF_VELOCITY, TWO_DECAYS
from ..layout import FRICTION, D
from ..parameters import P
from .polach import polach, polach_slope
from .table import prepare_table, table
from .two_decays import two_decays, two_decays_slope


@kernel
def prepare_friction(parameters, derived):  # type: ignore[no-untyped-def]
    """Prepare the friction law; once, before any other."""
    if parameters[P.friction_law] >= TABLE_OF_CREEPAGE:
        prepare_table(parameters, derived)


@kernel
def own_friction(parameters, derived):  # type: ignore[no-untyped-def]
    """Return the friction coefficient without sliding that the parameters say [-]; `D.mu0` is the one in force."""
    if parameters[P.friction_law] >= TABLE_OF_CREEPAGE:
        return derived[FRICTION]
    return parameters[P.mu0]


@kernel
def friction_factor(parameters, derived, creepage):  # type: ignore[no-untyped-def]
    """Return the friction coefficient over the one without sliding at a magnitude of the creepage [-]."""
    law = parameters[P.friction_law]
    if law == FALLING:
        return falling_factor(creepage, parameters[P.falling_ratio], parameters[P.saturation_coefficient])
    velocity = creepage * parameters[P.rolling_velocity]
    if law == TWO_DECAYS:
        return two_decays(parameters, velocity)
    if law == POLACH:
        return polach(parameters, velocity)
    value, _ = table(parameters, derived, velocity if law == TABLE_OF_VELOCITY else creepage)
    return value / derived[FRICTION]


@kernel
def friction_coefficient(parameters, derived, creepage):  # type: ignore[no-untyped-def]
    """Return the friction coefficient [-] at a magnitude of the creepage [-]."""
    return derived[D.mu0] * friction_factor(parameters, derived, creepage)


@kernel
def friction_slope(parameters, derived, creepage):  # type: ignore[no-untyped-def]
    """Return the derivative of `friction_coefficient` by the creepage [-]."""
    law = parameters[P.friction_law]
    if law == FALLING:
        slope = falling_slope(creepage, parameters[P.falling_ratio], parameters[P.saturation_coefficient])
        return derived[D.mu0] * slope
    inner = parameters[P.rolling_velocity]
    if law == TWO_DECAYS:
        return derived[D.mu0] * inner * two_decays_slope(parameters, creepage * inner)
    if law == POLACH:
        return derived[D.mu0] * inner * polach_slope(parameters, creepage * inner)
    scale = derived[D.mu0] / derived[FRICTION]
    if law == TABLE_OF_VELOCITY:
        _, slope = table(parameters, derived, creepage * inner)
        return scale * inner * slope
    _, slope = table(parameters, derived, creepage)
    return scale * slope
