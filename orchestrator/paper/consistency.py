"""What the printed loop gains of Cases 1 to 3 say about the rail: Table 4 and the contact in, a bound on Re Y33 out.

For one wheel mode alone, with D the mobility of everything else in the normal direction (other modes, rail, spring),
g the falling slope, m1 and m0 the falling and the constant friction coefficient, psi2 and psi3 its amplitudes, the
loop gains at its crossings are

    L2 = g psi2^2 / (2 zeta w0)                       rigid rail, falling friction
    L3 = m0 psi2 psi3 / (psi3^2 + 2 zeta w0 r)        rail, constant friction
    L1 = (m1/m0) L3 + L2 q                            rail, falling friction

with r = |D|^2 / Re D and q = 2 zeta w0 r / (psi3^2 + 2 zeta w0 r). Amplitudes and damping drop out:

    q = (L1 - (m1/m0) L3) / L2,    r = q (1 - q) m0^2 L2 / (g L3^2),

and r >= Re D >= Re Y33 of the rail, whatever the wheel. Where the table's r is smaller than the rail's Re Y33, table,
friction data and track exclude each other.

q (1 - q) is at most 1/4 for any q, so r <= m0^2 L2 / (4 g L3^2): the gain of Case 1, the falling coefficient m1 and how
well q is known drop out as well, and of the friction law g/m0^2 is all that is left.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import LinearContact

from ..published.table4 import CELL_MODES, PaperTable
from ..stability.loop import Mobility

Real = NDArray[np.float64]


@dataclass(frozen=True)
class Consistency:
    """Bound on the rail's mobility by Table 4, mode by mode.

    Attributes
    ----------
    modes : with a crossing in Cases 1, 2 and 3
    frequency_hz : of the crossing in Case 1 [Hz]
    r : |D|^2 / Re D that the printed gains imply [m/s/N]
    rail : Re Y33 of the rail there [m/s/N]
    largest_r : the same whatever the falling coefficient and the gain of Case 1 [m/s/N]
    largest_slope : falling slope beyond which r is smaller than the rail's Re Y33 [N s/m]
    """

    modes: tuple[str, ...]
    frequency_hz: Real
    r: Real
    rail: Real
    largest_r: Real
    largest_slope: Real


def implied_r(gains: Real, slope: float, falling: float, constant: float) -> Real:
    """Return r of the loop gains in Cases 1, 2 and 3, (3, n) -> (n,).

    Parameters
    ----------
    slope : dF2/dv2 with falling friction [N s/m]
    falling, constant : friction coefficients at the operating point [-]
    """
    first, second, third = gains
    q = (first - falling / constant * third) / second
    return np.asarray(q * (1 - q) * constant**2 * second / (slope * third**2))


def consistency(paper: PaperTable, rail: Mobility, falling: LinearContact, constant: LinearContact) -> Consistency:
    """Return what Table 4 says about the rail."""
    column = np.flatnonzero(paper.unstable[:3].all(axis=0))
    frequency_hz = paper.frequency_hz[0, column]
    slope, mu1, mu0 = float(falling.H1[1, 1]), -float(falling.h2[1]), -float(constant.h2[1])
    r = implied_r(paper.gain[:3, column], slope, mu1, mu0)
    Y = falling.turn @ rail(2 * np.pi * frequency_hz) @ falling.turn.T
    real = Y[:, 2, 2].real
    _, second, third = paper.gain[:3, column]
    largest = mu0**2 * second / (4 * slope * third**2)
    return Consistency(tuple(CELL_MODES[c] for c in column), frequency_hz, r, real, largest, slope * r / real)
