"""The friction of the contact: its parameters in, friction coefficient and slope out. Kernels.

The only place that knows which parameters a friction law has.
"""

from ..compile import kernel
from ..creep.friction import falling_factor, falling_slope
from .parameters import P


@kernel
def friction_factor(parameters, creepage):  # type: ignore[no-untyped-def]
    """Return the friction coefficient over `mu0` at a magnitude of the creepage [-]."""
    return falling_factor(creepage, parameters[P.falling_ratio], parameters[P.saturation_coefficient])


@kernel
def friction_coefficient(parameters, creepage):  # type: ignore[no-untyped-def]
    """Return the friction coefficient [-] at a magnitude of the creepage [-]."""
    return parameters[P.mu0] * friction_factor(parameters, creepage)


@kernel
def friction_slope(parameters, creepage):  # type: ignore[no-untyped-def]
    """Return the derivative of `friction_coefficient` by the creepage [-]."""
    slope = falling_slope(creepage, parameters[P.falling_ratio], parameters[P.saturation_coefficient])
    return parameters[P.mu0] * slope
