"""Mobilities of FMUs that show no equations: measured through FMI, sampled at the communication step.

A unit force is held over one step, then the structure is left alone. What its velocities do from then on is the impulse
response of the structure with a hold in front of it; its discrete Fourier transform is the sampled mobility

    Y(z) = sum_k v_k z^-k,  z = exp(j omega h),  v_k the velocity at the end of step k.

A structure that decays too slowly to wait for is fitted with exponentials first (subspace method), and the sum is
continued to infinity in closed form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.modal import Modes

from .errors import InputError
from .fmu import Fmu, FmuInstance, Value
from .frequency_domain import Mobility
from .mobility import with_step

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Response:
    """Velocities after a unit force was held over the first step.

    Attributes
    ----------
    step : communication step [s]
    velocity : (k, 4, 4) velocity at the end of each step, per direction of the force
    """

    step: float
    velocity: Real

    def sampled_mobility(self, omega: Real) -> Complex:
        """Return the sum over the record, (m, 4, 4); right where the response has died away."""
        k = np.arange(1, len(self.velocity) + 1)
        flat = self.velocity.reshape(len(k), 16)
        out = np.empty((omega.size, 16), dtype=complex)
        for i, w in enumerate(omega):
            out[i] = np.exp(-1j * w * self.step * k) @ flat
        return out.reshape(-1, 4, 4)

    @property
    def remaining(self) -> float:
        """Largest velocity in the last tenth of the record relative to the largest of all."""
        size = np.abs(self.velocity).max(axis=(1, 2))
        return float(size[-max(1, len(size) // 10) :].max() / max(size.max(), np.finfo(float).tiny))


def measure(fmu: Fmu, parameters: Mapping[str, Value], step: float, steps: int) -> Response:
    """Return the response of a structure's FMU, direction by direction.

    Raises
    ------
    InputError
        If the FMU has not the forces and velocities of the contract.
    """
    names = [f"v_{d}" for d in DIRECTIONS]
    wanted = names + [f"f_{d}" for d in DIRECTIONS]
    missing = [name for name in wanted if name not in fmu.variables]
    if missing:
        raise InputError(f"{fmu.path}: has no variable {missing[0]!r}, so its mobility cannot be measured")
    velocity = np.empty((steps, 4, 4))
    for column, direction in enumerate(DIRECTIONS):
        instance = FmuInstance(fmu, f"probe_{direction}")
        instance.set(with_step(fmu, parameters, step))
        instance.enter_initialization_mode(0.0, steps * step)
        instance.exit_initialization_mode()
        for k in range(steps):
            if k < 2:
                instance.set({f"f_{direction}": 1.0 - k})
            instance.do_step(k * step, step)
            velocity[k, :, column] = instance.get_real(names)
        instance.close()
    return Response(step, velocity)
