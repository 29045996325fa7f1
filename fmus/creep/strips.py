"""Strips of a contact ellipse along the rolling direction: slip and traction bound in, forces out. Kernels.

What FASTSIM and the law with the blended bound share. The traction of a strip grows from the leading edge on with the
rigid slip and is cut to a bound. On a strip of half-length e = a sqrt(1 - (y/b)^2), at x = e u, the bound is

    elliptic q + parabolic q^2,   q^2 = 1 - (x/a)^2 - (y/b)^2 = (1 - (y/b)^2) (1 - u^2).
"""

import math

from ..compile import kernel

BLOCK = 16
"""Strips that are followed side by side."""

SCRATCH_SIZE = 8 * BLOCK
"""Numbers that `follow` needs room for."""

TINY = 1e-300
"""Keeps a square root above zero; no traction that matters has a square as small."""


@kernel
def follow(slip_lon, slip_lat, spin_lon, spin_lat, elliptic, parabolic, a, b, cells, strips, graded, scratch, at):  # type: ignore[no-untyped-def]
    """Return the forces of all strips: longitudinal, lateral [N], spin moment [N.m].

    Parameters
    ----------
    slip_lon, slip_lat : float
        Creepages over their flexibilities [Pa/m].
    spin_lon, spin_lat : float
        Spin over the flexibilities of its longitudinal and of its lateral part [Pa/m^2].
    elliptic, parabolic : float
        Traction bound at the centre, both parts [Pa].
    a, b : float
        Semi-axes in the rolling and in the lateral direction [m].
    cells, strips : int
        Grid, each >= 1.
    graded : bool
        Cells that get shorter towards the edges, x = e cos(theta) with equal steps of theta, which an elliptic bound
        needs: its slope at the edge is infinite. Else all of one length.
    scratch, at : array and int
        `SCRATCH_SIZE` zeros from position `at`; they are zero again afterwards.

    Notes
    -----
    The traction is found and cut at the centres of the cells; from the leading edge to the first centre it is half a
    cell. Where it slides, p' = -s - w p/|p|, s the rigid slip over flexibility, w the sliding that keeps |p| on the
    bound. By the trapezoidal rule half of w counts on the way from a centre, and the cut at the next one does what the
    other half would. So the step is of second order in the cell also where spin turns the direction of sliding, with
    one root a cell, as in the first-order step of the original. Taking for the first half what the cut before took away
    would do too, but that rings on coarse grids; it is the largest that counts, which makes forces continuous.

    Strips do not act on each other. Blocks of them go side by side from edge to edge, so that the compiler makes vector
    instructions of the loop over strips; a strip alone waits for one square root after the other.
    """
    f_lon = f_lat = moment = 0.0
    for first in range(0, strips, BLOCK):
        lon, lat, turn = _block(
            slip_lon, slip_lat, spin_lon, spin_lat, elliptic, parabolic, a, b, cells, strips, graded,
            first, min(BLOCK, strips - first), scratch, at,
        )  # fmt: skip
        f_lon += lon
        f_lat += lat
        moment += turn
    return f_lon, f_lat, moment


@kernel
def cell(k, cells, graded):  # type: ignore[no-untyped-def]
    """Return the centre of cell `k`, the root 1 - u^2 there, and the cell's length, relative to half the strip."""
    if graded:
        step = math.pi / cells
        angle = (k + 0.5) * step
        root = math.sin(angle)
        return math.cos(angle), root, 2.0 * math.sin(0.5 * step) * root
    u = 1.0 - (2.0 * k + 1.0) / cells
    return u, math.sqrt(1.0 - u * u), 2.0 / cells


@kernel
def prepare(slip_lon, spin_lon, a, b, strips, first, count, scratch, at):  # type: ignore[no-untyped-def]
    """Put half-length, root 1 - (y/b)^2 and longitudinal slip of strips from number `first` on into the scratch."""
    dy = 2.0 * b / strips
    for j in range(count):
        y = -b + (first + j + 0.5) * dy
        root = math.sqrt(1.0 - (y / b) * (y / b))
        scratch[at + j] = a * root
        scratch[at + BLOCK + j] = root
        scratch[at + 2 * BLOCK + j] = slip_lon - spin_lon * y


