"""Names of columns of a results file: what is recorded of a component, and how a pattern chooses it."""

from __future__ import annotations

from fnmatch import fnmatchcase

from fmus.interface import MODAL_VELOCITY

MODAL_VELOCITIES = f"wheel.{MODAL_VELOCITY}*"
"""What is recorded unless something else is asked for, in either spelling: the sound of the wheel is made of these."""


def matches(name: str, pattern: str) -> bool:
    """Return whether a name is the one that is asked for, or fits the pattern.

    >>> matches("rail.v_lat", "rail.*"), matches("rail.modal_velocity[1]", "rail.modal_velocity[1]")
    (True, True)
    """
    return name == pattern or fnmatchcase(name, pattern)
