"""The sentence about an FMU that the loop stopped at: which component, in which call, when, and what it said itself."""

from __future__ import annotations

from ..fmi.instance import STATUS, FmuInstance
from .loop.data import GET, OUTSIDE, RESTORE, SAVE, SET, STEP, STOOD, TOO_LARGE

CALLS = {SET: "setting inputs", STEP: "doStep", GET: "getting outputs", SAVE: "getFMUstate", RESTORE: "setFMUstate"}


def fault_of(instance: FmuInstance, what: int, status: int, at: str) -> str:
    """Return the sentence; an instance that answered "fatal" is lost from now on.

    Parameters
    ----------
    what : what the loop was doing: a key of `CALLS`
    status : FMI status, or a sign of the loop in its place
    at : when, in words
    """
    if status == STOOD:
        return f"{instance.name}: doStep returned early {at} without getting on{instance.last_message()}"
    if status == OUTSIDE:
        return f"{instance.name}: {CALLS[what]} returned a status that FMI does not have {at}"
    if status == TOO_LARGE:
        return f"{instance.name}: an input does not hold the whole number that is connected to it, {at}"
    said = STATUS[status] if status < len(STATUS) else str(status)
    instance.lost = said == "fatal"
    return f"{instance.name}: {CALLS[what]} returned {said} {at}{instance.last_message()}"
