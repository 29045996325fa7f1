"""The cycles stage: an assembly in, the tones that it can have as limit cycles out. No time stepping."""

from __future__ import annotations

import numpy as np

from ...limit_cycles.catalogue import Cycle, find_cycles
from ...limit_cycles.level import Radiator
from ...limit_cycles.search import model_of
from ..prepared import Prepared
from ..rows import Number, Quantity

PLACES = 12
"""Cycles that a row has room for."""

QUANTITIES = (
    Quantity("cycles", "1", "number of limit cycles"),
    Quantity("stable_cycles", "1", "number of limit cycles that last"),
    Quantity("cycle_tone", "Hz", "frequency of the loudest limit cycle that lasts", lacks=True),
    Quantity("cycle_level", "dB", "its A-weighted sound pressure level", lacks=True),
    Quantity("cycle_lateral_rms", "m/s", "its lateral velocity of the wheel, rms", lacks=True),
    Quantity("cycle_frequency", "Hz", "frequencies of the limit cycles", PLACES, lacks=True),
    Quantity("cycle_lasts", "1", "whether each of them lasts: 1 or 0", PLACES, lacks=True),
)


def balanced(prepared: Prepared) -> dict[str, Number]:
    """Return the limit cycles of the system.

    Raises
    ------
    InputError
        If its linear behaviour is not known.
    """
    model = model_of(prepared.assembly, prepared.settings.step)
    found = find_cycles(model, radiator=Radiator.of(model.wheel)).cycles
    lasting = [c for c in found if c.stable]
    loudest = max(lasting, key=_lateral, default=None)
    places = np.full((2, PLACES), np.nan)
    for k, cycle in enumerate(found[:PLACES]):
        places[:, k] = cycle.frequency_hz, np.nan if cycle.stable is None else float(cycle.stable)
    level = np.nan if loudest is None or loudest.level_dba is None else loudest.level_dba
    return {
        "cycles": float(len(found)),
        "stable_cycles": float(len(lasting)),
        "cycle_tone": np.nan if loudest is None else loudest.frequency_hz,
        "cycle_level": level,
        "cycle_lateral_rms": np.nan if loudest is None else _lateral(loudest),
        "cycle_frequency": places[0],
        "cycle_lasts": places[1],
    }


def _lateral(cycle: Cycle) -> float:
    """Return the lateral velocity of the wheel, rms [m/s]."""
    return cycle.wheel_velocity_rms["lat"]


def may_squeal(values: dict[str, Number]) -> bool:
    """Return whether there is a tone that lasts."""
    return bool(values["stable_cycles"])
