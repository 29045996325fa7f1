"""A linear structure as pairs of states that do not couple: modes, or what was identified, in; responses out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.modal.modes import Modes

from ..stability.poles import Identified, Structure

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


_REAL = 1e-5
"""Imaginary part, relative, below which a pole that was identified is real."""


@dataclass(frozen=True)
class Part:
    """A structure x' = A x + B F with displacement U x and velocity V x, A of 2 x 2 blocks.

    Attributes
    ----------
    blocks : (n, 2, 2) of A [1/s]
    drive : (n, 2, d) of B
    displace, move : (d, n, 2) of U and V
    weight : (n, 2) makes states comparable: for modes the root of the energy
    """

    blocks: Real
    drive: Real
    displace: Real
    move: Real
    weight: Real

    @classmethod
    def of(cls, structure: Structure) -> Part:
        """Return the part that a structure is."""
        return _of_modes(structure) if isinstance(structure, Modes) else _of_identified(structure)

    def beside(self, other: Part) -> Part:
        """Return both parts under the same forces, their motions added."""
        return Part(
            np.concatenate([self.blocks, other.blocks]),
            np.concatenate([self.drive, other.drive]),
            np.concatenate([self.displace, other.displace], axis=1),
            np.concatenate([self.move, other.move], axis=1),
            np.concatenate([self.weight, other.weight]),
        )

    def mirrored(self) -> Part:
        """Return the part with forces and motions of opposite sign."""
        return replace(self, drive=-self.drive, displace=-self.displace, move=-self.move)

    def turned(self, turn: Real) -> Part:
        """Return the part in other axes."""
        return replace(
            self,
            drive=self.drive @ turn.T,
            displace=np.tensordot(turn, self.displace, axes=1),
            move=np.tensordot(turn, self.move, axes=1),
        )

    def only(self, directions: tuple[int, ...]) -> Part:
        """Return the part in some of the directions."""
        chosen = list(directions)
        return replace(self, drive=self.drive[:, :, chosen], displace=self.displace[chosen], move=self.move[chosen])

    @cached_property
    def _polynomials(self) -> tuple[Real, Real, Real, Real]:
        """Numerators P s + Q, (n, d * d) each, and s^2 - trace s + determinant of the receptance of each pair."""
        a, b, c, d = (self.blocks[:, i, j] for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)))
        adjugate = np.stack([np.stack([-d, b], -1), np.stack([c, -a], -1)], -2)
        displace = self.displace.transpose(1, 0, 2)
        P, Q = displace @ self.drive, displace @ adjugate @ self.drive
        square = len(self.displace) ** 2
        return P.reshape(-1, square), Q.reshape(-1, square), a + d, a * d - b * c

    def receptance(self, s: Complex) -> tuple[Complex, Complex]:
        """Return displacement per force at complex frequencies, and its derivative by s, (m, d, d)."""
        P, Q, trace, determinant = self._polynomials
        s = s[:, None]
        g = 1.0 / (determinant + s * (s - trace))
        slope = (trace - 2 * s) * g * g
        values, slopes = _times(np.concatenate([g, slope]), Q)
        if P.any():
            further = _times(np.concatenate([s * g, g + s * slope]), P)
            values, slopes = values + further[0], slopes + further[1]
        d = len(self.displace)
        return values.reshape(-1, d, d), slopes.reshape(-1, d, d)

    def states(self, s: Complex, forces: Complex) -> Complex:
        """Return the states at complex frequencies under forces (m, d), (m, n, 2)."""
        driven = np.einsum("nid,md->mni", self.drive, forces)
        return np.asarray(np.linalg.solve(s[:, None, None, None] * np.eye(2) - self.blocks, driven[..., None])[..., 0])

    def exact_step(self, h: float) -> tuple[Real, Real]:
        """Return the step of each pair with the force held: (n, 2, 2) per state and (n, 2, d) per force."""
        w = self.weight
        both = np.zeros((len(self.blocks), 4, 4))  # states of like size, so that few squarings are needed
        both[:, :2, :2], both[:, :2, 2:] = h * w[:, :, None] * self.blocks / w[:, None, :], h * np.eye(2)
        stepped = _exponential(both)
        held = stepped[:, :2, 2:] @ (w[:, :, None] * self.drive)
        return stepped[:, :2, :2] / w[:, :, None] * w[:, None, :], held / w[:, :, None]


def _exponential(matrices: Real) -> Real:
    """Return the exponentials of small matrices, (n, k, k), by scaling and squaring.

    Notes
    -----
    14 terms of the series are exact to rounding at a norm of 1/2.
    """
    halvings = max(0, int(np.ceil(np.log2(np.abs(matrices).sum(axis=-1).max(initial=1e-9)))) + 1)
    scaled = matrices / 2**halvings
    unit = np.eye(matrices.shape[-1])
    result = unit + scaled / 14
    for k in range(13, 0, -1):
        result = unit + scaled @ result / k
    for _ in range(halvings):
        result = result @ result
    return np.asarray(result)


def _times(factors: Complex, weights: Real) -> tuple[Complex, Complex]:
    """Return two halves of a product, real arithmetic."""
    product: Complex = factors.real @ weights + 1j * (factors.imag @ weights)
    half = len(product) // 2
    return product[:half], product[half:]


def _of_modes(modes: Modes) -> Part:
    """Return modes as pairs of modal velocity and modal displacement."""
    n = len(modes)
    blocks, drive, displace, move = np.zeros((n, 2, 2)), np.zeros((n, 2, 4)), np.zeros((4, n, 2)), np.zeros((4, n, 2))
    blocks[:, 0, 0], blocks[:, 0, 1], blocks[:, 1, 0] = -2 * modes.zeta * modes.omega, -(modes.omega**2), 1.0
    drive[:, 0] = modes.shape
    displace[:, :, 1] = move[:, :, 0] = modes.shape.T
    return Part(blocks, drive, displace, move, np.stack([np.ones(n), modes.omega], -1))


def _of_identified(found: Identified) -> Part:
    """Return each complex pair of poles as real and imaginary part of its state, a real pole as half a pair."""
    alone = np.abs(found.pole.imag) < _REAL * np.abs(found.pole)  # real, up to the rounding of the identification
    paired = (found.pole.imag > 0) & ~alone
    chosen = np.flatnonzero(paired | alone)
    p, c, b = found.pole[chosen], found.observe[:, chosen], found.drive[chosen]
    twice = np.where(paired[chosen], 2.0, 1.0)
    blocks = np.stack([np.stack([p.real, -p.imag], -1), np.stack([p.imag, p.real], -1)], -2)
    drive = np.stack([b.real, b.imag], 1)
    c_u = c / p
    move, displace = (np.stack([twice * m.real, -twice * m.imag], -1) for m in (c, c_u))
    return Part(blocks, drive, displace, move, np.ones((chosen.size, 2)))
