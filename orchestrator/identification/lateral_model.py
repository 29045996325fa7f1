"""The lateral eigenlocus of the four cases as a function of contact amplitudes: quick enough to be fitted.

Uses that lateral and normal motion of an axisymmetric wheel on a straight rail are on their own (`Loop.lateral`), and
that natural frequencies and damping stay: the modal terms at all frequencies are tabulated once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes, mobility

from ..published.table4 import CASES, CELL_MODES
from ..stability.eigenloci import clockwise_crossings
from ..stability.loop import Mobility

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

WINDOWS_HZ = {
    "(1,0)": (50.0, 210.0), "(0,0)": (210.0, 340.0), "(0,x)": (340.0, 410.0), "(2,0)": (410.0, 430.0),
    "(3,0)": (1070.0, 1130.0), "(4,0)": (1940.0, 2020.0), "(5,0)": (2910.0, 2990.0), "(6,0)": (3880.0, 4040.0),
}  # fmt: skip
"""Where the crossing of each cell is looked for, and others are held against the fit [Hz]; no gap up to 430 Hz."""

_PEAK = 0.012
_SHOULDER_HZ = 0.25
"""Fine spacing within this relative distance of the cell's natural frequency; this spacing elsewhere [Hz].
Cells lie near their modes; between resonances the loop changes over tens of hertz."""


@dataclass(frozen=True)
class LateralModel:
    """Everything about the four cases that the free amplitudes do not change.

    Attributes
    ----------
    omega : (m,) angular frequencies of all windows [rad/s]
    cells : columns of Table 4 that are looked at
    window : slice of each cell
    term : (m, n) mobility of each free mode with unit amplitude
    fixed : (3, m) lateral, cross and normal mobility of the other wheel modes, contact axes
    rail : (3, m) the same of the rail
    contacts : linearised contact of each case
    """

    omega: Real
    cells: tuple[str, ...]
    window: tuple[slice, ...]
    term: Complex
    fixed: Complex
    rail: Complex
    contacts: tuple[LinearContact, ...]

    def loci(self, lateral: Real, normal: Real) -> list[Complex]:
        """Return the lateral eigenlocus in each case, (m,), at amplitudes (n,) in contact axes."""
        shapes = np.stack([lateral * lateral, lateral * normal, normal * normal])
        wheel = self.fixed + shapes @ self.term.T
        out = []
        for case, contact in zip(CASES, self.contacts, strict=True):
            Y = wheel + self.rail if case in (1, 3) else wheel
            out.append(lateral_locus(Y, self.omega, contact.stiffness, contact.H1[1, 1], -contact.h2[1]))
        return out

    def crossings(self, lateral: Real, normal: Real) -> Crossings:
        """Return the largest clockwise crossing of every cell in every case."""
        shape = (len(CASES), len(self.cells))
        frequency, gain, top, further = np.zeros(shape), np.zeros(shape), np.zeros(shape), np.zeros(shape)
        for i, locus in enumerate(self.loci(lateral, normal)):
            for j, near in enumerate(self.window):
                value = locus[near]
                top[i, j] = value.real.max()
                f, g = clockwise_crossings(self.omega[near] / (2 * np.pi), value)
                if g.size:
                    best = g.argmax()
                    frequency[i, j], gain[i, j] = f[best], g[best]
                    g[best] = 0.0
                    further[i, j] = g.max()
        return Crossings(frequency, gain, top, further)

    def part(self, columns: Sequence[int], cells: tuple[str, ...], lateral: Real, normal: Real) -> LateralModel:
        """Return the model in which only some modes are free and some cells are seen; others stay as given."""
        rest = np.setdiff1d(np.arange(lateral.size), columns)
        shapes = np.stack([lateral * lateral, lateral * normal, normal * normal])[:, rest]
        keep = np.concatenate([np.arange(self.omega.size)[self.window[self.cells.index(c)]] for c in cells])
        sizes = [self.window[self.cells.index(c)] for c in cells]
        ends = np.cumsum([0] + [s.stop - s.start for s in sizes])
        return replace(
            self,
            omega=self.omega[keep],
            cells=cells,
            window=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
            term=self.term[keep][:, columns],
            fixed=self.fixed[:, keep] + shapes @ self.term[np.ix_(keep, rest)].T,
            rail=self.rail[:, keep],
        )


@dataclass(frozen=True)
class Crossings:
    """Crossings of the positive real axis, cases by cells.

    Attributes
    ----------
    frequency_hz, gain : of the largest clockwise crossing; 0 where there is none
    top : largest real part in the window
    further : gain of the next clockwise crossing in the same window
    """

    frequency_hz: Real
    gain: Real
    top: Real
    further: Real


def lateral_model(modes: Modes, free: Sequence[int], rail: Mobility, contacts: Sequence[LinearContact]) -> LateralModel:
    """Return the model in which the amplitudes of some modes are free.

    Parameters
    ----------
    modes : all modes of the wheelset, track axes
    free : indices of the free ones
    rail : mobility of the rail of Cases 1 and 3
    contacts : linearised contact of each case; all at one contact angle
    """
    windows = [window(modes, cell) for cell in CELL_MODES]
    ends = np.cumsum([0] + [w.size for w in windows])
    omega = 2 * np.pi * np.concatenate(windows)
    turn = contacts[0].turn
    rest = modes.keep(np.setdiff1d(np.arange(len(modes)), free))
    return LateralModel(
        omega=omega,
        cells=CELL_MODES,
        window=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
        term=modal_terms(omega, modes.omega[list(free)], modes.zeta[list(free)]),
        fixed=lateral_and_normal(turn @ mobility(omega, rest) @ turn.T),
        rail=lateral_and_normal(turn @ rail(omega) @ turn.T),
        contacts=tuple(contacts),
    )


def modal_terms(omega: Real | Complex, natural: Real, zeta: Real) -> Complex:
    """Return the mobilities of modes with unit amplitude, (m, n).

    Parameters
    ----------
    omega : (m,) angular frequencies, may be complex [rad/s]
    natural, zeta : (n,) natural angular frequencies [rad/s] and damping ratios
    """
    w = omega[:, None]
    return np.asarray(1j * w / (natural * natural - w * w + 2j * zeta * natural * w))


def lateral_locus(Y: Complex, omega: Real | Complex, stiffness: float, slope: float, friction: float) -> Complex:
    """Return the lateral eigenlocus by the scalar formula of `Loop.lateral`, (m,).

    Parameters
    ----------
    Y : (3, m) lateral, cross and normal mobility of wheel and rail, contact axes
    omega : (m,) angular frequencies, may be complex [rad/s]
    stiffness : of the contact spring [N/m]
    slope, friction : of the lateral force over velocity [N s/m] and over the normal force [-]
    """
    Y_tt, Y_tn, Y_nn = Y
    share = Y_tn / (Y_nn + 1j * omega / stiffness)
    return np.asarray(slope * (Y_tt - Y_tn * share) + friction * share)


def window(modes: Modes, cell: str) -> Real:
    """Return the frequencies of a cell [Hz]: near its mode a third of half the half-power bandwidth apart."""
    i = modes.labels.index(f"{cell} cosine")
    low, high = WINDOWS_HZ[cell]
    f = modes.omega[i] / (2 * np.pi)
    fine = min(modes.zeta[i] * f / 3, _SHOULDER_HZ)
    peak = np.arange(max(low, (1 - _PEAK) * f), min(high, (1 + _PEAK) * f), fine)
    return np.unique(np.concatenate([np.arange(low, high, _SHOULDER_HZ), peak]))


def lateral_and_normal(Y: Complex) -> Complex:
    """Return the lateral, cross and normal entries, (3, m)."""
    return np.stack([Y[:, 1, 1], Y[:, 1, 2], Y[:, 2, 2]])
