"""The eigensystem realisation: free decays of any number of outputs in, modes out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

BLOCKS = 40
"""Rows and columns of blocks in the Hankel matrices, at most."""

FEWEST = 8
"""Samples below which nothing is told."""

NOISE = 1e-10
"""Singular values below this share of the largest are rounding of the decays, differences of runs."""

SEEN = 1e-6
"""Share of a decay that a mode must have to be told."""

MISFIT = 1e-4
"""Share of a decay that the modes may leave unexplained."""

DEAD = 1e-5
"""A mode that loses all but this within a sample is over at once, and has no rate."""


@dataclass(frozen=True)
class FreeModes:
    """Modes of a free decay.

    Attributes
    ----------
    s : (n,) growth rate + j angular frequency [1/s], frequencies >= 0, the fastest growth first
    """

    s: Complex


def realise(decay: Real, step: float) -> FreeModes:
    """Return the modes of free decays.

    Parameters
    ----------
    decay : (k, outputs, experiments) samples
    step : time between samples [s]

    Raises
    ------
    InputError
        If the decays are too short, or no sum of exponentials, as those of a linear system with constant coefficients.

    Notes
    -----
    Juang and Pappa 1985. Neighbouring rows and columns of the Hankel matrices stand several samples apart, so that a
    long record tells close modes apart; the second matrix is one sample later all the same, so that nothing aliases.
    """
    whole = np.abs(decay).max(axis=(0, 2), initial=0.0)
    decay = decay[2:]  # the start, and the end of the disturbed step: the rest is free
    if len(decay) < FEWEST:
        raise InputError("the response grows beyond bounds within a few steps, so its modes are not known")
    size = np.abs(decay).max(axis=(0, 2))
    seen = size > NOISE * whole  # else over at once, but for rounding
    scaled = decay[:, seen] / size[seen, None]
    size = np.abs(scaled).max(axis=(0, 1), initial=0.0)
    scaled = scaled[:, :, size > 0] / size[size > 0]
    if scaled.size == 0:
        return FreeModes(np.zeros(0, dtype=complex))
    z, C, B = _states(scaled)
    if np.abs(z).max(initial=0.0) ** len(scaled) > 1e12:
        raise InputError("the response to a disturbance is no sum of a few exponentials, so its modes are not known")
    share = np.abs(C).max(axis=0) * np.abs(B).max(axis=1) * np.maximum(1.0, np.abs(z) ** len(scaled))
    _check(scaled, z, C, B)
    kept = z[(share > SEEN * share.max(initial=0.0)) & (np.abs(z) > DEAD)]
    s = np.log(kept) / step
    s = s[s.imag >= -1e-9 / step]
    return FreeModes(s[np.argsort(-s.real)])


def _states(decay: Real) -> tuple[Complex, Complex, Complex]:
    """Return factors from sample to sample, (n,), and outputs, (p, n), and inputs, (n, m), of their states."""
    k, p, m = decay.shape
    blocks = min(BLOCKS, k // 2)
    stride = max(1, (k - 2) // (2 * (blocks - 1)))
    index = stride * (np.arange(blocks)[:, None] + np.arange(blocks))
    now, later = (decay[index + shift].transpose(0, 2, 1, 3).reshape(p * blocks, m * blocks) for shift in (0, 1))
    U, size, Vt = np.linalg.svd(now, full_matrices=False)
    n = int((size > NOISE * size[0]).sum())
    root = np.sqrt(size[:n])
    z, X = np.linalg.eig(((U[:, :n].T @ later @ Vt[:n].T) / np.outer(root, root)).astype(complex))
    return z, (U[:p, :n] * root) @ X, np.linalg.solve(X, root[:, None] * Vt[:n, :m])


def _check(decay: Real, z: Complex, C: Complex, B: Complex) -> None:
    """Raise InputError if the states do not tell the decay."""
    k = np.unique(np.linspace(0, len(decay) - 1, 200).astype(int))
    told = np.einsum("pn,kn,nm->kpm", C, z ** k[:, None], B, optimize=True).real
    if np.abs(told - decay[k]).max() > MISFIT * np.abs(decay).max():
        raise InputError(
            "the response to a disturbance is no sum of exponentials, so the system is not linear with constant "
            "coefficients"
        )
