"""What stands in another's place: directions in which a replaced structure is rigid. No calls."""

from __future__ import annotations

from collections.abc import Mapping

from fmus.interface import DIRECTIONS, STRUCTURES

from ..fmi.instance import Fmu
from ..system.model import System, Wire


def without_rigid(system: System, fmus: Mapping[str, Fmu]) -> tuple[tuple[Wire, ...], tuple[str, ...]]:
    """Return the connections without those of directions that a replaced structure does not have, and who says so.

    A direction is missing if the FMU has neither the force nor the motions that the system connects to the contact in
    it, while it has others: the structure is rigid there. One that is there in part is left to be refused.
    """
    dropped: set[Wire] = set()
    notices = []
    for name, element in system.elements.items():
        if not element.replaced:
            continue
        of = _by_direction(name, system.wires)
        missing = {d: w for d, w in of.items() if not any(c in fmus[name].variables for c in w.values())}
        if missing and len(missing) < len(of):
            dropped.update(*(wires for wires in missing.values()))
            notices.append(f"{name} ({fmus[name].path.name}) has nothing in {', '.join(missing)}: it is rigid there")
    return tuple(w for w in system.wires if w not in dropped), tuple(notices)


def _by_direction(name: str, wires: tuple[Wire, ...]) -> dict[str, dict[Wire, str]]:
    """Return the connections of a structure to a contact with its connectors, by direction."""
    found: dict[str, dict[Wire, str]] = {}
    for wire in wires:
        for d in DIRECTIONS:
            if wire.start_element == name and wire.end_connector in {f"{s}_{k}_{d}" for s in STRUCTURES for k in "vu"}:
                found.setdefault(d, {})[wire] = wire.start_connector
            if wire.end_element == name and wire.start_connector in {f"{s}_f_{d}" for s in STRUCTURES}:
                found.setdefault(d, {})[wire] = wire.end_connector
    return found
