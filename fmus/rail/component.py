"""The rail components: modal data in, components that obey the contract out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..component import Component
from ..modal.component import structure
from ..modal.data import read_modal_data
from ..modal.modes import Modes

DATA = Path(__file__).parent / "data"


def rail(modes: Modes | None = None) -> Component:
    """Return the rail component, by default the accurate modal rail of the default track."""
    chosen = read_modal_data(DATA / "rail.toml").modes if modes is None else modes
    return structure("rail", "Rail at the contact point: modal, four directions", chosen)


def paper_rail() -> Component:
    """Return the modal rail by the paper's method: cut-on frequencies and one extra mode at 20 kHz."""
    modes = read_modal_data(DATA / "rail-paper.toml").modes
    return structure("rail_paper", "Rail at the contact point: modal by the paper's method", modes)


def discrete_rail() -> Component:
    """Return the modal rail of the default track on discrete sleepers, at mid-span."""
    modes = read_modal_data(DATA / "rail-discrete.toml").modes
    return structure("rail_discrete", "Rail at the contact point: discrete sleepers, contact at mid-span", modes)


def rigid_rail() -> Component:
    """Return the rail that does not move: the same contract with one mode of no shape, so no velocity and no mobility.

    The one mode is there to be seen: a structure that shows no modes may be any, one that shows this cannot move.
    """
    none = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))
    return structure("rail_rigid", "Rigid rail: obeys the rail's contract and does not move", none, capacity=1)
