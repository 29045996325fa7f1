"""Normal modes as programs write them: values, modal mass and units in, `NodalModes` in SI out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...errors import DataError
from ..function import Real
from ..units import UnitSystem
from .nodal import NodalModes


@dataclass(frozen=True)
class RawMode:
    """A normal mode as a file has it.

    Attributes
    ----------
    frequency_hz : natural frequency [Hz]
    mass : modal mass of `values`, in the file's unit
    values : (3,) translations, or (6,) with rotations, by number of the node
    damping_ratio : nan where the file has none
    number : of the mode in the file; None: its place
    where : data set or line of the file, '' where the number says enough
    """

    frequency_hz: float
    mass: float
    values: Mapping[int, Real]
    damping_ratio: float = np.nan
    number: int | None = None
    where: str = ""


def in_si(where: str, modes: Sequence[RawMode], position: Mapping[int, Real], units: UnitSystem) -> NodalModes:
    """Return modes over the nodes of the first, mass-normalised.

    Parameters
    ----------
    where : file, for messages
    position : coordinates by number of the node, in the file's unit
    """
    nodes = sorted(modes[0].values)
    for i, mode in enumerate(modes, start=1):
        place = mode.where or f"{where}, mode {mode.number or i}"
        if sorted(mode.values) != nodes:
            raise DataError(f"{place}: has other nodes than the first mode; must be the same")
        if not 0 < mode.mass < np.inf:
            raise DataError(f"{place}: modal mass is {mode.mass:g}; must be > 0")
    kilograms = units.length / units.force
    size = max(values.size for mode in modes for values in mode.values.values())
    shape = np.full((len(modes), len(nodes), size), np.nan)
    for i, mode in enumerate(modes):
        for k, node in enumerate(nodes):
            values = mode.values[node] / np.sqrt(mode.mass * kilograms)
            shape[i, k, : values.size] = values
    shape[:, :, 3:] *= units.length  # rotations are per length
    return NodalModes(
        where=where,
        frequency_hz=np.array([mode.frequency_hz for mode in modes]),
        damping_ratio=np.array([mode.damping_ratio for mode in modes]),
        nodes=np.array(nodes, dtype=np.int64),
        shape=shape,
        position={node: xyz / units.length for node, xyz in position.items()},
        labels=tuple(f"mode {mode.number or i}" for i, mode in enumerate(modes, start=1)),
    )


def needed(where: str, units: UnitSystem | None) -> UnitSystem:
    """Return the units, where a file says none itself."""
    if units is None:
        raise DataError(f"{where}: does not say its units; give them with the option units, such as m,N or mm,N")
    return units
