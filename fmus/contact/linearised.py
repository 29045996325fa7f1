"""The contact linearised about its steady state: parameters in, H1, h2 and the spring stiffness out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..component import Instance
from ..errors import DataError
from .component import contact
from .friction.coefficient import friction_coefficient
from .law import creep_forces, normal_force
from .parameters import WITH_MEMORY, P

Real = NDArray[np.float64]

STEP = 1e-6
"""Step of the central differences: creepage [-], spin times semi-axis [-], and relative to load and compression."""

SLIDES = 1e-3
"""A contact slides as a whole if its force is below the friction force by less than this part."""


@dataclass(frozen=True)
class LinearContact:
    """The contact at small fluctuations, in contact axes; forces act on the wheel.

    Attributes
    ----------
    H1 : (3, 3) d(lon, lat, spin force)/d(lon, lat, spin relative velocity)
    h2 : (3,) d(lon, lat, spin force)/d(normal force)
    stiffness : of the contact spring [N/m]
    angle : contact angle [rad]
    """

    H1: Real
    h2: Real
    stiffness: float
    angle: float

    @property
    def turn(self) -> Real:
        """(4, 4) rotation from track axes (lon, lat, ver, spin) to contact axes (lon, lat, normal, spin)."""
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1.0]])


def linearise(parameters: Mapping[str, float] | None = None) -> LinearContact:
    """Return the contact linearised at its steady creepages and load, by differentiating the running law.

    Parameters
    ----------
    parameters : parameters of the contact that differ from the start values

    Raises
    ------
    DataError
        For a contact with memory that sticks in part: its slopes depend on the frequency. Where all slides they are
        those of the steady law.
    """
    instance = Instance(contact(), parameters)
    instance.initialise()
    p, d = instance.parameters, instance.derived
    if p[P.creep_law] == WITH_MEMORY and not _slides(p, d):
        raise DataError(
            "creep_law = 2: with memory a contact that sticks in part has slopes that depend on the frequency; "
            "must be 0 or 1 there"
        )
    state = np.array([p[P.steady_creepage_lon], p[P.steady_creepage_lat], p[P.steady_creepage_spin]])
    load, velocity = p[P.normal_load], p[P.rolling_velocity]
    arm = np.sqrt(p[P.semi_axis_lon] * p[P.semi_axis_lat])

    def forces(creepage: Real, normal: float) -> Real:
        return np.array(creep_forces(p, d, *creepage, normal))

    H1 = np.empty((3, 3))
    for j, step in enumerate((STEP, STEP, STEP / arm)):
        change = np.zeros(3)
        change[j] = step
        H1[:, j] = (forces(state + change, load) - forces(state - change, load)) / (2 * step * velocity)
    h2 = (forces(state, load * (1 + STEP)) - forces(state, load * (1 - STEP))) / (2 * STEP * load)
    compression = STEP * load / p[P.hertz_stiffness]
    stiffness = (normal_force(p, d, compression) - normal_force(p, d, -compression)) / (2 * compression)
    return LinearContact(H1, h2, float(stiffness), float(p[P.contact_angle]))


def _slides(p: Real, d: Real) -> bool:
    """Return whether all of the contact slides at its steady state, one way: its force is the friction force."""
    lon, lat, spin = p[P.steady_creepage_lon], p[P.steady_creepage_lat], p[P.steady_creepage_spin]
    limit = friction_coefficient(p, d, float(np.hypot(lon, lat))) * p[P.normal_load]
    force = np.hypot(*creep_forces(p, d, lon, lat, spin, p[P.normal_load])[:2])
    return bool(force > (1 - SLIDES) * limit)
