"""Checked connections, and the power bonds between wheel, rail and contact among them."""

from __future__ import annotations

from dataclasses import dataclass

from fmus.interface import DIRECTIONS, STRUCTURES

from ..system.model import Wire


@dataclass(frozen=True)
class Link:
    """A checked connection of two real variables: end = gain * start + offset in the units of the FMUs."""

    wire: Wire
    gain: float
    offset: float


@dataclass(frozen=True)
class Bond:
    """A pair of a force on a structure and the velocity it works on, in one direction.

    Attributes
    ----------
    direction : lon, lat, ver or spin
    force : the link that brings the force to the structure
    velocity : the link that brings the structure's velocity to the contact
    """

    direction: str
    force: Link
    velocity: Link


def _bonds(links: tuple[Link, ...], contact: str | None) -> list[Bond]:
    """Return the power bonds between structures and the contact, by the contract's names at the contact."""
    if contact is None:
        return []
    out = {link.wire.start_connector: link for link in links if link.wire.start_element == contact}
    into = {link.wire.end_connector: link for link in links if link.wire.end_element == contact}
    return [
        Bond(d, out[f"{s}_f_{d}"], into[f"{s}_v_{d}"])
        for s in STRUCTURES
        for d in DIRECTIONS
        if f"{s}_f_{d}" in out and f"{s}_v_{d}" in into
    ]