@kernel
def cut_at_centre(lon, lat, limit, slip_lon, slip_lat, half_way, rise_linear, rise_square):  # type: ignore[no-untyped-def]
    """Return the part of a traction that the bound leaves, and the part that the way to the next centre starts with.

    Parameters
    ----------
    lon, lat : float
        Traction at the centre of a cell before it is cut [Pa].
    limit : float
        The bound there [Pa].
    slip_lon, slip_lat : float
        Rigid slip over flexibility there [Pa/m].
    half_way : float
        Half of the way to the next centre [m].
    rise_linear, rise_square : float
        Slopes of both parts of the bound along the way [Pa/m].
    """
    size2 = max(lon * lon + lat * lat, limit * limit) + TINY
    inverse = 1.0 / math.sqrt(size2)
    cut = limit * inverse
    sliding = -inverse * (slip_lon * lon + slip_lat * lat)
    sliding = half_way * (sliding - rise_linear - rise_square)
    return cut, cut - min(max(sliding * inverse, 0.0), 1.0 - cut)


@kernel
def add_up(b, strips, first, count, scratch, at):  # type: ignore[no-untyped-def]
    """Return the forces of the strips whose sums are in the scratch: longitudinal, lateral [N], spin moment [N.m]."""
    dy = 2.0 * b / strips
    f_lon = f_lat = moment = 0.0
    for j in range(count):
        edge = scratch[at + j]
        area = edge * dy
        y = -b + (first + j + 0.5) * dy
        f_lon += scratch[at + 5 * BLOCK + j] * area
        f_lat += scratch[at + 6 * BLOCK + j] * area
        moment += (edge * scratch[at + 7 * BLOCK + j] - y * scratch[at + 5 * BLOCK + j]) * area
    for i in range(at, at + SCRATCH_SIZE):
        scratch[i] = 0.0
    return f_lon, f_lat, moment


@kernel
def _block(  # type: ignore[no-untyped-def]
    slip_lon, slip_lat, spin_lon, spin_lat, elliptic, parabolic, a, b, cells, strips, graded, first, count, scratch, at
):
    """Return the forces of `count` strips from number `first`."""
    edge_, root_, slip_, lon_, lat_, sum_lon_, sum_lat_, sum_moment_ = (
        at, at + BLOCK, at + 2 * BLOCK, at + 3 * BLOCK, at + 4 * BLOCK, at + 5 * BLOCK, at + 6 * BLOCK, at + 7 * BLOCK,
    )  # fmt: skip
    prepare(slip_lon, spin_lon, a, b, strips, first, count, scratch, at)
    u, q, length = cell(0, cells, graded)
    way = 1.0 - u
    for k in range(cells):
        turn = (u + 0.5 * way) * spin_lat  # lateral slip by spin, over e: on the way here, and here
        here = u * spin_lat
        linear = elliptic * q
        square = parabolic * q * q
        rise_linear = elliptic * u / (q * a)  # of the bound along the way
        rise_square = 2.0 * parabolic * u / a
        u_here, length_here, way_here = u, length, way
        u, q, length = cell(min(k + 1, cells - 1), cells, graded)
        way = u_here - u
        for j in range(count):
            edge = scratch[edge_ + j]
            root = scratch[root_ + j]
            dx = way_here * edge
            lon = scratch[lon_ + j] - dx * scratch[slip_ + j]
            lat = scratch[lat_ + j] - dx * (slip_lat + turn * edge)
            cut, kept = cut_at_centre(
                lon, lat, root * (linear + square * root), scratch[slip_ + j], slip_lat + here * edge,
                0.5 * way * edge, rise_linear, rise_square * root,
            )  # fmt: skip
            scratch[lon_ + j] = kept * lon
            scratch[lat_ + j] = kept * lat
            cut *= length_here
            lon *= cut
            lat *= cut
            scratch[sum_lon_ + j] += lon
            scratch[sum_lat_ + j] += lat
            scratch[sum_moment_ + j] += u_here * lat
    return add_up(b, strips, first, count, scratch, at)
