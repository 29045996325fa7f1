"""Mobilities of FMUs that show no equations: measured through FMI, sampled at the communication step.

A unit force is held over one step, then the structure is left alone. What its velocities do from then on is the impulse
response of the structure with a hold in front of it; its discrete Fourier transform is the sampled mobility

    Y(z) = sum_k v_k z^-k,  z = exp(j omega h),  v_k the velocity at the end of step k.

A record of many steps holds what is fast. What goes on after it, sampled more coarsely, is fitted with exponentials,
and the sum is continued to infinity in closed form: a wheel rings for a minute.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS

from ..errors import InputError
from ..fmi.instance import Fmu, FmuInstance, Value
from .mobility import PowerPair, with_step

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

CONTRACT = {d: PowerPair(f"f_{d}", f"v_{d}") for d in DIRECTIONS}
"""The names of the contract."""

RECORD_STEPS = 1000
"""Steps that are recorded one by one; at 5 us, 5 ms. Shorter, slow parts of the tail drown in fast ones."""

TAIL_HZ = 10e3
"""Half the rate at which the response is sampled after that: no mode above rings on longer than the record [Hz]."""

TAIL_SAMPLES = 4096
STRIDE = 16
"""Samples of the tail, and distance of neighbouring rows and columns of its Hankel matrices."""

_NOISE = 1e-13
"""Singular values below this share of the largest are rounding."""


@dataclass(frozen=True)
class Exponentials:
    """A free response as a sum: v_k = sum_i residue_i pole_i^k, k = 0, 1, ...

    Attributes
    ----------
    pole : (n,) factor from step to step
    residue : (n, 4, 4) velocity at the first sample
    """

    pole: Complex
    residue: Complex

    def transform(self, z: Complex) -> Complex:
        """Return the sum of v_k z^-k over all k >= 0, (m, 4, 4)."""
        terms = 1 / (1 - self.pole / z[:, None])
        return np.asarray(terms @ self.residue.reshape(-1, 16)).reshape(-1, 4, 4)


@dataclass(frozen=True)
class Response:
    """Velocities after a unit force was held over the first step.

    Attributes
    ----------
    step : communication step [s]
    velocity : (k, 4, 4) velocity at the end of each step, per direction of the force
    tail : what follows
    """

    step: float
    velocity: Real
    tail: Exponentials

    def sampled_mobility(self, omega: Real) -> Complex:
        """Return the sum of v_k z^-k over all steps, (m, 4, 4)."""
        steps = len(self.velocity)
        z = np.exp(1j * omega * self.step)
        flat = self.velocity.reshape(steps, 16).astype(complex)
        k = np.arange(1, steps + 1)
        parts = np.array_split(omega, max(1, omega.size // 200))
        record = np.concatenate([np.exp(-1j * np.outer(w, k) * self.step) @ flat for w in parts])
        after = self.tail.transform(z) * (z ** -(steps + 1))[:, None, None]
        return np.asarray(record.reshape(-1, 4, 4) + after)

    def mobility(self, omega: Real) -> Complex:
        """Return the mobility with the hold's delay of half a step taken out, (m, 4, 4).

        Notes
        -----
        The sampled mobility lags the continuous one by half a step, to first order. Left in, the lag is a negative
        damping of every mode with normal motion; the contact of this project looks half a step ahead, and so does this.
        """
        return np.asarray(self.sampled_mobility(omega) * np.exp(0.5j * omega * self.step)[:, None, None])

    def resonances(self) -> tuple[Real, Real]:
        """Return frequencies [Hz] and damping ratios of what rings on after the record."""
        pole = np.log(self.tail.pole[self.tail.pole.imag > 0]) / self.step
        return pole.imag / (2 * np.pi), -pole.real / np.abs(pole)


def measure(
    fmu: Fmu, parameters: Mapping[str, Value], step: float, pairs: Mapping[str, PowerPair] | None = None
) -> Response:
    """Return the response of a structure's FMU, direction by direction.

    Parameters
    ----------
    pairs : its forces and velocities by direction, default: those of the contract; a direction that is not there does
        not move

    Raises
    ------
    InputError
        If the FMU has not the forces and velocities.
    """
    pairs = CONTRACT if pairs is None else pairs
    wanted = (*(p.velocity for p in pairs.values()), *(p.force for p in pairs.values()))
    missing = [name for name in wanted if name not in fmu.variables]
    if missing:
        raise InputError(f"{fmu.path}: has no variable {missing[0]!r}, so its mobility cannot be measured")
    every = max(1, int(1 / (2 * TAIL_HZ * step)))
    parameters = with_step(fmu, parameters, step)
    still = np.zeros((RECORD_STEPS + TAIL_SAMPLES, 4))
    columns = [_column(fmu, parameters, step, every, pairs, d) if d in pairs else still for d in DIRECTIONS]
    velocity = np.stack(columns, axis=2)
    return Response(step, velocity[:RECORD_STEPS], exponentials(velocity[RECORD_STEPS:], every, STRIDE))


def _column(
    fmu: Fmu, parameters: Mapping[str, Value], step: float, every: int, pairs: Mapping[str, PowerPair], direction: str
) -> Real:
    """Return the velocities after a force in one direction: each step of the record, then the samples of the tail.

    An FMU that takes any communication step gets one long one between samples; others are stepped through.
    """
    long = bool(fmu.description.coSimulation.canHandleVariableCommunicationStepSize)
    lengths = [[step]] * (RECORD_STEPS + 1)
    lengths += [[every * step] if long else [step] * every] * (TAIL_SAMPLES - 1)
    names = [pair.velocity for pair in pairs.values()]
    places = [DIRECTIONS.index(d) for d in pairs]
    gains = np.array([pair.velocity_gain for pair in pairs.values()])
    forced = pairs[direction]
    velocity = np.zeros((len(lengths), 4))
    instance = FmuInstance(fmu, f"probe_{direction}", scratch=True)
    try:
        instance.set(parameters)
        instance.enter_initialization_mode(0.0, (RECORD_STEPS + every * TAIL_SAMPLES) * step)
        instance.exit_initialization_mode()
        instance.set({pair.force: pair.force_offset for pair in pairs.values()})
        instance.set({forced.force: forced.force_gain + forced.force_offset})
        time = 0.0
        for k, pieces in enumerate(lengths):
            for length in pieces:
                instance.do_step(time, length)
                time += length
            velocity[k, places] = gains * instance.get_real(names)
            if k == 0:
                instance.set({forced.force: forced.force_offset})
    finally:
        instance.close()
    return velocity


def exponentials(velocity: Real, every: int, stride: int) -> Exponentials:
    """Return the sum of exponentials that a free response is.

    Parameters
    ----------
    velocity : (k, 4, 4) samples, `every` steps apart
    stride : distance of neighbouring rows and columns of the Hankel matrices in samples

    Notes
    -----
    Eigensystem realisation (Juang and Pappa 1985) with rows and columns `stride` samples apart: the second Hankel
    matrix is one sample later all the same, so that nothing aliases while the record gets long enough to tell close
    modes apart. Directions are scaled to equal size first.
    """
    size = np.sqrt(np.abs(np.einsum("kii->ki", velocity)).max(axis=0))
    size = np.where(size > 0, size, 1.0)
    scaled = velocity / (size[:, None] * size)
    blocks = (len(velocity) - 2) // (2 * stride) + 1
    index = stride * (np.arange(blocks)[:, None] + np.arange(blocks))
    now, later = (scaled[index + shift].transpose(0, 2, 1, 3).reshape(4 * blocks, -1) for shift in (0, 1))
    U, s, Vt = np.linalg.svd(now)
    n = int((s > _NOISE * s[0]).sum()) if s[0] > 0 else 0
    root = np.sqrt(s[:n])
    A = (U[:, :n].T @ later @ Vt[:n].T) / np.outer(root, root)
    pole, X = np.linalg.eig(A.astype(complex))
    C = (U[:4, :n] * root) @ X
    B = np.linalg.solve(X, root[:, None] * Vt[:n, :4])
    return Exponentials(np.exp(np.log(pole) / every), np.einsum("in,nj->nij", C, B) * np.outer(size, size))
