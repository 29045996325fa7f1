"""The wheel component: the modes of a wheelset with room for as many as the default has."""

from __future__ import annotations

from ..component import Component
from ..modal.component import structure
from ..modal.modes import Modes
from .class158 import class158


def wheel(modes: Modes | None = None) -> Component:
    """Return the wheel component, by default the one of the paper's cases, `class158`."""
    chosen = class158().modes if modes is None else modes
    return structure("wheel", "Railway wheelset at the contact point: modal, four directions", chosen)
