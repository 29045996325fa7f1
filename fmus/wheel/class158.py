"""The wheelset of the paper's cases: amplitudes identified from Table 4, the rest from the finite elements.

`data/class158.toml` holds the modes, `data/class158-identification.toml` how they were found. Both are written by
`python -m orchestrator.identification`; nodal diameters and radiating areas are those of the generic wheelset's table,
whose modes these are.
"""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

from ..errors import DataError
from ..modal.data import read_modal_data
from .wheelset import DATA, Wheelset, read_wheelset

MODES = DATA / "class158.toml"
IDENTIFICATION = DATA / "class158-identification.toml"
PRIOR = DATA / "generic840.toml"


def class158() -> Wheelset:
    """Return the Class 158 wheelset.

    Raises
    ------
    DataError
        If the generic wheelset has other modes than when the amplitudes were identified.
    """
    return on_finite_elements(MODES, PRIOR)


def on_finite_elements(modes: Path, wheelset: Path) -> Wheelset:
    """Return a modal data file with the nodal diameters and radiating areas of the finite elements it was made from.

    Raises
    ------
    DataError
        If the finite elements have other modes.
    """
    prior, data = read_wheelset(wheelset), read_modal_data(modes)
    if prior.modes.labels != data.modes.labels:
        raise DataError(f"{modes.name}: its modes are not those of {wheelset.name}; identify the amplitudes anew")
    return replace(prior, modes=data.modes, title=data.title)


def identified_stiffness() -> float:
    """Return the stiffness of the contact spring that goes with the identified amplitudes [N/m]."""
    settings = tomllib.loads(IDENTIFICATION.read_text(encoding="utf-8"))
    return float(settings["hertz_stiffness"]["value"])
