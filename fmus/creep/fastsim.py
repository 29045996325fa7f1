"""FASTSIM: creep forces of an elliptic contact by the simplified theory of rolling contact. Kernels.

J. J. Kalker, Vehicle System Dynamics 11 (1982) 1-13, with the parabolic traction bound; integrated to second order.
"""

import math

from ..compile import kernel
from .strips import follow


@kernel
def flexibilities(
    semi_axis_lon: float, semi_axis_lat: float, shear_modulus: float, c11: float, c22: float, c23: float
) -> tuple[float, float, float]:
    """Return the flexibilities L1 (longitudinal), L2 (lateral), L3 (spin) of the simplified theory [m^3/N].

    Parameters
    ----------
    semi_axis_lon, semi_axis_lat : float
        Semi-axes a (rolling direction) and b [m].
    shear_modulus : float
        G [Pa].
    c11, c22, c23 : float
        Kalker's coefficients [-].
    """
    a = semi_axis_lon
    L1 = 8.0 * a / (3.0 * shear_modulus * c11)
    L2 = 8.0 * a / (3.0 * shear_modulus * c22)
    L3 = math.pi * a * math.sqrt(a / semi_axis_lat) / (4.0 * shear_modulus * c23)
    return L1, L2, L3


@kernel
def bound_volume(a: float, b: float, cells: int, strips: int) -> float:
    """Return the integral over the grid of 1 - (x/a)^2 - (y/b)^2 [m^2]; pi a b / 2 for a fine grid.

    The traction bound is normalised with it, so that full sliding gives exactly the friction force on any grid.
    """
    total = 0.0
    for j in range(strips):
        y = (2.0 * j + 1.0) / strips - 1.0
        width = math.sqrt(1.0 - y * y)
        total += width * width * width
    along = 4.0 / 3.0 + 2.0 / (3.0 * cells * cells)
    return total * (2.0 * b / strips) * a * along


@kernel
def fastsim(xi, eta, phi, friction, volume, a, b, L1, L2, L3, cells, strips, scratch, at):  # type: ignore[no-untyped-def]
    """Return the creep forces on the upper body: longitudinal and lateral [N], spin moment [N.m].

    Parameters
    ----------
    xi, eta, phi : float
        Longitudinal and lateral creepage [-], spin creepage [1/m].
    friction : float
        Friction coefficient times normal force [N]; <= 0 gives no force.
    volume : float
        `bound_volume` of this grid [m^2], which makes full sliding give exactly `friction`.
    a, b : float
        Semi-axes in the rolling and in the lateral direction [m].
    L1, L2, L3 : float
        Flexibilities [m^3/N].
    cells, strips, scratch, at :
        See `strips.follow`.

    Notes
    -----
    Creepages are positive when the upper body moves forward.
    """
    if friction <= 0.0:
        return 0.0, 0.0, 0.0
    slip_lon = xi / L1
    slip_lat = eta / L2
    slip = math.sqrt(slip_lon * slip_lon + slip_lat * slip_lat)
    peak = friction / volume
    if phi == 0.0 and slip * a > 2.0 * peak:  # the bound never rises faster than the traction: all slides, one way
        part = -friction / slip
        return part * slip_lon, part * slip_lat, 0.0
    spin = phi / L3
    return follow(slip_lon, slip_lat, spin, spin, 0.0, peak, a, b, cells, strips, False, scratch, at)
