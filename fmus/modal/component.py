"""The component that both wheel and rail are: modes in, declaration out."""

from __future__ import annotations

import numpy as np

from ..component import Component, Variable
from ..errors import DataError
from ..interface import (
    DEFAULT_STEP,
    DIRECTIONS,
    INITIAL_DISPLACEMENT,
    INITIAL_VELOCITY,
    MODAL_DISPLACEMENT_UNIT,
    MODAL_VELOCITY,
    MODAL_VELOCITY_UNIT,
    SHAPE_UNIT,
    STEP_SIZE,
    mobility_ports,
    structure_inputs,
    structure_outputs,
)
from .layout import DAMPING_RATIO, FREQUENCY, N_STATES, SHAPES, n_derived
from .modes import Modes
from .parameters import name_of


def structure(name: str, description: str, modes: Modes, capacity: int | None = None) -> Component:
    """Return the component of a modal structure that obeys the contract.

    Parameters
    ----------
    modes : Modes
        Start values of the modal parameters.
    capacity : int, optional
        Number of modes that the component has room for, >= len(modes); unused ones have a zero shape.
    """
    n = len(modes) if capacity is None else capacity
    if n < len(modes):
        raise DataError(f"{name}: capacity is {n}; must be at least its {len(modes)} modes")
    parameters = _modal_parameters(modes, n)
    moving, moved = (
        tuple(v.name for v in parameters if v.name.startswith((*SHAPES, start)))
        for start in (INITIAL_VELOCITY, INITIAL_DISPLACEMENT)
    )
    step = Variable(
        STEP_SIZE, "parameter", "s", "communication step that the mobilities y are given for",
        start=DEFAULT_STEP, minimum=1e-9, maximum=1e-2, nominal=DEFAULT_STEP,
    )  # fmt: skip
    inputs = tuple(
        Variable(p.name, "input", p.unit, p.description, start=0.0, nominal=p.nominal) for p in structure_inputs()
    )
    outputs = tuple(
        Variable(
            p.name, "output", p.unit, p.description, nominal=p.nominal,
            initially_depends_on=moving if p.name.startswith("v_") else moved,
        )
        for p in structure_outputs()
    )  # fmt: skip
    mobilities = tuple(
        Variable(
            p.name, "calculatedParameter", p.unit, p.description, nominal=p.nominal,
            initially_depends_on=None,
        )
        for p in mobility_ports("y")
    )  # fmt: skip
    velocities = tuple(
        Variable(
            name_of(MODAL_VELOCITY, i + 1), "local", MODAL_VELOCITY_UNIT, f"modal velocity of {_mode(modes, i)}",
            nominal=1e-3,
        )
        for i in range(n)
    )  # fmt: skip
    return Component(
        name=name,
        description=description,
        variables=(*inputs, *outputs, *mobilities, *parameters, step, *velocities),
        derived_size=n_derived(n),
        state_size=N_STATES * n,
        kernels="modal.kernels",
    )


def _mode(modes: Modes, i: int) -> str:
    """Return number and label of a mode, as descriptions give them."""
    label = modes.labels[i] if i < len(modes.labels) else ""
    return f"mode {i + 1}, {label}" if label else f"mode {i + 1}"


def _modal_parameters(modes: Modes, n: int) -> tuple[Variable, ...]:
    """Return the blocks of modal parameters, padded to `n` modes."""
    blocks = [
        (FREQUENCY, "Hz", "natural frequency", modes.omega / (2 * np.pi), 0.0, 1e6, 1e3),
        (DAMPING_RATIO, "1", "damping ratio", modes.zeta, 0.0, 1e3, 1e-3),
    ]
    blocks += [
        (SHAPES[j], SHAPE_UNIT[d], f"mass-normalised shape, {d}", modes.shape[:, j], -1e6, 1e6, 0.1)
        for j, d in enumerate(DIRECTIONS)
    ]
    rest = np.zeros(len(modes))
    blocks += [
        (INITIAL_VELOCITY, MODAL_VELOCITY_UNIT, "initial modal velocity", rest, -1e3, 1e3, 1e-3),
        (INITIAL_DISPLACEMENT, MODAL_DISPLACEMENT_UNIT, "initial modal displacement", rest, -1e3, 1e3, 1e-6),
    ]
    return tuple(
        Variable(
            name_of(name, i + 1), "parameter", unit, f"{text} of {_mode(modes, i)}",
            start=float(values[i]) if i < len(modes) else 0.0, minimum=low, maximum=high, nominal=nominal,
        )
        for name, unit, text, values, low, high, nominal in blocks
        for i in range(n)
    )  # fmt: skip
