"""FASTSIM: creep forces of an elliptic contact by the simplified theory of rolling contact. Kernels.

J. J. Kalker, Vehicle System Dynamics 11 (1982) 1-13, with the parabolic traction bound; integrated to second order.
"""

import math

from ..compile import kernel

BLOCK = 16
"""Strips that are followed side by side."""

SCRATCH_SIZE = 8 * BLOCK
"""Numbers that `fastsim` needs room for."""

TINY = 1e-300
"""Keeps a square root above zero; no traction that matters has a square as small."""


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
    cells, strips : int
        Grid: cells along the rolling direction, strips across, each >= 1.
    scratch, at : array and int
        `SCRATCH_SIZE` zeros from position `at`; they are zero again afterwards.

    Notes
    -----
    Each strip is as long as the ellipse is there and is followed from its leading to its trailing edge; the traction
    grows with the rigid slip and is cut to the bound. Creepages are positive when the upper body moves forward.

    The traction is found and cut at the centres of the cells. From the leading edge to the first centre it is half a
    cell. What the cut takes away, the sliding of one cell, counts half for the way to this centre and half for the way
    from it: the trapezoidal rule for p' = -s - w p/|p| with the sliding w, of second order in the cell also where
    spin turns the direction of sliding. It costs one cut a cell, as the first-order step of the original does.

    Strips do not act on each other. Blocks of them go side by side from edge to edge, so that the compiler makes vector
    instructions of the loop over strips; a strip alone waits for one square root after the other.
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
    f_lon = f_lat = moment = 0.0
    for first in range(0, strips, BLOCK):
        lon, lat, turn = _block(
            slip_lon, slip_lat, phi / L3, peak, a, b, cells, strips, first, min(BLOCK, strips - first), scratch, at
        )
        f_lon += lon
        f_lat += lat
        moment += turn
    return f_lon, f_lat, moment


@kernel
def _block(slip_lon, slip_lat, slip_spin, peak, a, b, cells, strips, first, count, scratch, at):  # type: ignore[no-untyped-def]
    """Return the forces of `count` strips from number `first`; slips are over their flexibilities."""
    dx_, bound_, slip_, lon_, lat_, sum_lon_, sum_lat_, sum_moment_ = (
        at, at + BLOCK, at + 2 * BLOCK, at + 3 * BLOCK, at + 4 * BLOCK, at + 5 * BLOCK, at + 6 * BLOCK, at + 7 * BLOCK,
    )  # fmt: skip
    dy = 2.0 * b / strips
    for j in range(count):
        y = -b + (first + j + 0.5) * dy
        width2 = 1.0 - (y / b) * (y / b)
        dx = 2.0 * a * math.sqrt(width2) / cells
        scratch[dx_ + j] = dx
        scratch[bound_ + j] = peak * width2
        scratch[slip_ + j] = slip_lon - slip_spin * y
        # a whole cell is taken to every centre; this leaves half of it to the first
        scratch[lon_ + j] = 0.5 * dx * scratch[slip_ + j]
        scratch[lat_ + j] = 0.5 * dx * (slip_lat + slip_spin * (0.5 * cells + 0.25) * dx)
    curve = peak / (a * a)
    for k in range(cells):
        place = 0.5 * cells - k - 0.5
        for j in range(count):
            dx = scratch[dx_ + j]
            x = place * dx
            limit = scratch[bound_ + j] - curve * x * x
            lon = scratch[lon_ + j] - dx * scratch[slip_ + j]
            lat = scratch[lat_ + j] - dx * (slip_lat + slip_spin * (x + 0.5 * dx))
            cut = limit / math.sqrt(max(lon * lon + lat * lat, limit * limit) + TINY)
            again = 2.0 * cut - 1.0  # the traction, less what the cut took away once more
            scratch[lon_ + j] = again * lon
            scratch[lat_ + j] = again * lat
            lon *= cut
            lat *= cut
            scratch[sum_lon_ + j] += lon
            scratch[sum_lat_ + j] += lat
            scratch[sum_moment_ + j] += x * lat
    f_lon = f_lat = moment = 0.0
    for j in range(count):
        area = scratch[dx_ + j] * dy
        y = -b + (first + j + 0.5) * dy
        f_lon += scratch[sum_lon_ + j] * area
        f_lat += scratch[sum_lat_ + j] * area
        moment += (scratch[sum_moment_ + j] - y * scratch[sum_lon_ + j]) * area
    for i in range(at, at + SCRATCH_SIZE):
        scratch[i] = 0.0
    return f_lon, f_lat, moment
