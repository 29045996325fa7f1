"""Friction that falls or rises with the sliding velocity by two exponentials. Kernels.

The form of Kraft's law, as used for squeal by F. G. de Beer, M. H. A. Janssens, P. P. Kooijman, Journal of Sound and
Vibration 267 (2003) 497-507: mu/mu0 = 1 - 0.5 exp(-0.138/s) - 0.5 exp(-6.9/s), s the sliding velocity in m/s. Each
exponential is eq. (11) of the paper, in the sliding velocity instead of the creepage. The numbers are as usually
quoted; the printed page was not at hand.
"""

from ...compile import kernel
from ...creep.friction import falling_factor, falling_slope
from ..parameters import P


@kernel
def two_decays(parameters, velocity):  # type: ignore[no-untyped-def]
    """Return the friction coefficient over `mu0` at a sliding velocity [m/s]."""
    a = falling_factor(velocity, parameters[P.decay_ratio_a], parameters[P.decay_velocity_a])
    return a + falling_factor(velocity, parameters[P.decay_ratio_b], parameters[P.decay_velocity_b]) - 1.0


@kernel
def two_decays_slope(parameters, velocity):  # type: ignore[no-untyped-def]
    """Return the derivative of `two_decays` by the sliding velocity [s/m]."""
    a = falling_slope(velocity, parameters[P.decay_ratio_a], parameters[P.decay_velocity_a])
    return a + falling_slope(velocity, parameters[P.decay_ratio_b], parameters[P.decay_velocity_b])
