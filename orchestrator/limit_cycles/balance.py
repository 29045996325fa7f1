"""Harmonic balance: the equations of a cycle and their Jacobian.

Unknowns are the Fourier coefficients of the contact forces, never modal ones: wheel and rail enter by their response T.
With F(t) = sum over k of F_k exp(i k w t), y_k = T(s_k) F_k and s_k = sigma + i k w (s_0 = 0) the equations are

    F_k - FFT(F(y(t)))_k = 0,   Im y_1,ref = 0,   2 Re y_1,ref = A.

One more unknown than equations: the frequency w, the amplitude A and one free number, either sigma, the damping that is
missing or left over at that amplitude, or a parameter.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..stability.poles import NORMAL
from .model import LAT, LON, SPIN, SPIN_ARM, SquealModel
from .sampling import sample_law

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

AMPLITUDE_SCALE = 0.1
"""Velocity that counts as one [m/s]."""

SIGMA_SCALE = 20.0
"""Growth rate that counts as one [1/s]."""

FORCE_SCALE = np.array([3e3, 3e3, 6e3, 30.0])
"""Forces that count as one, lon, lat, normal [N], spin [N m]."""


@dataclass(frozen=True)
class Truncation:
    """Harmonics of the forces and samples of a period."""

    harmonics: int
    samples: int


LADDER = (Truncation(12, 128), Truncation(20, 256), Truncation(40, 512), Truncation(60, 1024), Truncation(100, 2048))
"""Truncations that are tried one after the other."""


@dataclass(frozen=True)
class State:
    """A periodic motion.

    Attributes
    ----------
    forces : (H + 1, d) Fourier coefficients of the contact forces in the directions that move [N, N m]
    omega : angular frequency [rad/s]
    amplitude : of the reference velocity's first harmonic [m/s]
    free : the free unknown, sigma [1/s] or a parameter
    """

    forces: Complex
    omega: float
    amplitude: float
    free: float

    @property
    def frequency_hz(self) -> float:
        """Frequency [Hz]."""
        return self.omega / (2 * np.pi)

    def resized(self, harmonics: int) -> State:
        """Return the same motion with more or fewer harmonics."""
        forces = np.zeros((harmonics + 1, self.forces.shape[1]), complex)
        kept = min(harmonics + 1, len(self.forces))
        forces[:kept] = self.forces[:kept]
        return replace(self, forces=forces)


@dataclass(frozen=True)
class Balance:
    """The equations at one truncation, with sigma or a parameter as the free unknown.

    Attributes
    ----------
    model_at : model at a value of the free parameter; None: sigma is free and the model is `model`
    reference : direction whose first harmonic is real and has the amplitude
    omega_scale, free_scale : change that counts as one
    """

    model: SquealModel
    truncation: Truncation
    reference: int
    omega_scale: float
    free_scale: float = SIGMA_SCALE
    model_at: Callable[[float], SquealModel] | None = None

    @property
    def active(self) -> tuple[int, ...]:
        """Directions that move."""
        return self.model.active

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.active) * (2 * self.truncation.harmonics + 1) + 3

    @property
    def weights(self) -> Real:
        """Weights of the unknowns in the length of the curve."""
        w = np.full(self.size, 0.15)
        w[-3:] = 0.3, 1.0, 1.0
        return w

    def at(self, harmonics: int, samples: int) -> Balance:
        """Return the same equations at another truncation."""
        return replace(self, truncation=Truncation(harmonics, samples))

    def pack(self, state: State) -> Real:
        """Return the unknowns as scaled numbers."""
        scaled = state.forces / FORCE_SCALE[list(self.active)]
        tail = [state.omega / self.omega_scale, state.amplitude / AMPLITUDE_SCALE, state.free / self.free_scale]
        return np.concatenate([scaled[0].real, scaled[1:].real.ravel(), scaled[1:].imag.ravel(), tail])

    def unpack(self, x: Real) -> State:
        """Return the motion of scaled numbers."""
        H, d = self.truncation.harmonics, len(self.active)
        forces = np.zeros((H + 1, d), complex)
        forces[0] = x[:d]
        forces[1:] = x[d : d + H * d].reshape(H, d) + 1j * x[d + H * d : d + 2 * H * d].reshape(H, d)
        tail = x[-3:] * (self.omega_scale, AMPLITUDE_SCALE, self.free_scale)
        return State(forces * FORCE_SCALE[list(self.active)], float(tail[0]), float(tail[1]), float(tail[2]))

    def model_of(self, state: State) -> SquealModel:
        """Return the model that a state belongs to."""
        return self.model if self.model_at is None else self.model_at(state.free)

    def responses(self, state: State) -> tuple[Complex, Complex]:
        """Return the responses at the lines 0 to H and their derivatives, (H + 1, d, d); line 0 has no sigma."""
        k = np.arange(self.truncation.harmonics + 1)
        s = 1j * k * state.omega
        if self.model_at is None:
            s[1:] += state.free
        return self.model_of(state).response(s)

    def motion(self, lines: Complex) -> Real:
        """Return the samples of a motion, (N, 4), zero in the directions that do not move."""
        N = self.truncation.samples
        motion = np.zeros((N, 4))
        motion[:, list(self.active)] = np.fft.irfft(lines, N, axis=0) * N
        return motion

    def residual(self, x: Real) -> Real:
        """Return how far the equations are from zero, scaled, (size - 1,)."""
        state = self.unpack(x)
        T, _ = self.responses(state)
        return self._residual(state, (T @ state.forces[:, :, None])[:, :, 0])

    def _law(self, state: State, lines: Complex, with_slopes: bool) -> tuple[Real, Real]:
        """Return the samples of the forces, (N, d), and of their slopes, (N, d, d), or none of these."""
        contact = self.model_of(state).instance
        d, N = len(self.active), self.truncation.samples
        forces, slopes = np.empty((N, d)), np.empty((N if with_slopes else 0, d, d))
        sample_law(contact.parameters, contact.derived, np.array(self.active), self.motion(lines), forces, slopes)
        return forces, slopes

    def _residual(self, state: State, lines: Complex, forces: Real | None = None) -> Real:
        if forces is None:
            forces, _ = self._law(state, lines, with_slopes=False)
        law = np.fft.rfft(forces, axis=0)[: self.truncation.harmonics + 1] / self.truncation.samples
        r = (state.forces - law) / FORCE_SCALE[list(self.active)]
        y = self.reference_factor * lines[1, self.active.index(self.reference)]
        tail = [2 * y.imag / AMPLITUDE_SCALE, (2 * y.real - state.amplitude) / AMPLITUDE_SCALE]
        return np.concatenate([r[0].real, r[1:].real.ravel(), r[1:].imag.ravel(), tail])

    @property
    def reference_factor(self) -> float:
        """What makes the reference a velocity [m]."""
        return SPIN_ARM if self.reference == SPIN else 1.0

    def linearise(self, x: Real) -> tuple[Real, Real]:
        """Return the residual and the Jacobian, (size - 1, size)."""
        state = self.unpack(x)
        T, dT = self.responses(state)
        lines = (T @ state.forces[:, :, None])[:, :, 0]
        slope_lines = (dT @ state.forces[:, :, None])[:, :, 0]
        forces, slopes = self._law(state, lines, with_slopes=True)
        jacobian = np.zeros((self.size - 1, self.size))
        self._force_columns(jacobian, np.fft.fft(slopes, axis=0) / len(slopes), T)
        k = np.arange(len(lines))[:, None]
        self._column(jacobian, -3, slopes, 1j * k * slope_lines, self.omega_scale)
        jacobian[-1, -2] = -1.0
        residual = self._residual(state, lines, forces)
        if self.model_at is None:
            slope_lines[0] = 0.0
            self._column(jacobian, -1, slopes, slope_lines, self.free_scale)
        else:
            step = 1e-6
            ahead, behind = x.copy(), x.copy()
            ahead[-1] += step
            behind[-1] -= step
            jacobian[:, -1] = (self.residual(ahead) - self.residual(behind)) / (2 * step)
        return residual, jacobian

    def slopes(self, state: State, lines: Complex) -> Complex:
        """Return the Fourier coefficients of the slopes of the forces, (N, d, d), line k at index k modulo N."""
        _, slopes = self._law(state, lines, with_slopes=True)
        return np.fft.fft(slopes, axis=0) / len(slopes)

    def _force_columns(self, jacobian: Real, J: Complex, T: Complex) -> None:
        """Put the derivatives by the forces into the Jacobian."""
        H, d = self.truncation.harmonics, len(self.active)
        scale = FORCE_SCALE[list(self.active)]
        k = np.arange(H + 1)
        forward = J[(k[:, None] - k) % len(J)] @ T[None]  # (a, b, d, d): line a of the law per F_b
        mirrored = J[(k[:, None] + k) % len(J)] @ T.conj()[None]  # per conj(F_b)
        count, p = d * (2 * H + 1), d * (H + 1)
        jacobian[:count, :count] = in_real_numbers(forward, mirrored, scale)
        row = self.reference_factor * T[1, self.active.index(self.reference)] * scale * 2 / AMPLITUDE_SCALE
        jacobian[-2, d : 2 * d], jacobian[-2, p : p + d] = row.imag, row.real
        jacobian[-1, d : 2 * d], jacobian[-1, p : p + d] = row.real, -row.imag

    def _column(self, jacobian: Real, place: int, slopes: Real, change: Complex, scale: float) -> None:
        """Put the derivative by a number that changes the motion by `change` per unit into a column."""
        N, H = self.truncation.samples, self.truncation.harmonics
        moved = np.fft.irfft(change * scale, N, axis=0) * N
        law = np.fft.rfft((slopes @ moved[:, :, None])[:, :, 0], axis=0)[: H + 1] / N
        r = -law / FORCE_SCALE[list(self.active)]
        y = self.reference_factor * change[1, self.active.index(self.reference)] * scale
        tail = np.array([2 * y.imag, 2 * y.real]) / AMPLITUDE_SCALE
        jacobian[:, place] += np.concatenate([r[0].real, r[1:].real.ravel(), r[1:].imag.ravel(), tail])


def in_real_numbers(forward: Complex, mirrored: Complex, scale: Real) -> Real:
    """Return the derivative of scaled F - law by scaled F, both as real parts of all lines, then imaginary ones.

    Parameters
    ----------
    forward, mirrored : (M, M, d, d) lines of the law per F and per conj(F); line 0 is real and comes first
    scale : (d,) forces that count as one
    """
    M, d = forward.shape[0], forward.shape[2]
    relative = scale / scale[:, None]
    by_real, by_imag = -(forward + mirrored) * relative, -1j * (forward - mirrored) * relative
    by_real[:, 0] = -forward[:, 0] * relative

    def block(values: Complex) -> Complex:
        return values.transpose(0, 2, 1, 3).reshape(values.shape[0] * d, values.shape[1] * d)

    real, imag, m = block(by_real), block(by_imag[:, 1:]), M * d
    derivative = np.empty((2 * m - d, 2 * m - d))
    derivative[:m, :m], derivative[:m, m:] = real.real, imag.real
    derivative[m:, :m], derivative[m:, m:] = real[d:].imag, imag[d:].imag
    derivative[np.diag_indices(2 * m - d)] += 1.0
    return derivative


def reference_of(active: tuple[int, ...], motion: Complex) -> int:
    """Return the direction whose motion, (4,) of an eigenvector, is taken as reference: lat where it moves at all."""
    size = np.abs(motion) * (1.0, 1.0, 0.0, SPIN_ARM)
    if size[LAT] > 1e-6 * size.max():
        return LAT
    return max((a for a in active if a != NORMAL), key=lambda a: (size[a], a == LON))
