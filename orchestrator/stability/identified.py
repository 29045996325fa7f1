"""A structure that shows no modes: its FMU in, poles and shapes of its response out.

The response to a force held over one step is a record of every step and, after it, a tail fitted with exponentials
(`probing.response`). What the tail's slow exponentials leave of the record is fast and is fitted the same way; together
they are the structure, in continuous time.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..fmi.file import Fmu
from ..fmi.instance import Value
from ..probing.mobility import PowerPair
from ..probing.response import Exponentials, Response, exponentials, measure
from .poles import Identified

SLOW = 1e-4
"""An exponential is taken from the tail if at least this share of it is left when the record ends: a smaller one is
told better by the record than by what is left of it, ten digits below its start."""

FAST_SAMPLES = 400
FAST_STRIDE = 2
"""Samples of the record that the fast exponentials are fitted to, 2 ms at 5 us, and distance of the Hankel rows."""


def identify(fmu: Fmu, parameters: Mapping[str, Value], step: float, pairs: Mapping[str, PowerPair]) -> Identified:
    """Return a structure as its response to forces tells it.

    Parameters
    ----------
    step : communication step at which it is driven [s]
    pairs : its forces and velocities by direction

    Raises
    ------
    InputError
        If the FMU cannot be driven.
    """
    return continuous(measure(fmu, parameters, step, pairs))


def continuous(response: Response) -> Identified:
    """Return the structure in continuous time.

    Notes
    -----
    With C, B and s of an exponential, a force held over one step of h leaves C B (exp(s h) - 1)/s of velocity at its
    end; a repeated direction of residues would need more than one state for a pole, so each residue is parted into as
    many as its singular values say.
    """
    tail, h, record = response.tail, response.step, response.velocity
    kept = np.abs(tail.pole) ** len(record) >= SLOW
    slow = tail.pole[kept]
    at_start = tail.residue[kept] * (slow ** -len(record))[:, None, None]
    k = np.arange(min(FAST_SAMPLES, len(record)))
    rest = record[k] - np.einsum("ki,iab->kab", slow ** k[:, None], at_start).real
    fast = _decaying(exponentials(rest, 1, FAST_STRIDE))
    pole = np.concatenate([slow, fast.pole])
    residue = np.concatenate([at_start, fast.residue])
    return _states(np.log(pole.astype(complex)) / h, residue, h)


def _decaying(found: Exponentials) -> Exponentials:
    """Return the exponentials that have died away where the tail begins; others would be told twice."""
    keep = (np.abs(found.pole) < 1.0) & (np.abs(found.pole) > 1e-12)
    return Exponentials(found.pole[keep], found.residue[keep])


def _states(s: np.ndarray, residue: np.ndarray, h: float) -> Identified:
    """Return states of poles s [1/s] whose residues are (n, 4, 4) velocities at the end of the first step."""
    left, size, right = np.linalg.svd(residue * (s / np.expm1(s * h))[:, None, None])
    n, r = np.nonzero(size > 1e-9 * size.max(axis=1, initial=1e-300)[:, None])
    root = np.sqrt(size[n, r])[:, None]
    return Identified(s[n], (left[n, :, r] * root).T, right[n, r, :] * root)
