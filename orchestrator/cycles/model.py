"""The system as the cycles see it: modes of wheel and rail and the running contact law, in contact axes."""

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
from fmus.modal.modes import Modes

from ..errors import InputError
from ..stability.loop import linear_contact
from ..stability.poles import NORMAL, OpenSystem
from ..stability.scheme import ModalSystem

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
    wheel, rail : modes in track axes; a rail that does not move has none
    contact : values of the contact's parameters that differ from its start values
    """

    wheel: Modes
    rail: Modes
    contact: Mapping[str, float]

    @classmethod
    def of(cls, system: ModalSystem) -> SquealModel:
        """Return the model of a system whose modes and contact law are known."""
        return cls(system.wheel, system.rail, system.law)

    def __post_init__(self) -> None:
        """Check that every mode that the contact moves is held."""
        for name, modes in (("wheel", self.wheel), ("rail", self.rail)):
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
    def omega(self) -> Real:
        """Natural angular frequencies of wheel, then rail [rad/s]."""
        return np.concatenate([self.wheel.omega, self.rail.omega])

    @cached_property
    def zeta(self) -> Real:
        """Damping ratios of wheel, then rail [-]."""
        return np.concatenate([self.wheel.zeta, self.rail.zeta])

    @cached_property
    def shapes(self) -> Real:
        """Relative motion wheel minus rail per modal coordinate, (4, n), contact axes."""
        return OpenSystem.of(self.wheel, self.rail, self.linear.turn).R

    @cached_property
    def active(self) -> tuple[int, ...]:
        """Directions that a mode moves. In partial slip the law couples them all, lat to spin and spin to lon."""
        return tuple(int(a) for a in np.flatnonzero(self.shapes.any(axis=1)))

    @cached_property
    def _pairs(self) -> Real:
        """Products of the motions of each mode in two directions that move, (n, d * d)."""
        shapes = self.shapes[list(self.active)]
        return np.asarray((shapes[:, None] * shapes[None]).reshape(-1, self.omega.size).T.copy())

    def response(self, s: Complex) -> tuple[Complex, Complex]:
        """Return relative motion per contact force at complex frequencies, and its derivative by s, (m, d, d).

        Velocities in lon, lat and spin, displacement in the normal direction; only directions that move.
        """
        d = len(self.active)
        damping = 2 * self.zeta * self.omega
        g = 1.0 / (self.omega**2 + s[:, None] * (damping + s[:, None]))
        both = np.concatenate([g, -(damping + 2 * s[:, None]) * g * g])
        receptance, slope = (both.real @ self._pairs + 1j * (both.imag @ self._pairs)).reshape(2, -1, d, d)
        moving = np.array([a != NORMAL for a in self.active])
        factor = np.where(moving, s[:, None], 1.0)[:, :, None]
        return factor * receptance, factor * slope + np.where(moving, 1.0, 0.0)[None, :, None] * receptance
