"""FASTSIM: creep forces of an elliptic contact by the simplified theory of rolling contact. Kernels.

J. J. Kalker, Vehicle System Dynamics 11 (1982) 1-13, with the parabolic traction bound.
"""

import math

from ..compile import kernel


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
def fastsim(xi, eta, phi, peak, a, b, L1, L2, L3, cells, strips):  # type: ignore[no-untyped-def]
    """Return the creep forces on the upper body: longitudinal and lateral [N], spin moment [N.m].

    Parameters
    ----------
    xi, eta, phi : float
        Longitudinal and lateral creepage [-], spin creepage [1/m].
    peak : float
        Traction bound at the centre [Pa]: friction coefficient times normal force over `bound_volume`; <= 0 gives no
        force.
    a, b : float
        Semi-axes in the rolling and in the lateral direction [m].
    L1, L2, L3 : float
        Flexibilities [m^3/N].
    cells, strips : int
        Grid: cells along the rolling direction, strips across, each >= 1.

    Notes
    -----
    Each strip is as long as the ellipse is there and is followed from its leading to its trailing edge; the traction
    grows with the rigid slip and is cut to the bound. Creepages are positive when the upper body moves forward.
    """
    if peak <= 0.0:
        return 0.0, 0.0, 0.0
    f_lon = f_lat = moment = 0.0
    dy = 2.0 * b / strips
    for j in range(strips):
        y = -b + (j + 0.5) * dy
        width2 = 1.0 - (y / b) * (y / b)
        edge = a * math.sqrt(width2)
        dx = 2.0 * edge / cells
        grow_lon = -dx * (xi / L1 - phi * y / L3)
        grow_lat = -dx * eta / L2
        grow_spin = -dx * phi / L3
        p_lon = p_lat = 0.0
        sum_lon = sum_lat = sum_moment = 0.0
        x = edge + 0.5 * dx
        for _ in range(cells):
            x -= dx
            p_lon += grow_lon
            p_lat += grow_lat + grow_spin * x
            limit = peak * (width2 - (x / a) * (x / a))
            p2 = p_lon * p_lon + p_lat * p_lat
            if p2 > limit * limit:
                cut = limit / math.sqrt(p2)
                p_lon *= cut
                p_lat *= cut
            sum_lon += p_lon
            sum_lat += p_lat
            sum_moment += x * p_lat
        area = dx * dy
        f_lon += sum_lon * area
        f_lat += sum_lat * area
        moment += (sum_moment - y * sum_lon) * area
    return f_lon, f_lat, moment
