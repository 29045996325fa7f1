"""Bogies for the tests of curving: the reference vehicle, and one with linear creep and nothing else."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.creep.kalker import creepage_coefficients
from fmus.curving.balance import unscale
from fmus.curving.bogie import Bogie, BogieState, Curve
from fmus.curving.component import vehicle
from fmus.curving.contact_table import ContactTable
from fmus.curving.equilibrium import newton, start_straight
from fmus.curving.geometry import prepare_table
from fmus.curving.layout import N_GEOMETRY, D, G, N
from fmus.curving.parameters import P

GRAVITY = 9.80665
W, L0, R0, A = 120e3, 0.75, 0.42, 1.3


def balanced(radius: float, speed: float = 10.0, **more: float) -> Curve:
    """Return a left curve whose cant leaves no lateral acceleration."""
    return Curve(1 / radius, speed, 2 * L0 * speed**2 / (GRAVITY * radius), **more)


def unbalanced(radius: float, q: float, speed: float = 10.0, **more: float) -> Curve:
    """Return a left curve with an outward acceleration of q times gravity."""
    return Curve(1 / radius, speed, 2 * L0 * (speed**2 / (GRAVITY * radius) - q), **more)


def solved(curve: Curve, table: ContactTable | None = None, **parameters: float) -> BogieState:
    """Return the reference bogie, with some parameters changed, in a curve."""
    return Bogie(parameters, table).solve(curve)


def cone(conicity: float, nodes: int = 173, reach: float = 8.6e-3) -> ContactTable:
    """Return the contact of a cone whose contact plane is level: it changes radii and gives no gravity force."""
    shift = np.linspace(-reach, reach, nodes)
    one = np.ones(nodes)
    return ContactTable(
        "level cone", shift, conicity * shift, 0 * one, 0 * one, 0 * one, 5.777675428510385e-3 * one,
        4.61727000598374e-3 * one, 1.2e9 * one, 60e3,
    )  # fmt: skip


@dataclass(frozen=True)
class LinearBogie:
    """Unknowns of a bogie with linear creep, no spin and no gravity terms, SI units, in the order of the equations."""

    unknowns: NDArray[np.float64]

    @property
    def yaw(self) -> tuple[float, float]:
        """Yaw of the leading and the trailing axle [rad]."""
        return float(self.unknowns[1]), float(self.unknowns[6])

    @property
    def shift(self) -> tuple[float, float]:
        """Shift of the leading and the trailing axle [m]."""
        return float(self.unknowns[0]), float(self.unknowns[5])


def linear_bogie(curvature: float, conicity: float = 0.05, **parameters: float) -> LinearBogie:
    """Return a bogie whose creep forces are linear and know no spin: friction without bound, C23 = 0."""
    table = cone(conicity)
    i = Instance(vehicle("vehicle", parameters, table))
    prepare_table(i.parameters, i.derived)
    n = table.shift.size
    i.derived[D.table + G.c23 * n : D.table + N_GEOMETRY * n] = 0.0
    unknowns = np.zeros(N)
    start_straight(unknowns)
    iterations, _ = newton(i.parameters, i.derived, unknowns, curvature, 0.0, 1e15)
    assert iterations >= 0
    unscale(i.parameters, i.derived, unknowns, D.trial)
    return LinearBogie(i.derived[D.trial : D.trial + N].copy())


def stiffness_of_creep() -> tuple[float, float]:
    """Return f11 and f22, creep force per creepage of the reference vehicle's patch [N]."""
    i = Instance(vehicle())
    a, b = i.parameters[P.semi_axis_lon], i.parameters[P.semi_axis_lat]
    area = i.parameters[P.shear_modulus] * a * b
    c11, c22 = creepage_coefficients(float(a), float(b), float(i.parameters[P.poisson_ratio]))[:2]
    return float(area * c11), float(area * c22)
