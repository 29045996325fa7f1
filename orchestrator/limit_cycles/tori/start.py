"""Where a torus begins: a cycle and the perturbation that grows on it, as a first guess of two tones."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..balance import Balance, State
from ..hill import Sidebands, hill
from ..model import LAT
from ..refinement import solve_free
from .balance import TwoToneBalance, TwoTones
from .lines import Lines

Complex = NDArray[np.complexfloating[Any, Any]]

START = 0.01
"""Amplitude of the second tone with which a curve starts [m/s]."""

_LARGEST_CHANGE = 0.2


def start_of(
    cycle: Balance, state: State, exponent: complex, lines: Lines, folded: bool
) -> tuple[TwoToneBalance, TwoTones] | None:
    """Return equations and first guess of two tones beside a cycle; None if cycle or perturbation get lost.

    Parameters
    ----------
    exponent : of the perturbation, from the monodromy matrix [1/s]
    lines : of the two tones; cycle and perturbation are solved again with as many harmonics
    folded : whether the second frequency is that of the exponent, below half of the first; else it is that of the
        perturbation's strongest lateral line
    """
    coarse = cycle.at(lines.highest[0], lines.samples[0])
    solved = solve_free(coarse, state.resized(lines.highest[0]))
    if solved is None or abs(solved[0].amplitude / state.amplitude - 1) > _LARGEST_CHANGE:
        return None
    found = hill(coarse, solved[0], exponent)
    return None if found is None else _beside(coarse, solved[0], found, lines, folded)


def _beside(
    coarse: Balance, state: State, found: Sidebands, lines: Lines, folded: bool
) -> tuple[TwoToneBalance, TwoTones]:
    """Return a cycle with its perturbation; the strongest lateral line of that carries the second tone."""
    model, H = coarse.model_of(state), coarse.truncation.harmonics
    k = np.arange(-H, H + 1)
    s = found.exponent + 1j * k * state.omega
    T, _ = model.response(s)
    motion = (T @ found.forces[:, :, None])[:, model.active.index(LAT), 0]
    strongest = int(np.argmax(np.abs(motion)))
    scaled = found.forces * (START / (2 * motion[strongest]))
    base = int(np.argmin(np.abs(s.imag)) if folded else strongest)
    omega, carrier, offset = float(s[base].imag), strongest - base, int(k[base])
    if omega < 0:  # the perturbation is real: its conjugate is in it, too
        scaled, offset, omega, carrier = scaled[::-1].conj(), -offset, -omega, -carrier
    forces = np.zeros((len(lines.numbers), len(model.active)), complex)
    for n, (first, second) in enumerate(lines.numbers):
        if second == 0:
            forces[n] = state.forces[first]
        elif second == 1 and abs(first + offset) <= H:
            forces[n] = scaled[H + first + offset]
    balance = TwoToneBalance(model, lines, (0.01 * state.omega, 0.01 * omega), carrier)
    return balance, TwoTones(forces, (state.omega, omega), START, found.exponent.real)
