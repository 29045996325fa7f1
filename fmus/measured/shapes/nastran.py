"""What Nastran's results hold of normal modes, of whichever file; checked, and in SI out."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from ...errors import DataError
from ..function import Real
from ..units import UnitSystem
from .nodal import RIGID_HZ, NodalModes
from .raw import RawMode, in_si


class Grid(NamedTuple):
    """A GRID entry: number, system of its coordinates, coordinates, system of its displacements."""

    node: int
    system: int
    xyz: Real
    output: int


@dataclass
class Nastran:
    """What has been found in a file.

    Attributes
    ----------
    where : file, for messages
    remedy : what gives coordinates that are missing
    values : eigenvalue and generalised mass by mode
    vectors : (3,) or (6,) motion by node, by mode
    grids : by node
    """

    where: str
    remedy: str
    values: dict[int, tuple[float, float]] = field(default_factory=dict)
    vectors: dict[int, dict[int, Real]] = field(default_factory=dict)
    grids: dict[int, Grid] = field(default_factory=dict)

    def add_value(self, mode: int, eigenvalue: float, mass: float, where: str) -> None:
        """Take an eigenvalue; of two subcases none can be told from the other."""
        if self.values.setdefault(mode, (eigenvalue, mass)) != (eigenvalue, mass):
            raise DataError(f"{where}: mode {mode} is there twice; must be one subcase, each in a file of its own")

    def add_vector(self, mode: int, node: int, values: Real, where: str) -> None:
        """Take the motion of a node in a mode."""
        nodes = self.vectors.setdefault(mode, {})
        if node in nodes:
            raise DataError(f"{where}: point {node} of mode {mode} is there twice; must be one subcase")
        nodes[node] = values

    def add_grid(self, grid: Grid) -> None:
        """Take coordinates."""
        self.grids[grid.node] = grid


def shapes(found: Nastran, units: UnitSystem) -> NodalModes:
    """Return the modes that have shapes.

    Raises
    ------
    DataError
        If there are none, without coordinates, for systems of coordinates other than the basic one, and for unstable
        modes.
    """
    if not found.vectors:
        raise DataError(f"{found.where}: holds no real eigenvectors (SOL 103 with VECTOR=ALL)")
    if not found.values:
        raise DataError(
            f"{found.where}: holds no table of real eigenvalues with generalised masses (LAMA); the .f06 has one"
        )
    moving = {node for nodes in found.vectors.values() for node in nodes}
    missing = sorted(moving - found.grids.keys())
    if missing:
        raise DataError(f"{found.where}: has no coordinates (GRID) of node {missing[0]}; {found.remedy}")
    grids = [found.grids[node] for node in sorted(moving)]
    turned = next((g for g in grids if g.system or g.output), None)
    if turned is not None:
        raise DataError(
            f"{found.where}: node {turned.node} has coordinates in system {turned.system} and motion in system "
            f"{turned.output}; must be the basic system, 0 (CP and CD of GRID)"
        )
    solid = not any(v[3:].any() for nodes in found.vectors.values() for v in nodes.values())  # prints 0 for no rotation
    modes = [
        RawMode(_frequency_hz(found, mode), found.values[mode][1],
                {n: v[:3] if solid else v for n, v in nodes.items()}, number=mode)
        for mode, nodes in sorted(found.vectors.items())
    ]  # fmt: skip
    return in_si(found.where, modes, {g.node: g.xyz for g in found.grids.values() if g.system == 0}, units)


def _frequency_hz(found: Nastran, mode: int) -> float:
    """Return the natural frequency of a mode; rounding may put a rigid one below 0."""
    if mode not in found.values:
        raise DataError(
            f"{found.where}: mode {mode} has a shape and no eigenvalue; has {len(found.values)} eigenvalues"
        )
    eigenvalue = found.values[mode][0]
    frequency_hz = float(np.sqrt(abs(eigenvalue)) / (2 * np.pi))
    if eigenvalue < 0 and frequency_hz > RIGID_HZ:
        raise DataError(f"{found.where}, mode {mode}: eigenvalue is {eigenvalue:g}; must be >= 0")
    return frequency_hz
