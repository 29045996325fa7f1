"""Starts on one mode or on a limit cycle: a system and a frequency in, initial values of modes out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.interface import INITIAL_DISPLACEMENT, INITIAL_VELOCITY, PULSE_FORCE, STRUCTURES
from fmus.modal.parameters import moving_modes, names_of

from ..coupling.assembly import Assembly
from ..errors import InputError
from ..fmi.instance import Fmu, Value
from ..limit_cycles.measures import states_at_start
from ..limit_cycles.search import cycles_of
from ..stability.linear_model import component_names
from .scenario import Scenario

START_VELOCITY = 0.1
"""Lateral velocity of the contact point with which a chosen mode starts [m/s]: half of what sliding allows."""

_NEAR = 0.02


def mode_start(wheel: Fmu, parameters: Mapping[str, object], frequency_hz: float) -> dict[str, float]:
    """Return the initial velocity with which the wheel mode at a frequency moves the contact at `START_VELOCITY`.

    Of the modes within 2 % the one with the largest lateral amplitude.

    Raises
    ------
    InputError
        If no mode that moves the contact laterally is near.
    """

    def value(name: str) -> float:
        given = parameters.get(name, wheel.variables[name].start)
        return float(str(given))

    shown = wheel.names("parameter")
    frequency, shape, start = (names_of(block, shown) for block in ("frequency", "shape_lat", INITIAL_VELOCITY))
    if not frequency.keys() <= shape.keys() & start.keys() or not frequency:
        raise InputError(f"start-mode {frequency_hz:g}: the wheel shows no modes, so there is none to start on")
    lateral = {n: abs(value(shape[n])) for n in frequency}
    near = {n: a for n, a in lateral.items() if a > 0 and abs(value(frequency[n]) / frequency_hz - 1) < _NEAR}
    if not near:
        audible = sorted(value(frequency[n]) for n, a in lateral.items() if a > 0.3 * max(lateral.values()))
        raise InputError(
            f"start-mode {frequency_hz:g}: the wheel has no lateral mode within 2 % of {frequency_hz:g} Hz; "
            f"its strong ones are at {', '.join(f'{f:.0f}' for f in audible[:12])} Hz"
        )
    chosen = max(near, key=lambda n: near[n])
    return {start[chosen]: START_VELOCITY / near[chosen]}


def on_cycle(scenario: Scenario, frequency_hz: float) -> Scenario:
    """Return a scenario that starts on a limit cycle, without a pulse: a run from there has no growth to wait for.

    Of several cycles near the frequency the nearest; other initial values of the scenario are replaced.

    Raises
    ------
    InputError
        If there is no such cycle, or a structure does not let its modes be set.
    """
    if scenario.seed is not None:
        raise InputError(f"start on the cycle at {frequency_hz:g} Hz: seed = {scenario.seed} asks for another start")
    assembly, settings = scenario.prepare()
    found = cycles_of(assembly, settings.step, tone_hz=frequency_hz, with_stability=False)
    cycle = min(found.all_near(frequency_hz), key=lambda c: abs(c.frequency_hz - frequency_hz))
    values = {name: dict(own) for name, own in scenario.values.items()}
    for name, start in _cycle_values(assembly, states_at_start(cycle.motion)).items():
        values.setdefault(name, {}).update(start)
    return replace(scenario, values=values)


def _cycle_values(assembly: Assembly, states: NDArray[np.floating[Any]]) -> dict[str, dict[str, Value]]:
    """Return initial values of all modes; `states` are (n, 2), velocity and displacement, the wheel's first."""
    names = component_names(assembly)
    values: dict[str, dict[str, Value]] = {}
    begin = 0
    for structure in STRUCTURES:
        fmu, own = assembly.fmus[names[structure]], assembly.parameters[names[structure]]
        shown = {name: own.get(name, fmu.variables[name].start) for name in fmu.names("parameter")}
        moving = moving_modes(shown)
        velocity, displacement = (names_of(block, shown) for block in (INITIAL_VELOCITY, INITIAL_DISPLACEMENT))
        if not set(moving) <= velocity.keys() & displacement.keys() or not names_of("frequency", shown):
            raise InputError(
                f"{names[structure]}: has no {INITIAL_VELOCITY} and {INITIAL_DISPLACEMENT} of its modes, so it cannot "
                "start on a cycle"
            )
        start = values.setdefault(names[structure], {})
        for k, n in enumerate(moving, begin):
            start[velocity[n]], start[displacement[n]] = (float(x) for x in states[k])
        begin += len(moving)
    if PULSE_FORCE in assembly.fmus[names["contact"]].variables:
        values.setdefault(names["contact"], {})[PULSE_FORCE] = 0.0
    return values
