"""The linear stage: an assembly in, growth rates of the coupled system out. No FMU is called."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...stability.analysis import REPORTED_BELOW_HZ
from ...stability.linear_model import model_of_assembly
from ...stability.poles import Poles, Structure
from ..prepared import Prepared, structure_key
from ..rows import Number, Quantity

MOST_KEPT = 100
"""Structures that a process keeps."""

PLACES = 12
"""Unstable poles that a row has room for."""

QUANTITIES = (
    Quantity("growth_rate", "s-1", "largest growth rate of the coupled linear system"),
    Quantity("growth_frequency", "Hz", "frequency of the pole with the largest growth rate"),
    Quantity("unstable_modes", "1", f"number of unstable poles below {REPORTED_BELOW_HZ:g} Hz"),
    Quantity("unstable_frequency", "Hz", "frequencies of the unstable poles, fastest first", PLACES, lacks=True),
    Quantity("unstable_growth_rate", "s-1", "growth rates of the unstable poles, fastest first", PLACES, lacks=True),
)


def linear(prepared: Prepared) -> dict[str, Number]:
    """Return growth rates and frequencies of the system linearised at its steady state.

    Raises
    ------
    InputError
        If its linear behaviour is not known.
    """
    assembly, kept = prepared.assembly, prepared.workshop

    def remember(name: str, find: Callable[[], Structure]) -> Structure:
        key = structure_key(assembly.fmus[name], assembly.parameters[name])
        if key not in kept.structures:
            if len(kept.structures) >= MOST_KEPT:
                kept.structures.clear()
            kept.structures[key] = find()
        return kept.structures[key]

    model = model_of_assembly(assembly, prepared.settings.step, remember)
    if model.identified:
        return described(model.poles)
    return described(kept.poles.poles(*model.modal(), model.contact))


def described(poles: Poles) -> dict[str, Number]:
    """Return the quantities of poles."""
    fastest = int(poles.growth_rate.argmax())
    unstable = poles.unstable()
    order = np.argsort(-unstable.growth_rate)[:PLACES]
    places = np.full((2, PLACES), np.nan)
    places[0, : order.size] = unstable.frequency_hz[order]
    places[1, : order.size] = unstable.growth_rate[order]
    return {
        "growth_rate": float(poles.growth_rate[fastest]),
        "growth_frequency": float(poles.frequency_hz[fastest]),
        "unstable_modes": float(unstable.below(REPORTED_BELOW_HZ).growth_rate.size),
        "unstable_frequency": places[0],
        "unstable_growth_rate": places[1],
    }


def is_unstable(values: dict[str, Number]) -> bool:
    """Return whether anything grows."""
    return float(values["growth_rate"]) > 0
