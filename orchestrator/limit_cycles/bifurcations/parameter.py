"""A parameter that a diagram is drawn against: its name in, the model at each of its values out."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fmus.contact.parameters import PARAMETERS
from fmus.modal.modes import Modes

from ...errors import InputError
from ..model import SquealModel

FACTOR = "damping_factor"
"""Name of the factor on all damping ratios of a structure."""


@dataclass(frozen=True)
class Parameter:
    """A number of the model that may be moved.

    Attributes
    ----------
    name : as the user gave it
    start : its value in the model
    low, high : range in which the model can be made
    at : the model at a value
    unit : as it is written beside an axis
    """

    name: str
    start: float
    low: float
    high: float
    at: Callable[[float], SquealModel]
    unit: str = "1"


def find_parameter(model: SquealModel, name: str) -> Parameter:
    """Return a parameter: contact.mu0, any other number of the contact, wheel.damping_ratio_012, wheel.damping_factor.

    Raises
    ------
    InputError
        If there is none of that name.
    """
    component, _, own = name.partition(".")
    if component == "contact":
        return _of_contact(model, name, own)
    structure = getattr(model, component) if component in ("wheel", "rail") else None
    if isinstance(structure, Modes):
        return _of_damping(model, name, component, structure)
    raise InputError(f"{name}: is no parameter of contact, wheel or rail that a diagram can be drawn against")


def _of_contact(model: SquealModel, name: str, own: str) -> Parameter:
    """Return a parameter of the contact."""
    declared = {v.name: v for v in PARAMETERS if v.kind == "Real" and not v.name.startswith(("mobility", "pulse"))}
    if own not in declared:
        raise InputError(f"{name}: the contact has no such number; it has {', '.join(sorted(declared))}")
    variable = declared[own]
    start = float(model.instance.parameters[model.instance.component.parameter_index[own]])

    def at(value: float) -> SquealModel:
        return replace(model, contact={**model.contact, own: float(np.clip(value, variable.minimum, variable.maximum))})

    return Parameter(name, start, variable.minimum, variable.maximum, at, variable.unit)


def _of_damping(model: SquealModel, name: str, component: str, modes: Modes) -> Parameter:
    """Return the damping ratio of a mode, or a factor on those of all."""
    own = name.partition(".")[2]
    numbered = re.fullmatch(r"damping_ratio_(\d+)", own)
    if own != FACTOR and (numbered is None or not 0 < int(numbered[1]) <= len(modes)):
        raise InputError(f"{name}: must be {component}.{FACTOR} or {component}.damping_ratio_001 to _{len(modes):03d}")

    def at(value: float) -> SquealModel:
        zeta = modes.zeta.copy()
        if numbered is None:
            zeta *= max(value, 1e-6)
        else:
            zeta[int(numbered[1]) - 1] = max(value, 0.0)
        moved = replace(modes, zeta=zeta)
        return replace(model, wheel=moved) if component == "wheel" else replace(model, rail=moved)

    start = 1.0 if numbered is None else float(modes.zeta[int(numbered[1]) - 1])
    return Parameter(name, start, 1e-6 if numbered is None else 0.0, 1e3, at)
