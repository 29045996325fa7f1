"""The linear model that a run belongs to: a results file in, modes of wheel and rail and the linearised contact out."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.contact.linearised import LinearContact
from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes

from .analysis import REPORTED_BELOW_HZ
from .eigenloci import Crossing, Eigenloci, crossings, eigenloci, frequency_grid
from .loop import Loop, linear_contact, of_modes, remembered
from .poles import Poles, closed_loop_poles

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

_BLOCKS = ("frequency", "damping_ratio", *(f"shape_{d}" for d in DIRECTIONS))


@dataclass(frozen=True)
class RunModel:
    """Wheel, rail and contact of a run, linearised.

    Attributes
    ----------
    wheel, rail : modes in track axes; a rail that does not move has none
    contact : linearised about the steady state
    """

    wheel: Modes
    rail: Modes
    contact: LinearContact

    def poles(self) -> Poles:
        """Return the poles of the coupled system."""
        return closed_loop_poles(self.wheel, self.rail, self.contact)

    def open_loop(self) -> tuple[Eigenloci, tuple[Crossing, ...]]:
        """Return the eigenloci of the open loop and where they cross the positive real axis beyond +1."""
        loop = Loop(remembered(of_modes(self.wheel)), remembered(of_modes(self.rail)), self.contact)
        loci = eigenloci(loop.open_loop, frequency_grid(self.wheel.omega / (2 * np.pi), self.wheel.zeta))
        return loci, crossings(loop.open_loop, loci)

    def loop_gains(self) -> dict[float, float]:
        """Return the loop gains of the instabilities by frequency [Hz], below what the paper reports."""
        _, found = self.open_loop()
        return {c.frequency_hz: c.gain for c in found if c.frequency_hz < REPORTED_BELOW_HZ}


def model_of(data: xr.Dataset) -> RunModel | None:
    """Return the linear model of a run; None if its components do not tell modes and contact as ours do."""
    values: Mapping[str, Mapping[str, Any]] = json.loads(data.attrs.get("all_parameters", "{}"))
    wheel, rail = (modes_of(values.get(name)) for name in ("wheel", "rail"))
    contact = _contact(values.get("contact", {}))
    if wheel is None or rail is None or contact is None:
        return None
    return RunModel(wheel, rail, contact)


def modes_of(values: Mapping[str, Any] | None) -> Modes | None:
    """Return the modes among the parameters of a structure; None if it is not modal.

    A structure with the step size as its only parameter has no modes and does not move.
    """
    if not values:
        return None
    numbers = sorted(name.removeprefix("frequency_") for name in values if name.startswith("frequency_"))
    try:
        table = np.array([[float(values[f"{block}_{n}"]) for n in numbers] for block in _BLOCKS])
    except (KeyError, TypeError, ValueError):
        return None
    if not numbers and set(values) != {"step_size"}:
        return None
    return Modes(2 * np.pi * table[0], table[1], table[2:].T.copy())


def _contact(values: Mapping[str, Any]) -> LinearContact | None:
    """Return the linearised contact of parameters; None if they are not those of our contact."""
    known = {name: value for name, value in values.items() if not name.startswith("mobility_")}
    if not known or any(not isinstance(value, float) for value in known.values()):
        return None
    try:
        return linear_contact(known)
    except ValueError:
        return None
