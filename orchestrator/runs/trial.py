"""Structures tried by hand before a run: sentences about what would make its results worthless."""

from __future__ import annotations

import numpy as np

from fmus.interface import DIRECTIONS, DISPLACEMENT_DIRECTIONS

from ..coupling.assembly import Assembly
from ..coupling.bonds import Bond
from ..coupling.contact_mobility import as_in_contract, bonds_of, power_pairs
from ..coupling.settings import Settings
from ..errors import InputError
from ..probing.mobility import probed_mobility, published_mobility, with_step
from ..probing.rail import Signal, impulse_responses
from ..probing.rail_declaration import FAIL
from ..probing.structure_trial import Trial, first_fault, mobility_fault, published_verdict

LONGEST = 0.1
"""Impulse responses are followed for at most so long [s]; a fifth of it where each call goes to another process."""


def try_replaced(assembly: Assembly, settings: Settings) -> None:
    """Try the structures, each by itself.

    One that stands in another's place has to pass the rows of `check`; if it publishes its interface mobility in the
    contract's own names, or was there before, only its answer to one step of force is looked at.

    Raises
    ------
    InputError
        For a structure that answers late, against its force, far too much, not reciprocally, or that gives energy.
    """
    for name, element in assembly.system.elements.items():
        bonds = bonds_of(assembly, name)
        if not bonds:
            continue
        step = settings.step * assembly.periods(settings.step)[name]
        fault = _fault(assembly, name, bonds, step, settings.timeout)
        if fault is not None:
            file = assembly.fmus[name].path.name
            other = "mend it, map it with its units and signs, or skip this check"
            raise InputError(f"{name} ({file}): {fault}; {other if element.replaced else other.replace('map', 'wire')}")


def _fault(assembly: Assembly, name: str, bonds: dict[str, Bond], step: float, timeout: float | None) -> str | None:
    """Return the sentence about the first fault of a structure, or None."""
    fmu, replaced = assembly.fmus[name], assembly.system.elements[name].replaced
    parameters = with_step(fmu, assembly.parameters[name], step)
    published = published_mobility(fmu, parameters, timeout) if as_in_contract(bonds) else None
    if replaced and published is None:
        longest = LONGEST if timeout is None else 0.2 * LONGEST
        signals = _signals(assembly, name, bonds)
        responses = impulse_responses(fmu, signals, step, parameters, longest)
        return first_fault(Trial(fmu, signals, step, responses, parameters))
    if not replaced and published is not None:
        return None
    measured = probed_mobility(fmu, parameters, power_pairs(bonds), step, timeout)
    fault = mobility_fault(measured, step)
    if fault is None and published is not None:
        there = np.ix_(*[[d in bonds for d in DIRECTIONS]] * 2)
        status, said = published_verdict(published[there], measured[there])
        fault = said if status == FAIL else None
    return fault


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
