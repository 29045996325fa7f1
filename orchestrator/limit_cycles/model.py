"""The system as the cycles see it: linear wheel and rail and the running contact law, in contact axes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.linearised import LinearContact
from fmus.contact.parameters import WITH_MEMORY
from fmus.modal.modes import Modes

from ..errors import InputError
from ..stability.linear_model import LinearModel
from ..stability.loop import linear_contact
from ..stability.poles import NORMAL, Structure
from .parts import Part

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

LON, LAT, SPIN = 0, 1, 3
"""Directions in contact axes, beside `NORMAL`, 2."""

SPIN_ARM = 0.007
"""Turns a spin velocity into a velocity at the edge of the contact patch [m]."""


@dataclass(frozen=True)
class SquealModel:
    """Wheel, rail and contact.

    Attributes
    ----------
    wheel, rail : in track axes: modes, or what was identified of a structure that shows none
    contact : values of the contact's parameters that differ from its start values
    """

    wheel: Structure
    rail: Structure
    contact: Mapping[str, float]

    @classmethod
    def of(cls, linear: LinearModel) -> SquealModel:
        """Return the model of a system whose structures and contact law are known."""
        return cls(linear.wheel, linear.rail, linear.law)

    def __post_init__(self) -> None:
        """Check that every mode that the contact moves is held, and that the contact has no memory."""
        if self.contact.get("creep_law") == WITH_MEMORY:
            raise InputError("contact: creep_law = 2: cycles are those of a steady law, 0 or 1; run the system instead")
        for name, modes in (("wheel", self.wheel), ("rail", self.rail)):
            if isinstance(modes, Modes):
                free = np.flatnonzero((modes.omega == 0) & modes.shape.any(axis=1))
                if free.size:
                    raise InputError(f"{name}: mode {free[0] + 1} has the frequency 0, so there is no steady state")

    @cached_property
    def instance(self) -> Instance:
        """The running contact, initialised: parameters and derived quantities for its kernels."""
        instance = Instance(contact(), self.contact)
        instance.initialise()
        return instance

    @cached_property
    def linear(self) -> LinearContact:
        """The contact linearised at its steady state."""
        return linear_contact(self.contact)

    @cached_property
    def turn(self) -> Real:
        """(4, 4) rotation from track to contact axes."""
        place = self.instance.component.parameter_index["contact_angle"]
        return LinearContact(np.zeros((3, 3)), np.zeros(3), 0.0, float(self.instance.parameters[place])).turn

    @cached_property
    def parts(self) -> tuple[Part, Part]:
        """Wheel and rail in track axes."""
        return Part.of(self.wheel), Part.of(self.rail)

    @cached_property
    def whole(self) -> Part:
        """Relative motion wheel minus rail per contact force on the wheel, contact axes."""
        wheel, rail = self.parts
        return wheel.beside(rail.mirrored()).turned(self.turn)

    @cached_property
    def active(self) -> tuple[int, ...]:
        """Directions that move. In partial slip the law couples them all, lat to spin and spin to lon."""
        return tuple(int(a) for a in np.flatnonzero(self.whole.displace.any(axis=(1, 2))))

    @cached_property
    def _seen(self) -> Part:
        return self.whole.only(self.active)

    def response(self, s: Complex) -> tuple[Complex, Complex]:
        """Return relative motion per contact force at complex frequencies, and its derivative by s, (m, d, d).

        Velocities in lon, lat and spin, displacement in the normal direction; only directions that move.
        """
        receptance, slope = self._seen.receptance(s)
        moving = np.array([a != NORMAL for a in self.active])
        factor = np.where(moving, s[:, None], 1.0)[:, :, None]
        return factor * receptance, factor * slope + np.where(moving, 1.0, 0.0)[None, :, None] * receptance
