"""Replaced structures tried by hand before a run: sentences about what would make its results worthless."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS, DISPLACEMENT_DIRECTIONS

from ..coupling.assembly import Assembly
from ..coupling.bonds import Bond
from ..coupling.contact_mobility import power_pairs
from ..coupling.settings import Settings
from ..errors import InputError
from ..probing.mobility import published_mobility, with_step
from ..probing.rail import Signal, impulse_responses
from ..probing.rail_passivity import estimate_mobility, find_activity, find_growth, find_lateness

LONGEST = 0.1
"""Impulse responses are followed for at most so long [s]; a fifth of it where each call goes to another process."""

LIGHTEST = 0.03
"""Mass that no wheel or rail is lighter than at the contact within one step [kg]; theirs are 1 to 10 kg."""

RECIPROCAL = 1e-3
"""Deviation from symmetry that passes, relative to the point mobilities."""


def try_replaced(assembly: Assembly, settings: Settings) -> None:
    """Try the structures that stand in another's place, each by itself.

    One that publishes its interface mobility in the contract's own names is not tried.

    Raises
    ------
    InputError
        For a structure that answers late, against its force, far too much, not reciprocally, or that gives energy.
    """
    for name, element in assembly.system.elements.items():
        bonds = {b.direction: b for b in assembly.bonds if b.force.wire.end_element == name}
        if not element.replaced or not bonds:
            continue
        step = settings.step * assembly.periods(settings.step)[name]
        fault = _fault(assembly, name, bonds, step, settings.timeout)
        if fault is not None:
            file = assembly.fmus[name].path.name
            raise InputError(f"{name} ({file}): {fault}; mend it, map it with its units and signs, or skip this check")


def _fault(assembly: Assembly, name: str, bonds: dict[str, Bond], step: float, timeout: float | None) -> str | None:
    """Return the sentence about the first fault of a structure, or None."""
    fmu, parameters = assembly.fmus[name], assembly.parameters[name]
    if published_mobility(fmu, with_step(fmu, parameters, step), timeout) is not None:
        return None
    longest = LONGEST if timeout is None else 0.2 * LONGEST
    responses = impulse_responses(fmu, _signals(assembly, name, bonds), step, parameters, longest)
    first = responses.velocity[0]
    late = find_lateness(responses)
    if late is not None:
        return late
    for fault in _mobility_faults(first, step):
        return fault
    growth = find_growth(responses)
    if growth is not None:
        return f"active: {growth}"
    active = find_activity(estimate_mobility(responses), step)
    return None if active is None else f"active: {active}"


def _signals(assembly: Assembly, name: str, bonds: dict[str, Bond]) -> dict[str, Signal]:
    """Return the structure's variables by the contract's names, with factors to the contact's units and signs."""
    signals = {}
    for d, pair in power_pairs(bonds).items():
        signals[f"f_{d}"] = Signal(pair.force, 1 / pair.force_gain)
        signals[f"v_{d}"] = Signal(pair.velocity, pair.velocity_gain)
    for link in assembly.links:
        kind, _, d = link.wire.end_connector.partition("_")[2].partition("_")
        if link.wire.start_element == name and kind == "u" and d in DISPLACEMENT_DIRECTIONS and d in bonds:
            signals[f"u_{d}"] = Signal(link.wire.start_connector, link.gain)
    return signals


def _mobility_faults(first: NDArray[np.float64], step: float) -> Iterator[str]:
    """Yield faults of the interface mobility: velocity after one step per force held over it."""
    own = np.diag(first)
    for j, d in enumerate(DIRECTIONS):
        if own[j] < 0:
            yield f"wrong sign: a {d} force moves it the other way, {own[j]:.3g} m/s per newton after a step"
        if d != "spin" and own[j] > step / LIGHTEST:
            yield (
                f"wrong units: a {d} force of 1 N moves it by {own[j]:.3g} m/s in a step, as if it had a mass of "
                f"{step / own[j]:.1g} kg"
            )
    scale = np.sqrt(np.outer(np.where(own > 0, own, 1.0), np.where(own > 0, own, 1.0)))
    off = np.abs(first - first.T) / scale
    j, k = (int(i) for i in np.unravel_index(int(np.argmax(off)), off.shape))
    if off[j, k] > RECIPROCAL:
        yield (
            f"not reciprocal: {DIRECTIONS[j]} per {DIRECTIONS[k]} is {first[j, k]:.3g} after a step, its transpose "
            f"{first[k, j]:.3g}"
        )
