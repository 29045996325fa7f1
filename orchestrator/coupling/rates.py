"""How often a component steps: the step that the system gives it, if it does, against the communication step."""

from __future__ import annotations

from ..errors import InputError

_SAME = 1e-6
"""Relative difference of steps that is rounding of their decimals."""


def period(name: str, own: float | None, step: float) -> int:
    """Return how many communication steps one step of a component takes; 1 unless the system gives it a longer one.

    Parameters
    ----------
    name : of the component, for messages
    own : step that an annotation gives it [s]
    step : communication step [s]

    Raises
    ------
    InputError
        If its step is no whole multiple of the communication step.
    """
    if own is None:
        return 1
    count = round(own / step)
    if count >= 1 and abs(own / step - count) < _SAME * count:
        return count
    raise InputError(
        f"{name}: the system has it step by {own:g} s, no whole multiple of the communication step of {step:g} s"
    )


def is_multiple(step: float, inner: float) -> bool:
    """Return whether a step is a whole multiple of another."""
    count = round(step / inner)
    return count >= 1 and abs(step / inner - count) < _SAME * count
