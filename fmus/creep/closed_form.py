"""Creep forces in closed form: linear theory cut to Coulomb's bound by a cubic. Kernel.

Z. Y. Shen, J. K. Hedrick, J. A. Elkins, A comparison of alternative creep force models for rail vehicle dynamic
analysis, Vehicle System Dynamics 12 (1983) 79-83: Kalker's linear forces, reduced as Vermeulen and Johnson do.
"""

import math

from ..compile import kernel


@kernel
def closed_form(gamma_lon, gamma_lat, gamma_spin, bound, a, b, shear_modulus, c11, c22, c23):  # type: ignore[no-untyped-def]
    """Return the longitudinal and the lateral creep force on the upper body [N].

    Parameters
    ----------
    gamma_lon, gamma_lat, gamma_spin : float
        Creepages [-, -, 1/m].
    bound : float
        Friction coefficient times normal force [N]; <= 0 gives no force.
    a, b : float
        Semi-axes in the rolling and in the lateral direction [m].
    shear_modulus : float
        G [Pa].
    c11, c22, c23 : float
        Kalker's coefficients [-].

    Notes
    -----
    F1' = -G a b C11 gamma1, F2' = -G a b C22 gamma2 - G (a b)^1.5 C23 gamma6; with x = |F'| / bound the force is
    F' (1 - x/3 + x^2/27) below x = 3 and F' / x beyond. The spin moment is left out.

    >>> round(math.hypot(*closed_form(0.02, 0.0, 0.0, 18e3, 0.005, 0.005, 80e9, 4.1, 3.7, 1.5)), 6)
    18000.0
    """
    if bound <= 0.0:
        return 0.0, 0.0
    area = shear_modulus * a * b
    lon = -area * c11 * gamma_lon
    lat = -area * (c22 * gamma_lat + math.sqrt(a * b) * c23 * gamma_spin)
    x = math.sqrt(lon * lon + lat * lat) / bound
    part = 1.0 - x / 3.0 + x * x / 27.0 if x < 3.0 else 1.0 / x
    return part * lon, part * lat
