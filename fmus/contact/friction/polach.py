"""Friction that falls with the sliding velocity s by one exponential: mu/mu0 = (1 - A) exp(-B s) + A. Kernels.

O. Polach, Creep forces in simulations of traction vehicles running on adhesion limit, Wear 258 (2005) 992-1000,
eq. (3): the form was compared with the printed text; the numbers of its table (`named.py`) are as usually quoted.
"""

import math

from ...compile import kernel
from ..parameters import P


@kernel
def polach(parameters, velocity):  # type: ignore[no-untyped-def]
    """Return the friction coefficient over `mu0` at a sliding velocity [m/s]."""
    rest = parameters[P.polach_ratio]
    return (1.0 - rest) * math.exp(-parameters[P.polach_decay] * velocity) + rest


@kernel
def polach_slope(parameters, velocity):  # type: ignore[no-untyped-def]
    """Return the derivative of `polach` by the sliding velocity [s/m]."""
    decay = parameters[P.polach_decay]
    return -decay * (1.0 - parameters[P.polach_ratio]) * math.exp(-decay * velocity)
