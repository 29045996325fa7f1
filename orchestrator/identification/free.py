"""What the inferred identification leaves free, and what is known of it before: a vector in, a wheel and a law out.

Table 4 fixes only g/mu^2, the falling slope over the square of friction (docs/stability.md): lateral amplitudes times
1/a, slope times a^2 and friction times a leave every lateral eigenlocus as it is. The prior on the amplitudes, the
finite elements, is what tells slope and friction apart.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fmus.component import Instance
from fmus.contact.component import contact
from fmus.contact.parameters import P

Real = NDArray[np.float64]

LATERAL_WIDTH = 0.3
NORMAL_WIDTH = 0.015
"""Standard deviations of the prior: ln of a lateral amplitude [-], normal amplitude [kg^-1/2]."""

SCALARS = ("mass_factor", "slope_factor", "friction", "radial_zeta", "low_factor")
"""The free numbers that are not amplitudes: factor on the rigid body's normal amplitudes; s, the slope factor; mu0;
damping ratio of (2,r); factor on the damping of all modes with n = 0 and 1, the axle's among them."""

SCALAR_WIDTHS = (0.5, 1.0, 0.5, 2.0, 0.7)
"""Standard deviations of their logarithms: wide where nothing is known, a factor of two for the low modes' damping,
which the default values of TWINS guess most coarsely."""

RADIAL_ZETA = 7e-4
"""Middle of the prior of the damping ratio of (2,r): between 1e-4, as other modes have, and 5e-3."""


@dataclass(frozen=True)
class PrintedLaw:
    """The friction law of Tables 1 and 3 at its operating point.

    Attributes
    ----------
    friction, falling_ratio, saturation : mu0, lambda, kappa of Table 1
    creepage : steady lateral creepage of Table 3
    """

    friction: float
    falling_ratio: float
    saturation: float
    creepage: float


def printed_law() -> PrintedLaw:
    """Return the law that the contact has unless told otherwise, which is the printed one."""
    p = Instance(contact()).parameters
    at = (P.mu0, P.falling_ratio, P.saturation_coefficient, P.steady_creepage_lat)
    return PrintedLaw(*(float(p[position]) for position in at))


@dataclass(frozen=True)
class FreeWheel:
    """A wheel and a friction law, in contact axes, each mode with positive lateral amplitude.

    Attributes
    ----------
    lateral, normal : (n,) amplitudes of the free modes [kg^-1/2]
    mass_factor : on the normal amplitudes of the rigid-body modes [-]
    slope_factor : s, falling slope over the square of friction, relative to the printed law [-]
    friction : mu0 [-]
    radial_zeta : damping ratio of (2,r) [-]
    low_factor : on the damping of the elastic modes with n = 0 and 1 [-]
    """

    lateral: Real
    normal: Real
    mass_factor: float
    slope_factor: float
    friction: float
    radial_zeta: float
    low_factor: float

    def without(self, mode: int) -> FreeWheel:
        """Return the wheel without one of its free modes."""
        present = np.arange(self.lateral.size) != mode
        return replace(self, lateral=self.lateral * present, normal=self.normal * present)

    def law(self, printed: PrintedLaw) -> dict[str, float]:
        """Return the parameters of the contact that have this slope and friction.

        Notes
        -----
        kappa and lambda keep tau, the share of friction that is left at the operating point, as printed: the slope is
        mu0 N (1 - tau) kappa/gamma^2 / V, so kappa = s mu0/mu0_printed times the printed one.
        """
        ratio = self.slope_factor * self.friction / printed.friction
        more = (ratio - 1) * printed.saturation / printed.creepage
        return {
            "mu0": self.friction,
            "falling_ratio": printed.falling_ratio * float(np.exp(more)),
            "saturation_coefficient": printed.saturation * ratio,
        }


@dataclass(frozen=True)
class Prior:
    """What is known before Table 4.

    Attributes
    ----------
    middle : a wheel with the amplitudes of the finite elements and the printed law
    width : (2 n + 5,) standard deviations: ln lateral, normal, ln of the scalars
    """

    middle: FreeWheel
    width: Real

    @classmethod
    def about(cls, lateral: Real, normal: Real, friction: float) -> Prior:
        """Return the prior about the amplitudes of the finite elements and the printed friction."""
        n = lateral.size
        width = np.concatenate([np.full(n, LATERAL_WIDTH), np.full(n, NORMAL_WIDTH), SCALAR_WIDTHS])
        return cls(FreeWheel(lateral, normal, 1.0, 1.0, friction, RADIAL_ZETA, 1.0), width)

    def wheel(self, vector: Real) -> FreeWheel:
        """Return the wheel at a distance from the middle, (2 n + 5,) in standard deviations."""
        step, n = vector * self.width, self.middle.lateral.size
        scalars = self._scalars(self.middle) * np.exp(step[2 * n :])
        return FreeWheel(
            self.middle.lateral * np.exp(step[:n]), self.middle.normal + step[n : 2 * n], *(float(v) for v in scalars)
        )

    def vector(self, wheel: FreeWheel) -> Real:
        """Return the distance that makes a wheel, the inverse of `wheel`."""
        step = np.concatenate([
            np.log(wheel.lateral / self.middle.lateral),
            wheel.normal - self.middle.normal,
            np.log(self._scalars(wheel) / self._scalars(self.middle)),
        ])  # fmt: skip
        return np.asarray(step / self.width)

    def place(self, scalar: str) -> int:
        """Return the position of one of `SCALARS` in a vector."""
        return 2 * self.middle.lateral.size + SCALARS.index(scalar)

    @staticmethod
    def _scalars(wheel: FreeWheel) -> Real:
        return np.array([getattr(wheel, name) for name in SCALARS])
