"""Growth of perturbations of a cycle, at frequencies (Hill's determinant): guess in, exponent and sidebands out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .balance import Balance, State

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

_ITERATIONS = 12
_STANDS_STILL = 1e-6


@dataclass(frozen=True)
class Sidebands:
    """A perturbation exp(lambda t) times a periodic one.

    Attributes
    ----------
    exponent : lambda [1/s]
    forces : (2H + 1, d) lines -H to H of the contact forces; line k is at the frequency k f + Im(lambda)/2 pi
    """

    exponent: complex
    forces: Complex


def hill(balance: Balance, state: State, guess: complex) -> Sidebands | None:
    """Return the exponent near a guess, None if the iteration does not settle.

    Notes
    -----
    The forces of a perturbation solve (I - J T(lambda + i k w)) F = 0 with J the Toeplitz matrix of the slopes' lines;
    nonlinear inverse iteration.
    """
    model = balance.model_of(state)
    H, d = balance.truncation.harmonics, len(balance.active)
    slopes = line_slopes(balance, state)
    k = np.arange(-H, H + 1)
    toeplitz = slopes[(k[:, None] - k) % len(slopes)].transpose(0, 2, 1, 3)  # (line, d, line, d)
    value = guess
    vector: Complex = np.ones(d * k.size, complex)
    weight = vector / vector.size
    for iteration in range(_ITERATIONS):
        T, dT = model.response(value + 1j * k * state.omega)
        matrix = np.eye(d * k.size) - np.einsum("aibj,bjc->aibc", toeplitz, T, optimize=True).reshape(d * k.size, -1)
        slope = -np.einsum("aibj,bjc,bc->ai", toeplitz, dT, vector.reshape(-1, d), optimize=True).ravel()
        moved = np.linalg.solve(matrix, slope if iteration else vector)
        if iteration:
            change = (weight @ vector) / (weight @ moved)
            value = complex(value - change)
            if abs(change) < _STANDS_STILL * max(1.0, abs(value)):
                return Sidebands(value, (moved / np.linalg.norm(moved)).reshape(-1, d))
        vector = moved / np.linalg.norm(moved)
        weight = vector.conj()
    return None


def line_slopes(balance: Balance, state: State) -> Complex:
    """Return the Fourier coefficients of the slopes of the law along a cycle, (N, d, d)."""
    T, _ = balance.responses(state)
    return balance.slopes(state, (T @ state.forces[:, :, None])[:, :, 0])
