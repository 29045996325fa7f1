"""Interface mobility of one FMU: what it publishes, or what a scratch instance shows."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS, PAIRS, STEP_SIZE

from ..fmi.instance import Fmu, FmuInstance, Value

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class PowerPair:
    """A force variable of an FMU and the velocity variable that it works on.

    Attributes
    ----------
    force, velocity : names of the FMU's variables
    force_gain, force_offset : value of the variable per newton, and at no force
    velocity_gain : metres (radians) per second per unit of the variable
    """

    force: str
    velocity: str
    force_gain: float = 1.0
    force_offset: float = 0.0
    velocity_gain: float = 1.0


def with_step(fmu: Fmu, parameters: Mapping[str, Value], step: float) -> dict[str, Value]:
    """Return the parameters with the communication step, if the FMU asks for it."""
    known = fmu.variables.get(STEP_SIZE)
    if known is not None and known.causality == "parameter":
        return {**parameters, STEP_SIZE: step}
    return dict(parameters)


def published_mobility(fmu: Fmu, parameters: Mapping[str, Value], timeout: float | None = None) -> Matrix | None:
    """Return the 4 x 4 interface mobility that an FMU puts out as calculated parameters; None if it has none."""
    names = [f"y_{row}_{column}" for row, column in PAIRS]
    if not all(name in fmu.variables for name in names):
        return None
    instance = FmuInstance(fmu, "scratch", timeout, scratch=True)
    try:
        instance.set(parameters)
        instance.enter_initialization_mode(0.0, 1.0)
        values = instance.get_real(names)
        instance.exit_initialization_mode()
    finally:
        instance.close()
    matrix = np.zeros((4, 4))
    matrix[np.triu_indices(4)] = values
    return matrix + np.triu(matrix, 1).T


def probed_mobility(
    fmu: Fmu,
    parameters: Mapping[str, Value],
    pairs: Mapping[str, PowerPair],
    step: float,
    timeout: float | None = None,
) -> Matrix:
    """Return the 4 x 4 interface mobility of any structure from one step of a scratch instance, symmetrised.

    Each direction in turn gets a unit force over one step; what the velocities then have more than without it is a
    column. Between them the instance goes back to its state at the start; an FMU that cannot is instantiated anew.
    Units and signs are those of the contact's side of the connections.
    """
    tries = [None, *(d for d in DIRECTIONS if d in pairs)]
    velocities: dict[str | None, Matrix] = {}
    with ExitStack() as stack:
        start = partial(_started, fmu, parameters, step, timeout, stack)
        instance = start()
        state = None
        if fmu.can_roll_back:
            state = instance.get_state()
            stack.callback(instance.free_state, state)
        for forced in tries:
            velocities[forced] = _velocities(instance, pairs, step, forced)
            if state is not None:
                instance.set_state(state)
            elif forced != tries[-1]:
                instance = start()
    matrix = np.zeros((4, 4))
    for column, direction in enumerate(DIRECTIONS):
        if direction in pairs:
            matrix[:, column] = velocities[direction] - velocities[None]
    return 0.5 * (matrix + matrix.T)


def _started(
    fmu: Fmu, parameters: Mapping[str, Value], step: float, timeout: float | None, stack: ExitStack
) -> FmuInstance:
    """Return a scratch instance that is ready to step; the stack closes it."""
    instance = FmuInstance(fmu, "scratch", timeout, scratch=True)
    stack.callback(instance.close)
    instance.set(parameters)
    instance.enter_initialization_mode(0.0, step)
    instance.exit_initialization_mode()
    return instance


def _velocities(instance: FmuInstance, pairs: Mapping[str, PowerPair], step: float, forced: str | None) -> Matrix:
    """Return the velocities of a structure after one step with a unit force in one direction or none."""
    if forced is not None:
        pair = pairs[forced]
        instance.set({pair.force: pair.force_gain + pair.force_offset})
    instance.do_step(0.0, step)
    velocities = np.zeros(4)
    for i, direction in enumerate(DIRECTIONS):
        if direction in pairs:
            pair = pairs[direction]
            velocities[i] = pair.velocity_gain * instance.get_real([pair.velocity])[0]
    return velocities
