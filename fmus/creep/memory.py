"""A rolling contact with memory: FASTSIM's strips, whose tractions travel with the particles. Kernels.

In a steady contact a traction depends on the way from the leading edge only. Here it is what the particles bring with
them: Dp/Dt = -V s, s the rigid slip over flexibility, cut to the bound as in FASTSIM. A contact that slides keeps its
force while the slip swings, one that sticks is a spring.

The flexibilities L of the simplified theory are those of steady rolling; with them a patch that is displaced as a whole
would be too stiff. What is missing, 1/k - L/(pi a b) with k the tangential stiffness of the ellipse, is a spring in
series with all strips, the displacement that all particles share. Steady rolling does not know it.
"""

import math

from ..compile import kernel
from .strips import BLOCK, TINY, add_up, cell, cut_at_centre, prepare

ANGLES = 1000
"""Directions over which a compliance is averaged; the mean of a smooth periodic function needs few, a narrow ellipse
more."""


@kernel
def tangential_stiffness(a, b, shear_modulus, poisson):  # type: ignore[no-untyped-def]
    """Return the stiffness of an ellipse that does not slip, displaced as a whole: longitudinal and lateral [N/m].

    Notes
    -----
    R. D. Mindlin, J. Appl. Mech. 16 (1949) 259-268: the traction F/(2 pi a b) (1 - (x/a)^2 - (y/b)^2)^-1/2 displaces
    the whole ellipse by the same way. At its centre Cerruti's solution, integrated along rays of length r(t), leaves a
    mean over their directions, for two equal bodies F/(4 pi G a b) int r (1 - nu + nu cos^2 t) dt; sin^2 laterally.

    >>> lon, lat = tangential_stiffness(5e-3, 5e-3, 80e9, 0.3)
    >>> round(lon / (4 * 80e9 * 5e-3 / (2 - 0.3)), 12), round(lat / lon, 12)
    (1.0, 1.0)
    """
    lon = lat = 0.0
    for i in range(ANGLES):
        angle = 2.0 * math.pi * i / ANGLES
        c2 = math.cos(angle) ** 2
        ray = 1.0 / math.sqrt(b * b * c2 + a * a * (1.0 - c2))
        lon += ray * (1.0 - poisson + poisson * c2)
        lat += ray * (1.0 - poisson * c2)
    scale = 2.0 * shear_modulus * ANGLES
    return scale / lon, scale / lat


@kernel
def series_compliances(a, b, shear_modulus, poisson, L1, L2):  # type: ignore[no-untyped-def]
    """Return what all strips share, longitudinal and lateral [m/N]; 0 where strips are softer than the ellipse."""
    lon, lat = tangential_stiffness(a, b, shear_modulus, poisson)
    area = math.pi * a * b
    return max(1.0 / lon - L1 / area, 0.0), max(1.0 / lat - L2 / area, 0.0)


@kernel
def carry(  # type: ignore[no-untyped-def]
    slip_lon, slip_lat, spin, peak, a, b, cells, strips, way, tractions, place, keep, scratch, at
):
    """Return the forces of all strips after the particles have gone on: longitudinal, lateral [N], spin moment [N.m].

    Parameters
    ----------
    slip_lon, slip_lat, spin : float
        Creepages over their flexibilities [Pa/m, Pa/m, Pa/m^2], means over the way.
    peak : float
        Parabolic traction bound at the centre [Pa].
    a, b, cells, strips, scratch, at :
        See `strips.follow`; cells of one length.
    way : float
        How far the particles have gone [m]; beyond 1e30 nothing of the past is left.
    tractions, place : array and int
        Tractions at the centres of the cells, from position `place`: cells times strips longitudinal ones, strips side
        by side, then the lateral ones [Pa].
    keep : bool
        Whether to write the new tractions there.

    Notes
    -----
    From one centre to the next FASTSIM makes the traction T of the one before. On a way that is part of that distance
    dx, the traction goes on from the one that is there, p, to (dx p + way T)/(dx + way) and is cut: an implicit upwind
    step, stable for any way. It rests where the steady law is, to rounding. An even displacement of all particles it
    carries exactly; it smears what differs from cell to cell.

    In the step of second order that FASTSIM makes where it slides, part of the sliding counts on the way from the
    centre. Here it does as far as the cell slides now.
    """
    f_lon = f_lat = moment = 0.0
    for first in range(0, strips, BLOCK):
        lon, lat, turn = _block(
            slip_lon, slip_lat, spin, peak, a, b, cells, strips, way, tractions, place, keep,
            first, min(BLOCK, strips - first), scratch, at,
        )  # fmt: skip
        f_lon += lon
        f_lat += lat
        moment += turn
    return f_lon, f_lat, moment


@kernel
def _block(  # type: ignore[no-untyped-def]
    slip_lon, slip_lat, spin, peak, a, b, cells, strips, gone, tractions, place, keep, first, count, scratch, at
):
    """Return the forces of `count` strips from number `first`."""
    edge_, root_, slip_, lon_, lat_ = at, at + BLOCK, at + 2 * BLOCK, at + 3 * BLOCK, at + 4 * BLOCK
    sum_lon_, sum_lat_, sum_moment_ = at + 5 * BLOCK, at + 6 * BLOCK, at + 7 * BLOCK
    prepare(slip_lon, spin, a, b, strips, first, count, scratch, at)
    u, q, length = cell(0, cells, False)
    way = 1.0 - u
    for k in range(cells):
        turn = (u + 0.5 * way) * spin
        here = u * spin
        square = peak * q * q
        rise = 2.0 * peak * u / a
        u_here, way_here = u, way
        u, q, _ = cell(min(k + 1, cells - 1), cells, False)
        way = u_here - u
        p_lon = place + k * strips + first
        p_lat = p_lon + cells * strips
        for j in range(count):
            edge = scratch[edge_ + j]
            root = scratch[root_ + j]
            limit = root * root * square
            dx = way_here * edge
            part = gone / (gone + dx)
            lon = scratch[lon_ + j] - dx * scratch[slip_ + j]
            lat = scratch[lat_ + j] - dx * (slip_lat + turn * edge)
            cut, kept = cut_at_centre(
                lon, lat, limit, scratch[slip_ + j], slip_lat + here * edge, 0.5 * way * edge, 0.0, rise * root
            )
            away = (cut - kept) * math.sqrt(lon * lon + lat * lat)
            new_lon = tractions[p_lon + j] + part * (lon - tractions[p_lon + j])
            new_lat = tractions[p_lat + j] + part * (lat - tractions[p_lat + j])
            size = math.sqrt(new_lon * new_lon + new_lat * new_lat + TINY)
            away = min(1.0, max(size - limit, 0.0) / (part * away + TINY)) * (cut - kept)
            factor = min(limit / size, 1.0)
            new_lon *= factor
            new_lat *= factor
            if keep:
                tractions[p_lon + j] = new_lon
                tractions[p_lat + j] = new_lat
            scratch[lon_ + j] = new_lon - away * lon
            scratch[lat_ + j] = new_lat - away * lat
            scratch[sum_lon_ + j] += length * new_lon
            scratch[sum_lat_ + j] += length * new_lat
            scratch[sum_moment_ + j] += u_here * length * new_lat
    return add_up(b, strips, first, count, scratch, at)
