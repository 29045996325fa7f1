"""Where the kernels of a modal structure find what: blocks of parameters, tables, states."""

from __future__ import annotations

from ..interface import DIRECTIONS, INITIAL_DISPLACEMENT, INITIAL_VELOCITY, PAIRS

FREQUENCY = "frequency"
DAMPING_RATIO = "damping_ratio"
SHAPES = tuple(f"shape_{d}" for d in DIRECTIONS)

BLOCKS = (FREQUENCY, DAMPING_RATIO, *SHAPES, INITIAL_VELOCITY, INITIAL_DISPLACEMENT)
"""The blocks of parameters, each with a value per mode, in the order that the kernels have them."""

N_BLOCKS = len(BLOCKS)
N_TABLES = 6
"""Numbers that the exact step of a mode needs, worked out once."""

N_STATES = 2
"""Modal velocity and modal displacement."""

N_MOBILITIES = len(PAIRS)


def n_parameters(n: int) -> int:
    """Return the number of parameters of `n` modes: the blocks, then the step size."""
    return N_BLOCKS * n + 1


def n_derived(n: int) -> int:
    """Return the number of derived quantities of `n` modes: interface mobility, step, tables."""
    return N_MOBILITIES + 1 + N_TABLES * n
