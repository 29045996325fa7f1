"""Mode shapes at nodes, as a file holds them but mass-normalised and in SI; what they are at the contact point.

A wheel may be modelled whole, as a half circle (one family of each doublet for each condition in its plane) or as half
a wheelset (symmetric or antisymmetric about mid-axle for each condition there). Shapes of a part are normalised to its
mass; in the whole they are smaller by the root of two for each plane.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...errors import DataError
from ..function import Real, code_name

RIGID_HZ = 1.0
"""Below this a mode of a free model is rigid motion; its frequency is rounding and becomes 0."""

_PATCH = 0.05
"""Nodes so near to the contact [m] tell its rotation."""

_FLAT = 1e-5
"""Share of the largest motion up to which there is none."""


@dataclass(frozen=True)
class NodalModes:
    """Normal modes at nodes.

    Attributes
    ----------
    where : file, for messages
    frequency_hz : (n,) natural frequencies [Hz]
    damping_ratio : (n,) damping ratios; nan where the file has none
    nodes : (k,) numbers of the nodes that move
    shape : (n, k, 3) or (n, k, 6) mass-normalised translations [kg^-1/2] and rotations [kg^-1/2/m]; nan where missing
    position : coordinates of nodes by number [m], of more or fewer than move
    labels : (n,) names of the modes
    origin : what the file says about itself, '' if nothing
    """

    where: str
    frequency_hz: Real
    damping_ratio: Real
    nodes: NDArray[np.int64]
    shape: Real
    position: Mapping[int, Real]
    labels: tuple[str, ...]
    origin: str = ""


@dataclass(frozen=True)
class Extent:
    """What part of a wheelset a model is.

    Attributes
    ----------
    circle : 'whole', or 'cosine' or 'sine' for the family that a half circle has
    axle : 'whole', or 'symmetric' or 'antisymmetric' for the motion about mid-axle that half a wheelset has
    """

    circle: str = "whole"
    axle: str = "whole"

    @property
    def factor(self) -> float:
        """Return what shapes of the part are multiplied with to be those of the whole."""
        return float(0.5 ** (0.5 * ((self.circle != "whole") + (self.axle != "whole"))))


@dataclass(frozen=True)
class ContactModes:
    """Modes at the contact point in the contract's axes.

    Attributes
    ----------
    frequency_hz, damping_ratio : (n,)
    shape : (n, 4) mass-normalised, of the whole wheelset
    diameters : (n,) number of nodal diameters, -1 where it is not known
    axial : (n,) whether the tread moves along the axle more than across it
    labels : (n,)
    extent : what the model is
    spin_from : 'rotations', 'neighbours' or 'none': where the spin was taken from
    origin : what the file says about itself
    """

    frequency_hz: Real
    damping_ratio: Real
    shape: Real
    diameters: NDArray[np.int64]
    axial: NDArray[np.bool_]
    labels: tuple[str, ...]
    extent: Extent
    spin_from: str
    origin: str = ""


def at_contact(modes: NodalModes, node: int | None, axes: Mapping[int, str]) -> ContactModes:
    """Return the modes at a node in the contract's axes.

    Parameters
    ----------
    node : number of the contact's node; None where there is one only
    axes : direction of each signed direction code, with all of lon, lat and ver; see `complete_axes`
    """
    place = _place(modes, node)
    signed = {direction: code for code, direction in axes.items()}
    translation = np.column_stack([_column(modes, place, signed[d]) for d in ("lon", "lat", "ver")])
    spin, spin_from = _spin(modes, place, signed)
    frame = _frame(signed)
    extent = _extent(modes, int(modes.nodes[place]), frame, translation)
    shape = np.column_stack([translation, spin]) * extent.factor
    rigid = modes.frequency_hz < RIGID_HZ
    diameters = _diameters(modes, place, frame)
    across = np.abs(translation[:, [0, 2]]).max(axis=1)
    return ContactModes(
        frequency_hz=np.where(rigid, 0.0, modes.frequency_hz),
        damping_ratio=np.where(rigid, 0.0, modes.damping_ratio),
        shape=shape,
        diameters=diameters,
        axial=np.abs(translation[:, 1]) > across,
        labels=modes.labels,
        extent=extent,
        spin_from=spin_from,
        origin=modes.origin,
    )


def complete_axes(axes: Mapping[int, str], where: str) -> dict[int, str]:
    """Return axes with all of lon, lat, ver and, about the axis of ver, spin.

    Raises
    ------
    DataError
        If a direction is missing, or lon, lat, ver are left-handed, so that a sign is wrong.

    Examples
    --------
    >>> complete_axes({2: "lon", -3: "lat", -1: "ver"}, "a.frd")[-4]
    'spin'
    """
    signed = {direction: code for code, direction in axes.items()}
    missing = [d for d in ("lon", "lat", "ver") if d not in signed]
    if missing:
        raise DataError(
            f"{where}: mode shapes have signs, so each direction needs its axis; {missing[0]} is missing: give the "
            "option axis, such as 1=lon, -2=lat, -3=ver"
        )
    if np.linalg.det(_frame(signed)) < 0:
        said = ", ".join(f"{d} = {code_name(signed[d])}" for d in ("lon", "lat", "ver"))
        raise DataError(f"{where}: axes {said} are left-handed; one sign is wrong")
    ver = signed["ver"]
    return {**axes, signed.get("spin", ver + 3 if ver > 0 else ver - 3): "spin"}


def _frame(signed: Mapping[str, int]) -> Real:
    """Return the unit vectors of lon, lat and ver in the file's axes, as rows."""
    frame = np.zeros((3, 3))
    for row, direction in enumerate(("lon", "lat", "ver")):
        frame[row, abs(signed[direction]) - 1] = np.sign(signed[direction])
    return frame


