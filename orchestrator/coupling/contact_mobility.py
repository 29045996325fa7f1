"""Interface mobilities: what the structures publish, or what a scratch instance shows, for the implicit contact."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS, PAIRS

from ..fmi.instance import Value
from ..probing.mobility import PowerPair, probed_mobility, published_mobility, with_step
from .assembly import Assembly
from .bonds import Bond

Matrix = NDArray[np.float64]


def contact_mobility(assembly: Assembly, step: float, timeout: float | None = None) -> dict[str, Value]:
    """Return the mobility parameters of the contact: the sum over the structures at its bonds, or nothing.

    Parameters
    ----------
    assembly : the system
    step : communication step that the mobilities are for [s]
    timeout : for scratch instances in processes of their own, see `FmuInstance`
    """
    if assembly.contact is None:
        return {}
    total = np.zeros((4, 4))
    structures = {bond.force.wire.end_element for bond in assembly.bonds}
    for name in sorted(structures):
        bonds = bonds_of(assembly, name)
        fmu = assembly.fmus[name]
        own_step = step * assembly.periods(step)[name]
        parameters = with_step(fmu, assembly.parameters[name], own_step)
        published = published_mobility(fmu, parameters, timeout) if as_in_contract(bonds) else None
        if published is None:
            published = probed_mobility(fmu, parameters, power_pairs(bonds), own_step, timeout)
        total += published
    index = {d: i for i, d in enumerate(DIRECTIONS)}
    return {f"mobility_{row}_{column}": float(total[index[row], index[column]]) for row, column in PAIRS}


def bonds_of(assembly: Assembly, name: str) -> dict[str, Bond]:
    """Return the power bonds of a structure by direction."""
    return {b.direction: b for b in assembly.bonds if b.force.wire.end_element == name}


def power_pairs(bonds: Mapping[str, Bond]) -> dict[str, PowerPair]:
    """Return the variables of a structure at its bonds, by direction."""
    return {
        d: PowerPair(
            b.force.wire.end_connector, b.velocity.wire.start_connector,
            b.force.gain, b.force.offset, b.velocity.gain,
        )
        for d, b in bonds.items()
    }  # fmt: skip


def as_in_contract(bonds: Mapping[str, Bond]) -> bool:
    """Return whether the structure has the contract's own names and units at its bonds."""
    return all(
        bond.force.wire.end_connector == f"f_{d}"
        and bond.velocity.wire.start_connector == f"v_{d}"
        and (bond.force.gain, bond.velocity.gain) == (1.0, 1.0)
        for d, bond in bonds.items()
    )
