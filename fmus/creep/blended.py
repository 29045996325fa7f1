"""Creep forces that are right with spin: strips like FASTSIM's, with a bound between ellipse and parabola. Kernels.

FASTSIM's parabolic bound is right for a translation in partial slip and wrong for spin, where most of the contact
slides and the bound is Hertz's pressure, an ellipse. Its flexibilities, one for each creepage, make the moment of a
small spin too small and turn the direction in which much of the contact slides. Here

- the bound is the ellipse, and with the share of translation T in the rigid slip a part 0.6 T of the parabola;
- the longitudinal traction of spin has a flexibility of its own, with which a small spin makes Kalker's moment C33;
- what differs between flexibilities goes as sliding begins: all tend to their mean.
"""

import math

from ..compile import kernel
from .strips import cell, follow

PARABOLIC_PART = 0.6
"""Part of the parabola in the bound of a pure translation: with it lateral and longitudinal forces agree with CONTACT
to 3 %, where the ellipse alone is 6 % and the parabola alone 4 % off."""


@kernel
def spin_flexibility(semi_axis_lat: float, shear_modulus: float, c33: float) -> float:
    """Return the flexibility of the longitudinal traction of spin, L4 [m^3/N], that makes the moment G (a b)^2 C33.

    Without sliding that traction is spin y (e - x)/L4; y times it over the ellipse gives 8 a^2 b^3/(15 L4).
    """
    return 8.0 * semi_axis_lat / (15.0 * shear_modulus * c33)


@kernel
def volumes(a: float, b: float, cells: int, strips: int) -> tuple[float, float]:
    """Return the integrals of q and of q^2 = 1 - (x/a)^2 - (y/b)^2 over the graded grid [m^2].

    They tend to 2/3 pi a b and pi a b / 2.
    """
    square = strips * (2.0 / 3.0 + 1.0 / (3.0 * strips * strips))
    cube = 0.0
    for j in range(strips):
        y = (2.0 * j + 1.0) / strips - 1.0
        width = math.sqrt(1.0 - y * y)
        cube += width * width * width
    first = second = 0.0
    for k in range(cells):
        _, q, length = cell(k, cells, True)
        first += q * length
        second += q * q * length
    area = a * 2.0 * b / strips
    return area * square * first, area * cube * second


@kernel
def blended(  # type: ignore[no-untyped-def]
    xi, eta, phi, friction, elliptic_volume, parabolic_volume, a, b, L1, L2, L3, L4, cells, strips, scratch, at
):
    """Return the creep forces on the upper body: longitudinal and lateral [N], spin moment [N.m].

    Parameters
    ----------
    xi, eta, phi : float
        Longitudinal and lateral creepage [-], spin creepage [1/m].
    friction : float
        Friction coefficient times normal force [N]; <= 0 gives no force.
    elliptic_volume, parabolic_volume : float
        `volumes` of this grid [m^2].
    a, b : float
        Semi-axes in the rolling and in the lateral direction [m].
    L1, L2, L3, L4 : float
        `flexibilities` and `spin_flexibility` [m^3/N].
    cells, strips, scratch, at :
        See `strips.follow`.

    Notes
    -----
    The mean square of the rigid slip by spin is phi^2 (a^2 + b^2)/4. With s^2 the mean square of rigid slip over
    flexibility, sliding goes with (s a/p0)^4, p0 the largest pressure times the friction coefficient.
    """
    if friction <= 0.0:
        return 0.0, 0.0, 0.0
    arm2 = 0.25 * (a * a + b * b)
    translation = (xi / L1) ** 2 + (eta / L2) ** 2
    turning = (phi / L3) ** 2 * arm2
    total = translation + turning
    if total <= 0.0:
        return 0.0, 0.0, 0.0
    share = translation / total
    reach = 2.0 * math.pi * a * a * b / (3.0 * friction)
    stick = 1.0 / (1.0 + (total * reach * reach) ** 2)
    even = (1.0 - stick) * share
    mean = math.sqrt((xi * xi + eta * eta + phi * phi * arm2) / total)
    L4 = L3 + (L4 - L3) * stick
    part = PARABOLIC_PART * share
    return follow(
        xi / (L1 + even * (mean - L1)),
        eta / (L2 + even * (mean - L2)),
        phi / (L4 + even * (mean - L4)),
        phi / (L3 + even * (mean - L3)),
        (1.0 - part) * friction / elliptic_volume,
        part * friction / parabolic_volume,
        a, b, cells, strips, True, scratch, at,
    )  # fmt: skip
