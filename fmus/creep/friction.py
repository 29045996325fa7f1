"""The friction law: how the friction coefficient depends on the creepage. Kernels."""

import math

from ..compile import kernel


@kernel
def falling_factor(creepage: float, falling_ratio: float, saturation: float) -> float:
    """Return the friction coefficient relative to its static value, tau(gamma).

    Parameters
    ----------
    creepage : float
        Magnitude of the creepage gamma [-], >= 0.
    falling_ratio : float
        lambda [-], 0 to 1; 0 makes the friction constant.
    saturation : float
        Saturation coefficient kappa [-], > 0.

    Notes
    -----
    Eq. (11) of the paper with the exponent's sign corrected: as printed, exp(+kappa/|gamma|) diverges for gamma -> 0,
    where tau must tend to 1.

    >>> round(falling_factor(0.02, 0.1, 0.005), 6)
    0.92212
    """
    if creepage < 1e-12:
        return 1.0
    return 1.0 - falling_ratio * math.exp(-saturation / creepage)


@kernel
def falling_slope(creepage: float, falling_ratio: float, saturation: float) -> float:
    """Return d tau/d gamma, the slope of `falling_factor`.

    >>> round(falling_slope(0.02, 0.1, 0.005), 6)
    -0.973501
    """
    if creepage < 1e-12:
        return 0.0
    return -falling_ratio * saturation / (creepage * creepage) * math.exp(-saturation / creepage)
