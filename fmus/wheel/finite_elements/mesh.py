"""Quadrilateral mesh of a wheelset's cross-section: `Section` in, second-order mesh with curved sides out.

The mesh is structured: columns of elements run through rim, web, hub and axle, so that refining it keeps every node.
Mesh coordinates are (z, r).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementQuad2, MeshQuad, MeshQuad2

from ...errors import DataError
from .section import Section

Real = NDArray[np.float64]

WHEEL_ELEMENT = 0.014
AXLE_ELEMENT = 0.04
"""Lengths of the coarsest elements of wheel and axle [m]."""

_SAME = 1e-7


@dataclass(frozen=True)
class SectionMesh:
    """A mesh of half a wheelset.

    Attributes
    ----------
    mesh : second-order quadrilaterals in (z, r) [m]
    part : (elements,) 'axle', 'hub', 'web' or 'rim'
    section : what was meshed
    """

    mesh: MeshQuad2
    part: NDArray[np.str_]
    section: Section

    @property
    def wheel_elements(self) -> NDArray[np.int64]:
        """Indices of the elements of the wheel, without the axle."""
        return np.flatnonzero(self.part != "axle")


def mesh_section(section: Section, refinement: int = 1) -> SectionMesh:
    """Return the mesh of a cross-section.

    Parameters
    ----------
    section : Section
    refinement : int
        Every element of the coarsest mesh is cut into refinement x refinement.

    Raises
    ------
    DataError
        If an element folds, which is what an outline that intersects itself comes to.
    """
    if refinement < 1:
        raise DataError(f"mesh: refinement = {refinement}; must be >= 1")
    blocks = _blocks(section, refinement)
    points, quads, part = _join(blocks)
    mesh = MeshQuad2.from_mesh(MeshQuad(points, quads))
    mesh = MeshQuad2(_bend_web(section, mesh.doflocs), mesh.t)
    volume = Basis(mesh, ElementQuad2(), intorder=3).mapping.detDF(np.array([[0.0, 1, 1, 0, 0.5], [0, 0, 1, 1, 0.5]]))
    folded = np.flatnonzero((volume <= 0).any(axis=1))
    if folded.size:
        z, r = mesh.p[:, mesh.t[:, folded[0]]].mean(axis=1)
        raise DataError(f"mesh: an element folds near z = {z:.3f}, r = {r:.3f} m: the outline intersects itself")
    return SectionMesh(mesh, part, section)


def structured_mesh(z: Iterable[float], r: Iterable[float]) -> MeshQuad2:
    """Return the mesh of a body with rectangular cross-section between the lines of `z` and `r`."""
    return MeshQuad2.from_mesh(MeshQuad.init_tensor(np.array([*z]), np.array([*r])))


def _blocks(section: Section, refinement: int) -> list[tuple[str, Real, Real, int]]:
    """Return the blocks as (part, bottom points, top points, rows), web sides still straight."""
    web, inner = section.web, section.rim_inner_radius
    left, right = (float(side) for side in web.sides(0.0))
    corners = [z for z, _ in section.profile]
    rim = _divide([*corners, left, right, section.contact_position], WHEEL_ELEMENT, refinement)
    head = rim[(rim > left - _SAME) & (rim < right + _SAME)]
    foot_left, foot_right = (float(side) for side in web.sides(1.0))
    foot = foot_left + (head - left) / (right - left) * (foot_right - foot_left)
    faces = section.hub_faces
    beside = (
        _divide([faces[0], foot_left], WHEEL_ELEMENT, refinement)[:-1],
        _divide([foot_right, faces[1]], WHEEL_ELEMENT, refinement)[1:],
    )
    hub = np.concatenate([beside[0], foot, beside[1]])
    ends = np.array([z for z, _ in section.axle])
    axle = np.concatenate([
        _divide([*ends[ends < faces[0]], faces[0]], AXLE_ELEMENT, refinement)[:-1],
        hub,
        _divide([faces[1], *ends[ends > faces[1]]], AXLE_ELEMENT, refinement)[1:],
    ])  # fmt: skip
    seat = float(section.axle_radius(faces[0]))

    def rows(height: float, size: float) -> int:
        return refinement * max(1, round(height / size))

    return [
        ("axle", _line(axle, 0 * axle), _line(axle, section.axle_radius(axle)), rows(seat, AXLE_ELEMENT)),
        ("hub", _line(hub, seat), _line(hub, section.hub_radius), rows(section.hub_radius - seat, WHEEL_ELEMENT)),
        ("web", _line(foot, section.hub_radius), _line(head, inner), rows(inner - section.hub_radius, WHEEL_ELEMENT)),
        ("rim", _line(rim, inner), _line(rim, section.profile_radius(rim)),
         rows(section.contact_radius - inner, WHEEL_ELEMENT)),
    ]  # fmt: skip


def _divide(corners: Iterable[float], size: float, refinement: int) -> Real:
    """Return the corners in order with the lengths between them divided evenly."""
    ordered = sorted(corners)
    kept = [z for i, z in enumerate(ordered) if i == 0 or z - ordered[i - 1] > _SAME]
    lines = [np.array(kept[:1])]
    for a, b in pairwise(kept):
        count = refinement * max(1, round((b - a) / size))
        lines.append(a + (b - a) * np.arange(1, count + 1) / count)
    return np.concatenate(lines)


def _line(z: Real, r: Real | float) -> Real:
    """Return points (k, 2) with the given coordinates."""
    return np.column_stack([z, np.broadcast_to(r, z.shape)])


def _join(blocks: list[tuple[str, Real, Real, int]]) -> tuple[Real, NDArray[np.int64], NDArray[np.str_]]:
    """Return vertices (2, k), quadrilaterals (4, elements) and their parts, with shared vertices merged."""
    points: list[Real] = []
    quads: list[NDArray[np.int64]] = []
    parts: list[str] = []
    first = 0
    for part, bottom, top, rows in blocks:
        t = np.arange(rows + 1)[:, None, None] / rows
        grid = bottom + (top - bottom) * t
        index = first + np.arange(grid.shape[0] * grid.shape[1]).reshape(grid.shape[:2])
        points.append(grid.reshape(-1, 2))
        quads.append(np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]]).reshape(4, -1))
        parts += [part] * quads[-1].shape[1]
        first += index.size
    everything = np.concatenate(points)
    _, kept, where = np.unique(
        np.round(everything / _SAME).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    return everything[kept].T.copy(), where.ravel()[np.hstack(quads)], np.array(parts)


def _bend_web(section: Section, points: Real) -> Real:
    """Move the nodes of the straight-sided web to where the web's faces have them."""
    z, r = points
    within = (r > section.hub_radius + _SAME) & (r < section.rim_inner_radius - _SAME)
    t = section.web_parameter(r)
    straight = [(1 - t) * float(head) + t * float(foot) for head, foot in zip(
        section.web.sides(0.0), section.web.sides(1.0), strict=True)]  # fmt: skip
    fraction = (z - straight[0]) / (straight[1] - straight[0])
    left, right = section.web.sides(t)
    return np.vstack([np.where(within, left + fraction * (right - left), z), r])
