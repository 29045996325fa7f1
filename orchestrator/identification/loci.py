"""The lateral eigenloci of the four cases for any wheel and law that the inferred identification may try.

Beyond `lateral_model.py` the damping of some modes, the slope and the friction coefficient are free, and a locus can be
asked for at complex frequencies: where it is 1 the closed loop has a pole, so one function gives crossings, poles and
the derivatives of both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from fmus.compile import kernel
from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes
from fmus.wheel.wheelset import Wheelset

from ..published.table4 import CELL_MODES
from ..stability.loop import Mobility, linear_contact
from ..stability.poles import Poles, exact_poles
from .fit import FREE_MODES, RIGID
from .free import FreeWheel, PrintedLaw, printed_law
from .lateral_model import lateral_and_normal, lateral_locus, window

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

RADIAL = "(2,r)"
_KEPT_HZ = 2700.0
"""Wheel modes above are springs when the low poles are looked for: the highest of these is (4,0), at 1980 Hz."""


@dataclass(frozen=True)
class Points:
    """Frequencies with everything that no free number changes there.

    Attributes
    ----------
    omega : (m,) angular frequencies, may be complex [rad/s]
    still : (3, m) lateral, cross and normal mobility of the modes that stay as they are
    rail : (3, m) the same of the rail of Cases 1 and 3
    """

    omega: Complex
    still: Complex
    rail: Complex

    def at(self, index: NDArray[np.int64]) -> Points:
        """Return some of them."""
        return Points(self.omega[index], self.still[:, index], self.rail[:, index])


@dataclass(frozen=True)
class Family:
    """Modes of one symmetry in contact axes: natural frequencies, damping ratios, (2, n) lateral and normal shape."""

    omega: Real
    zeta: Real
    shape: Real

    @classmethod
    def of(cls, modes: Modes, chosen: Sequence[int], turn: Real) -> Family:
        """Return some modes, each with positive lateral amplitude; `turn` goes from track to contact axes."""
        shape = (modes.shape[list(chosen)] @ turn.T)[:, 1:3].T
        return cls(modes.omega[list(chosen)], modes.zeta[list(chosen)], shape * np.where(shape[0] < 0, -1.0, 1.0))

    def mobility(self, omega: Complex) -> Complex:
        """Return lateral, cross and normal mobility, (3, m)."""
        return np.asarray(_mobility(omega, self.omega, self.zeta, *self.shape))

    def joined(self, other: Family) -> Family:
        """Return the modes of both."""
        return Family(
            np.concatenate([self.omega, other.omega]),
            np.concatenate([self.zeta, other.zeta]),
            np.hstack([self.shape, other.shape]),
        )


@kernel
def _mobility(omega, natural, zeta, lateral, normal):  # type: ignore[no-untyped-def]
    """Return lateral, cross and normal mobility of modes, (3, m); `modal_terms` without its large arrays."""
    out = np.zeros((3, omega.size), dtype=np.complex128)
    for i in range(omega.size):
        w = omega[i]
        for k in range(natural.size):
            term = 1j * w / (natural[k] ** 2 - w * w + 2j * zeta[k] * natural[k] * w)
            out[0, i] += lateral[k] * lateral[k] * term
            out[1, i] += lateral[k] * normal[k] * term
            out[2, i] += normal[k] * normal[k] * term
    return out


@dataclass(frozen=True)
class InferredModel:
    """The four cases with everything that is free left open.

    Attributes
    ----------
    points : all frequencies of the windows in which crossings are looked for
    window : slice of each column of Table 4
    moving : modes that free numbers change: `FREE_MODES`, `RIGID`, then the other ones with n = 0 and 1
    still : all other modes
    low : (n,) which moving modes have the common factor on their damping
    contact : the printed law linearised, with the stiffness of the contact spring
    printed : the printed law
    """

    points: Points
    window: tuple[slice, ...]
    moving: Family
    still: Family
    low: NDArray[np.bool_]
    contact: LinearContact
    printed: PrintedLaw

    def wheel(self, free: FreeWheel) -> Family:
        """Return the moving modes of a wheel."""
        zeta = np.where(self.low, self.moving.zeta * free.low_factor, self.moving.zeta)
        zeta[FREE_MODES.index(RADIAL)] = free.radial_zeta
        shape, n = self.moving.shape.copy(), len(FREE_MODES)
        shape[:, :n] = free.lateral, free.normal
        shape[1, n : n + len(RIGID)] *= free.mass_factor
        return Family(self.moving.omega, zeta, shape)

    def slopes(self, free: FreeWheel) -> tuple[float, float, float]:
        """Return the falling slope [N s/m] and the friction coefficients of falling and constant friction."""
        slope = float(self.contact.H1[1, 1]) * free.slope_factor * (free.friction / self.printed.friction) ** 2
        return slope, -float(self.contact.h2[1]) * free.friction / self.printed.friction, free.friction

    def loci(self, free: FreeWheel, points: Points) -> Complex:
        """Return the lateral eigenlocus of Cases 1 to 4 at some frequencies, (4, m)."""
        rigid = points.still + self.wheel(free).mobility(points.omega)
        slope, falling, constant = self.slopes(free)
        stiffness = self.contact.stiffness
        out = [
            lateral_locus(Y, points.omega, stiffness, steep, friction)
            for steep, friction in ((slope, falling), (0.0, constant))
            for Y in (rigid + points.rail, rigid)
        ]
        return np.stack(out)

    def without_rail(self, omega: Complex) -> Points:
        """Return any frequencies, complex ones too, at which only Cases 2 and 4 mean something."""
        return Points(omega, self.still.mobility(omega), np.zeros((3, omega.size), dtype=complex))

    def poles(self, free: FreeWheel, case: int) -> Poles:
        """Return the low poles of Case 2 or 4."""
        every = self.wheel(free).joined(self.still)
        low = every.omega < 2 * np.pi * _KEPT_HZ
        flexibility = float(((every.shape[1, ~low] / every.omega[~low]) ** 2).sum())
        slope, falling, constant = self.slopes(free)
        H1, h2 = np.zeros((3, 3)), np.zeros(3)
        H1[1, 1], h2[1] = (slope, -falling) if case == 2 else (0.0, -constant)
        law = LinearContact(H1, h2, 1 / (1 / self.contact.stiffness + flexibility), 0.0)
        shape = np.zeros((int(low.sum()), 4))
        shape[:, 1:3] = every.shape[:, low].T
        none = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))
        return exact_poles(Modes(every.omega[low], every.zeta[low], shape), none, law)


def inferred_model(wheelset: Wheelset, rail: Mobility, stiffness: float) -> InferredModel:
    """Return the model about a wheelset.

    Parameters
    ----------
    wheelset : the finite elements
    rail : mobility of the rail of Cases 1 and 3, track axes
    stiffness : of the contact spring [N/m]
    """
    modes, contact = wheelset.modes, linear_contact({"hertz_stiffness": stiffness})
    own = [i for i, label in enumerate(modes.labels) if label.endswith("cosine")]
    named = [modes.labels.index(f"{name} cosine") for name in (*FREE_MODES, *RIGID)]
    soft = low_modes(wheelset)
    moving = [*named, *(i for i in own if soft[i] and i not in named)]
    windows = [window(modes, cell) for cell in CELL_MODES]
    ends = np.cumsum([0] + [w.size for w in windows])
    omega = 2 * np.pi * np.concatenate(windows)
    still = Family.of(modes, [i for i in own if i not in moving], contact.turn)
    track = lateral_and_normal(contact.turn @ rail(omega) @ contact.turn.T)
    return InferredModel(
        points=Points(omega.astype(complex), still.mobility(omega.astype(complex)), track),
        window=tuple(slice(int(a), int(b)) for a, b in pairwise(ends)),
        moving=Family.of(modes, moving, contact.turn),
        still=still,
        low=soft[moving],
        contact=contact,
        printed=printed_law(),
    )


def low_modes(wheelset: Wheelset) -> NDArray[np.bool_]:
    """Return which modes are elastic ones with n = 0 or 1, whose damping has the common factor."""
    rigid = np.array([label.startswith("rigid") for label in wheelset.modes.labels])
    return np.asarray((wheelset.nodal_diameters < 2) & ~rigid)
