"""The rail components: modal data in, components that obey the contract out."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..component import Component
from ..modal.component import structure
from ..modal.data import read_modal_data
from ..modal.modes import Modes

DATA = Path(__file__).parent / "data"


@dataclass(frozen=True)
class ShippedRail:
    """A rail that is built with the others; its modes are in `data`, under its name.

    Attributes
    ----------
    about : description of its FMU
    method : how its modes are made of the default track, a name of `shipped.METHODS`
    """

    about: str
    method: str


SHIPPED = {
    "rail": ShippedRail("Rail at the contact point: modal, four directions", "accurate"),
    "rail-paper": ShippedRail("Rail at the contact point: modal by the paper's method", "paper"),
    "rail-discrete": ShippedRail("Rail at the contact point: discrete sleepers, contact at mid-span", "discrete"),
}
"""The rails that are shipped, by the name of their data and FMU files; one more is a row here and a data file."""


def shipped_rail(name: str) -> Component:
    """Return a rail of `SHIPPED`."""
    modes = read_modal_data(DATA / f"{name}.toml").modes
    return structure(name.replace("-", "_"), SHIPPED[name].about, modes)


def rail(modes: Modes | None = None) -> Component:
    """Return the rail component, by default the accurate modal rail of the default track."""
    return shipped_rail("rail") if modes is None else structure("rail", SHIPPED["rail"].about, modes)


def rigid_rail() -> Component:
    """Return the rail that does not move: the same contract with one mode of no shape, so no velocity and no mobility.

    The one mode is there to be seen: a structure that shows no modes may be any, one that shows this cannot move.
    """
    none = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))
    return structure("rail_rigid", "Rigid rail: obeys the rail's contract and does not move", none, capacity=1)