def _place(modes: NodalModes, node: int | None) -> int:
    """Return the index of the contact's node."""
    if node is None and modes.nodes.size == 1:
        return 0
    if node is None:
        raise DataError(f"{modes.where}: has {modes.nodes.size} nodes; say which is the contact (option node)")
    found = np.flatnonzero(modes.nodes == node)
    if not found.size:
        raise DataError(f"{modes.where}: node {node} is not in it; has {modes.nodes.min()} to {modes.nodes.max()}")
    return int(found[0])


def _column(modes: NodalModes, place: int, code: int) -> Real:
    """Return the motion at a node along a signed axis, (n,)."""
    values: Real = modes.shape[:, place, abs(code) - 1] * np.sign(code)
    if not np.isfinite(values).all():
        raise DataError(f"{modes.where}: the data have no {code_name(abs(code))} at node {modes.nodes[place]}")
    return values


def _spin(modes: NodalModes, place: int, signed: Mapping[str, int]) -> tuple[Real, str]:
    """Return the rotation about the axis of ver: from rotations, else from the motion of nodes nearby, else 0."""
    code = signed["spin"]
    if modes.shape.shape[2] == 6 and np.isfinite(modes.shape[:, place, abs(code) - 1]).all():
        return _column(modes, place, code), "rotations"
    own = modes.position.get(int(modes.nodes[place]))
    near = [
        i for i, node in enumerate(modes.nodes)
        if own is not None and int(node) in modes.position
        and np.linalg.norm(modes.position[int(node)] - own) <= _PATCH
    ]  # fmt: skip
    if own is None or len(near) < 4:
        return np.zeros(modes.frequency_hz.size), "none"
    offsets = np.array([modes.position[int(modes.nodes[i])] - own for i in near])
    design = np.column_stack([np.ones(len(near)), offsets])
    if np.linalg.matrix_rank(design, tol=1e-3 * _PATCH) < 4:
        return np.zeros(modes.frequency_hz.size), "none"
    slopes = np.linalg.lstsq(design, modes.shape[:, near, :3].transpose(1, 0, 2).reshape(len(near), -1), rcond=None)[0]
    gradient = slopes[1:].reshape(3, -1, 3)  # d u_j / d x_i at [i, mode, j]
    axis = abs(code) - 4
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation: Real = 0.5 * np.sign(code) * (gradient[i, :, j] - gradient[j, :, i])
    return rotation, "neighbours"


def _extent(modes: NodalModes, node: int, frame: Real, translation: Real) -> Extent:
    """Return what part of the wheelset the model is, by its coordinates and what cannot move."""
    if node not in modes.position or len(modes.position) < 10:
        return Extent()
    points = np.array(list(modes.position.values())) @ frame.T  # lon, lat, ver
    size = np.ptp(points, axis=0).max()
    lon, lat = points[:, 0], points[:, 1]
    circle, axle = "whole", "whole"
    if min(abs(lon.min()), abs(lon.max())) < 1e-3 * size < np.ptp(lon):
        largest = np.abs(translation).max()
        if np.abs(translation[:, 0]).max() <= _FLAT * largest:
            circle = "cosine"
        elif np.abs(translation[:, 1:]).max() <= _FLAT * largest:
            circle = "sine"
        else:
            raise DataError(
                f"{modes.where}: is half a circle, but at node {node} no direction is held by its plane; the contact "
                "must lie in the plane"
            )
    if min(abs(lat.min()), abs(lat.max())) < 1e-3 * size < np.ptp(lat):
        rigid = translation[modes.frequency_hz < RIGID_HZ]
        if not rigid.size:
            raise DataError(
                f"{modes.where}: is half a wheelset without rigid motion, so the condition at mid-axle is not known; "
                "the model must be free"
            )
        axle = "antisymmetric" if np.abs(rigid[:, 1]).max() > 0.1 * np.abs(rigid).max() else "symmetric"
    return Extent(circle, axle)


def _diameters(modes: NodalModes, place: int, frame: Real) -> NDArray[np.int64]:
    """Return the number of nodal diameters of each mode by its motion at the nodes on the contact's circle."""
    unknown = np.full(modes.frequency_hz.size, -1, dtype=np.int64)
    own = modes.position.get(int(modes.nodes[place]))
    if own is None:
        return unknown
    known = np.array([int(node) in modes.position for node in modes.nodes])
    points = np.array([modes.position[int(node)] for node in modes.nodes[known]]) @ frame.T
    contact = frame @ own
    radius = np.hypot(points[:, 0], points[:, 2])
    ring = (np.abs(radius - np.hypot(contact[0], contact[2])) < 1e-3 * radius.max()) & (
        np.abs(points[:, 1] - contact[1]) < 1e-3 * radius.max()
    )
    if ring.sum() < 6:
        return unknown
    angle = np.arctan2(points[ring, 0], -points[ring, 2])  # 0 at the contact, which is below
    motion = modes.shape[:, known, :3][:, ring] @ frame.T
    radial = motion[..., 0] * np.sin(angle) - motion[..., 2] * np.cos(angle)
    around = motion[..., 0] * np.cos(angle) + motion[..., 2] * np.sin(angle)
    parts = np.stack([motion[..., 1], radial, around], axis=1).reshape(-1, angle.size).T
    rest = []
    for n in range(min(9, int(ring.sum()) // 2)):
        basis = np.column_stack([np.cos(n * angle), np.sin(n * angle)])[:, : 1 if n == 0 else 2]
        left = parts - basis @ np.linalg.lstsq(basis, parts, rcond=None)[0]
        rest.append((left**2).sum(axis=0).reshape(-1, 3).sum(axis=1))
    return np.asarray(np.argmin(rest, axis=0), dtype=np.int64)
