"""Checked connections, and the power bonds between wheel, rail and contact among them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from fmus.interface import CONTACT_DIRECTIONS, DIRECTIONS, DISPLACEMENT_DIRECTIONS, ENERGY_ADDED, STRUCTURES

from ..fmi.file import Fmu
from ..system.model import Wire
from ..system.tables import Lookup


@dataclass(frozen=True)
class Link:
    """A checked connection: end = gain * start + offset in the units of the FMUs, or what the lookup has for it."""

    wire: Wire
    gain: float
    offset: float
    lookup: Lookup | None = None


@dataclass(frozen=True)
class Bond:
    """A pair of a force on a structure and the velocity it works on, in one direction.

    Attributes
    ----------
    structure : wheel or rail: the side of the contact
    direction : lon, lat, ver or spin
    force : the link that brings the force to the structure
    velocity : the link that brings the structure's velocity to the contact
    way : the link that brings its displacement; None if there is none
    """

    structure: str
    direction: str
    force: Link
    velocity: Link
    way: Link | None

    @property
    def factors(self) -> tuple[float, float]:
        """Force times velocity in W, and force times displacement in J, per product in the structure's units."""
        way = 0.0 if self.way is None else self.way.gain
        return self.velocity.gain / self.force.gain, way / self.force.gain


def _bonds(links: tuple[Link, ...], contact: str | None) -> list[Bond]:
    """Return the power bonds between structures and the contact, by the contract's names at the contact."""
    if contact is None:
        return []
    out = {link.wire.start_connector: link for link in links if link.wire.start_element == contact}
    into = {link.wire.end_connector: link for link in links if link.wire.end_element == contact}
    return [
        Bond(s, d, out[f"{s}_f_{d}"], into[f"{s}_v_{d}"], into.get(f"{s}_u_{d}"))
        for s in STRUCTURES
        for d in DIRECTIONS
        if f"{s}_f_{d}" in out and f"{s}_v_{d}" in into
    ]


def integrated_sides(links: Iterable[Link], contact: str, fmu: Fmu, given: Collection[str]) -> tuple[str, ...]:
    """Return the sides whose velocities the contact is to integrate, for want of their displacements.

    A structure of the paper's contract exchanges velocities and forces alone. Its displacement inputs at the contact
    would stay 0, and the contact spring would see it rigid.

    Parameters
    ----------
    fmu : of the contact
    given : names of its parameters and inputs that have values of their own
    """
    fed = {link.wire.end_connector for link in links if link.wire.end_element == contact}
    moving = (s for s in STRUCTURES if any(f"{s}_v_{d}" in fed for d in DISPLACEMENT_DIRECTIONS))
    silent = (
        s for s in moving if not any(f"{s}_u_{d}" in fed or f"{s}_u_{d}" in given for d in DISPLACEMENT_DIRECTIONS)
    )
    names = {s: f"integrate_{s}" for s in silent}
    return tuple(s for s, name in names.items() if name in fmu.variables and name not in given)


def energy_account(contact: str | None, fmus: Mapping[str, Fmu]) -> dict[str, tuple[str, str]]:
    """Return where a contact tells what holding its forces added, by contact direction; empty if it does not."""
    names = {d: f"{ENERGY_ADDED}_{d}" for d in CONTACT_DIRECTIONS}
    if contact is None or not set(names.values()) <= fmus[contact].variables.keys():
        return {}
    return {d: (contact, name) for d, name in names.items()}


def sums(bonds: Iterable[tuple[str, str]], energies: Iterable[float], part: int) -> dict[str, float]:
    """Return energies of bonds (structure, direction) added up by structure (`part` 0) or by direction (1).

    >>> sums([("wheel", "lat"), ("rail", "lat")], [1.0, 2.0], 1)
    {'lat': 3.0}
    """
    found: dict[str, float] = {}
    for bond, energy in zip(bonds, energies, strict=True):
        found[bond[part]] = found.get(bond[part], 0.0) + float(energy)
    return found
