"""Names of columns of a results file: what a component has recorded."""

from __future__ import annotations

from collections.abc import Sequence
from fnmatch import fnmatchcase
from typing import Any

from fmus.interface import MODAL_VELOCITY

MODAL_VELOCITIES = f"wheel.{MODAL_VELOCITY}_*"
"""What is recorded unless something else is asked for: the sound of the wheel is made of these."""


def columns(component: str, variables: Sequence[Any]) -> list[str]:
    """Return the names of a component's modal velocities among the variables of a results file, in order.

    >>> columns("wheel", ["wheel.v_lat", "wheel.modal_velocity_001"])
    ['wheel.modal_velocity_001']
    """
    return sorted(str(name) for name in variables if fnmatchcase(str(name), f"{component}.{MODAL_VELOCITY}_*"))
