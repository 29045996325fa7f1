"""How fast low modes of the coupled system may grow while contact amplitudes are fitted: amplitudes in, excess out.

Table 4 says little about growth. A fit to its gains alone lets the contact resonance near 260 Hz and (0,0) grow so fast
that they win in the time domain, where the paper has 1978 and 1100 Hz.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes

from ..stability.loop import Mobility
from ..stability.poles import exact_poles

Real = NDArray[np.float64]


@dataclass(frozen=True)
class FittedRail:
    """The rail of Cases 1 and 3.

    Attributes
    ----------
    mobility : analytical, for the gains of Table 4
    modes : its modal equivalent, for growth rates
    """

    mobility: Mobility
    modes: Modes


@dataclass(frozen=True)
class Limit:
    """Limits of the largest growth rate of the poles of a case between two frequencies.

    Attributes
    ----------
    case : 1 to 4
    low_hz, high_hz : where the poles are [Hz]
    least, most : limits [1/s]; the one that is exceeded must be positive
    """

    case: int
    low_hz: float
    high_hz: float
    least: float
    most: float


LIMITS = (
    Limit(2, 150.0, 300.0, 0.0, 60.0),
    Limit(4, 150.0, 300.0, 0.0, 75.0),
    Limit(2, 1950.0, 2010.0, 28.0, np.inf),
    Limit(4, 1950.0, 2010.0, 26.0, np.inf),
    Limit(3, 240.0, 300.0, 0.0, 13.0),
    Limit(3, 1950.0, 2010.0, 0.0, 11.0),
)
"""Contact resonance against (4,0) on the rigid rail, (0,0) and (4,0) against (3,0) in Case 3. Which tone
wins follows from these rates: with 131 and 139 1/s of the contact resonance in Cases 2 and 4 it is another than the
paper's (docs/adr/0007)."""

SCATTER = 0.05
"""Standard deviation of a growth rate relative to its limit [-]."""

_KEPT_HZ = 2700.0
"""Wheel modes above are springs for the low poles: the highest of these is (4,0), at 1980 Hz."""


@dataclass(frozen=True)
class GrowthLimits:
    """Limits of the growth of low modes for the amplitudes of a fit.

    Attributes
    ----------
    wheel : low modes of one family, contact axes
    free : (n,) their numbers in the order of the fitted columns; -1 for a column above `_KEPT_HZ`
    rails : rail of each case, contact axes
    contacts : linearised contact of each case, with the static flexibility of the higher wheel modes in its spring
    limits : those that count
    """

    wheel: Modes
    free: NDArray[np.int64]
    rails: tuple[Modes, ...]
    contacts: tuple[LinearContact, ...]
    limits: tuple[Limit, ...]

    def residuals(self, lateral: Real, normal: Real) -> Real:
        """Return by how much each limit is exceeded, in standard deviations, (m,).

        Parameters
        ----------
        lateral, normal : (n,) amplitudes of the fitted columns, contact axes [kg^-1/2]
        """
        shape = self.wheel.shape.copy()
        low = self.free >= 0
        shape[self.free[low], 1], shape[self.free[low], 2] = lateral[low], normal[low]
        wheel = replace(self.wheel, shape=shape)
        out = []
        for limit in self.limits:
            poles = exact_poles(wheel, self.rails[limit.case - 1], self.contacts[limit.case - 1])
            there = (poles.frequency_hz > limit.low_hz) & (poles.frequency_hz < limit.high_hz)
            top = float(poles.growth_rate[there].max(initial=0.0))
            bound = min(max(top, limit.least), limit.most)
            out.append((top - bound) / (SCATTER * bound))
        return np.array(out)


def growth_limits(
    modes: Modes, free: Sequence[int], rail: Modes, contacts: Sequence[LinearContact], limits: Sequence[Limit]
) -> GrowthLimits:
    """Return the limits for a wheelset of which some modes are fitted.

    Parameters
    ----------
    modes : all modes of the wheelset, track axes
    free : indices of the fitted ones
    rail : modes of the rail of Cases 1 and 3, track axes
    contacts : linearised contact of each case; all at one contact angle
    """
    turn = contacts[0].turn
    own = [i for i, label in enumerate(modes.labels) if label.endswith("cosine")]
    low = [i for i in own if modes.omega[i] < 2 * np.pi * _KEPT_HZ]
    high = modes.keep([i for i in own if i not in low])
    flexibility = float((((high.shape @ turn.T)[:, 2] / high.omega) ** 2).sum())
    turned = tuple(
        replace(contact, stiffness=1 / (1 / contact.stiffness + flexibility), angle=0.0) for contact in contacts
    )
    moving = _turned(rail.keep(np.flatnonzero(np.abs(rail.shape[:, 1:3]).sum(axis=1))), turn)
    none = rail.keep(np.zeros(0, dtype=int))
    place = np.array([low.index(i) if i in low else -1 for i in free])
    return GrowthLimits(_turned(modes.keep(low), turn), place, (moving, none, moving, none), turned, tuple(limits))


def _turned(modes: Modes, turn: Real) -> Modes:
    return replace(modes, shape=modes.shape @ turn.T)
