"""How often a component steps: its own step, if it insists on one, against the communication step."""

from __future__ import annotations

from ..errors import InputError
from ..fmi.file import Fmu

_SAME = 1e-6
"""Relative difference of steps that is rounding of their decimals."""


def period(fmu: Fmu, step: float) -> int:
    """Return how many communication steps one step of an FMU takes; 1 for an FMU that takes any step.

    Raises
    ------
    InputError
        If the FMU insists on a step that is neither a whole multiple of the communication step nor a whole part of it.
    """
    own = fmu.own_step
    if own is None:
        return 1
    for large, small, found in ((own, step, round(own / step)), (step, own, 1)):
        if large >= small * (1 - _SAME) and abs(large / small - round(large / small)) < _SAME * large / small:
            return found
    raise InputError(
        f"{fmu.path.name} steps by {own:g} s and no other way; the communication step of {step:g} s is neither a whole "
        "part nor a whole multiple of it"
    )
