"""Harmonic balance of two frequencies: the equations of a torus and their Jacobian.

As for a cycle (`orchestrator.limit_cycles.balance`), with lines at k1 w1 + k2 w2 and the law sampled over both phases:

    F_k - FFT2(F(y(phases)))_k = 0,   Im y_10 = 0,   Im y_c1 = 0,   2 Re y_c1 = A2.

One more unknown than equations: w1, w2, the amplitude A2 of one of the lines (c, 1), and sigma2, the growth rate of the
lines with k2 != 0. At A2 = 0 that is an exponent of the cycle; where it is zero there is a torus.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...stability.poles import NORMAL
from ..balance import AMPLITUDE_SCALE, FORCE_SCALE, SIGMA_SCALE, in_real_numbers
from ..model import LAT, SquealModel
from ..sampling import sample_law
from .lines import Lines

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]


@dataclass(frozen=True)
class TwoTones:
    """A motion with two frequencies.

    Attributes
    ----------
    forces : (M, d) Fourier coefficients of the contact forces at the lines [N, N m]
    omega : both angular frequencies [rad/s]
    amplitude : of the lateral velocity's line that carries the second one [m/s]
    sigma : growth rate of all lines that take part in the second one [1/s]
    """

    forces: Complex
    omega: tuple[float, float]
    amplitude: float
    sigma: float


@dataclass(frozen=True)
class TwoToneBalance:
    """The equations at one choice of lines.

    Attributes
    ----------
    omega_scale : changes of both frequencies that count as one [rad/s]
    carrier : k1 of the line (k1, 1) whose lateral velocity is real and has the amplitude A2
    """

    model: SquealModel
    lines: Lines
    omega_scale: tuple[float, float]
    carrier: int

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.model.active) * (2 * len(self.lines.numbers) - 1) + 4

    @property
    def weights(self) -> Real:
        """Weights of the unknowns in the length of the curve."""
        w = np.full(self.size, 0.15)
        w[-4:] = 0.3, 0.3, 1.0, 1.0
        return w

    @property
    def scale(self) -> Real:
        """Forces that count as one, (d,)."""
        return np.asarray(FORCE_SCALE[list(self.model.active)])

    @property
    def tail_scale(self) -> Real:
        """Changes of the last four unknowns that count as one."""
        return np.array([*self.omega_scale, AMPLITUDE_SCALE, SIGMA_SCALE])

    def with_lines(self, lines: Lines) -> TwoToneBalance:
        """Return the same equations with other lines."""
        return replace(self, lines=lines)

    def resized(self, state: TwoTones, lines: Lines) -> TwoTones:
        """Return a motion of these equations with other lines."""
        forces = np.zeros((len(lines.numbers), state.forces.shape[1]), complex)
        for n, k in enumerate(lines.numbers):
            there = self.lines.place.get((int(k[0]), int(k[1])))
            if there is not None:
                forces[n] = state.forces[there]
        return replace(state, forces=forces)

    def pack(self, state: TwoTones) -> Real:
        """Return the unknowns as scaled numbers."""
        scaled = state.forces / self.scale
        tail = np.array([*state.omega, state.amplitude, state.sigma]) / self.tail_scale
        return np.concatenate([scaled[0].real, scaled[1:].real.ravel(), scaled[1:].imag.ravel(), tail])

    def unpack(self, x: Real) -> TwoTones:
        """Return the motion of scaled numbers."""
        M, d = len(self.lines.numbers), len(self.model.active)
        forces: Complex = np.zeros((M, d), complex)
        forces[0] = x[:d]
        forces[1:] = x[d : M * d].reshape(-1, d) + 1j * x[M * d : (2 * M - 1) * d].reshape(-1, d)
        w1, w2, amplitude, sigma = (x[-4:] * self.tail_scale).tolist()
        return TwoTones(np.asarray(forces * self.scale, complex), (w1, w2), amplitude, sigma)

    def frequencies(self, state: TwoTones) -> Complex:
        """Return the complex frequencies of the lines, (M,)."""
        k = self.lines.numbers
        return np.asarray(1j * (k @ np.array(state.omega)) + np.where(k[:, 1] != 0, state.sigma, 0.0))

    def responses(self, state: TwoTones) -> tuple[Complex, Complex, Complex]:
        """Return responses and their derivatives, (M, d, d), and the lines of the motion, (M, d)."""
        T, dT = self.model.response(self.frequencies(state))
        return T, dT, (T @ state.forces[:, :, None])[:, :, 0]

    def _law(self, motion_lines: Complex, with_slopes: bool) -> tuple[Real, Real]:
        """Return the samples of the forces, (N, d), and of their slopes, (N, d, d), or none of these."""
        contact, active = self.model.instance, np.array(self.model.active)
        samples, d = self.lines.on_grid(motion_lines), active.size
        motion = np.zeros((len(samples), 4))
        motion[:, active] = samples
        forces, slopes = np.empty((len(samples), d)), np.empty((len(samples) if with_slopes else 0, d, d))
        sample_law(contact.parameters, contact.derived, active, motion, forces, slopes)
        return forces, slopes

    def normal_force(self, state: TwoTones) -> Real:
        """Return the normal force at the samples, (N,) [N]."""
        _, _, motion = self.responses(state)
        forces, _ = self._law(motion, with_slopes=False)
        contact, active = self.model.instance, self.model.active
        load = float(contact.parameters[contact.component.parameter_index["normal_load"]])
        return load + (forces[:, active.index(NORMAL)] if NORMAL in active else np.zeros(len(forces)))

    def amplitudes(self, state: TwoTones) -> tuple[float, float]:
        """Return the lateral amplitudes of the lines at the first frequency and at the carrier [m/s]."""
        _, _, motion = self.responses(state)
        first, second = 2 * np.abs(motion[self._tones, self._reference])
        return float(first), float(second)

    def _equations(self, law_forces: Complex, tones: Complex, amplitude: float) -> Real:
        """Return scaled equations: forces minus law at the lines, (M, d), and both reference lines, (2,)."""
        r = law_forces / self.scale
        tail = np.array([2 * tones[0].imag, 2 * tones[1].imag, 2 * tones[1].real - amplitude]) / AMPLITUDE_SCALE
        return np.concatenate([r[0].real, r[1:].real.ravel(), r[1:].imag.ravel(), tail])

    @property
    def _tones(self) -> list[int]:
        return [self.lines.place[1, 0], self.lines.place[self.carrier, 1]]

    @property
    def _reference(self) -> int:
        return self.model.active.index(LAT)

    def _at_lines(self, samples: Real) -> Complex:
        return np.asarray(self.lines.transform(samples)[self.lines.index(self.lines.numbers)])

    def residual(self, x: Real) -> Real:
        """Return how far the equations are from zero, scaled, (size - 1,)."""
        state = self.unpack(x)
        _, _, motion = self.responses(state)
        forces, _ = self._law(motion, with_slopes=False)
        tones = motion[self._tones, self._reference]
        return self._equations(state.forces - self._at_lines(forces), tones, state.amplitude)

    def linearise(self, x: Real) -> tuple[Real, Real]:
        """Return the residual and the Jacobian, (size - 1, size)."""
        state = self.unpack(x)
        T, dT, motion = self.responses(state)
        moved = (dT @ state.forces[:, :, None])[:, :, 0]
        forces, slopes = self._law(motion, with_slopes=True)
        jacobian = np.zeros((self.size - 1, self.size))
        self._force_columns(jacobian, self.lines.transform(slopes), T)
        k = self.lines.numbers
        changes = (1j * k[:, :1] * moved, 1j * k[:, 1:] * moved, None, np.where(k[:, 1:] != 0, moved, 0.0))
        for place, (change, scale) in enumerate(zip(changes, self.tail_scale, strict=True)):
            if change is not None:
                law = np.einsum("nij,nj->ni", slopes, self.lines.on_grid(change))
                tones = change[self._tones, self._reference]
                jacobian[:, place - 4] = self._equations(-self._at_lines(law), tones, 0.0) * scale
        jacobian[-1, -2] = -1.0
        tones = motion[self._tones, self._reference]
        return self._equations(state.forces - self._at_lines(forces), tones, state.amplitude), jacobian

    def _force_columns(self, jacobian: Real, J: Complex, T: Complex) -> None:
        """Put the derivatives by the forces into the Jacobian."""
        M, d, k = len(self.lines.numbers), len(self.model.active), self.lines.numbers
        forward = J[self.lines.index(k[:, None] - k)] @ T[None]
        mirrored = J[self.lines.index(k[:, None] + k)] @ T.conj()[None]
        count = d * (2 * M - 1)
        jacobian[:count, :count] = in_real_numbers(forward, mirrored, self.scale)
        for row, tone in zip((-3, -2), self._tones, strict=True):
            answer = T[tone, self._reference] * self.scale * 2 / AMPLITUDE_SCALE
            real, imag = slice(tone * d, (tone + 1) * d), slice((M - 1 + tone) * d, (M + tone) * d)
            jacobian[row, real], jacobian[row, imag] = answer.imag, answer.real
        jacobian[-1, real], jacobian[-1, imag] = answer.real, -answer.imag
