"""Starts on one mode: a wheel and a frequency in, the initial velocity of that mode out."""

from __future__ import annotations

from collections.abc import Mapping

from fmus.interface import INITIAL_VELOCITY
from fmus.modal.parameters import names_of

from ..errors import InputError
from ..fmi.instance import Fmu

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
