"""Interface mobilities: what the structures publish, or what a scratch instance shows, for the implicit contact."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS, PAIRS, STEP_SIZE

from .assembly import Assembly, Bond
from .fmu import Fmu, FmuInstance, Value

Matrix = NDArray[np.float64]


def contact_mobility(assembly: Assembly, step: float, timeout: float | None = None) -> dict[str, Value]:
    """Return the mobility parameters of the contact: the sum over the structures at its bonds, or nothing.

    Parameters
    ----------
    assembly : the system
    step : communication step that the mobilities are for [s]
    timeout : for scratch instances in processes of their own, see `FmuInstance`
    """
    if assembly.contact is None:
        return {}
    total = np.zeros((4, 4))
    structures = {bond.force.wire.end_element for bond in assembly.bonds}
    for name in sorted(structures):
        bonds = {b.direction: b for b in assembly.bonds if b.force.wire.end_element == name}
        fmu = assembly.fmus[name]
        own_step = step * assembly.periods(step)[name]
        parameters = with_step(fmu, assembly.parameters[name], own_step)
        published = published_mobility(fmu, parameters, timeout) if _as_in_contract(bonds) else None
        if published is None:
            published = probed_mobility(fmu, parameters, bonds, own_step, timeout)
        total += published
    index = {d: i for i, d in enumerate(DIRECTIONS)}
    return {f"mobility_{row}_{column}": float(total[index[row], index[column]]) for row, column in PAIRS}


def _as_in_contract(bonds: Mapping[str, Bond]) -> bool:
    """Return whether the structure has the contract's own names and units at its bonds."""
    return all(
        bond.force.wire.end_connector == f"f_{d}"
        and bond.velocity.wire.start_connector == f"v_{d}"
        and (bond.force.gain, bond.velocity.gain) == (1.0, 1.0)
        for d, bond in bonds.items()
    )


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
    bonds: Mapping[str, Bond],
    step: float,
    timeout: float | None = None,
) -> Matrix:
    """Return the 4 x 4 interface mobility of any structure from one step of a scratch instance, symmetrised.

    Each direction in turn gets a unit force over one step; what the velocities then have more than without it is a
    column. Between them the instance goes back to its state at the start; an FMU that cannot is instantiated anew.
    Units and signs are those of the contact's side of the connections.
    """
    tries = [None, *(d for d in DIRECTIONS if d in bonds)]
    velocities: dict[str | None, Matrix] = {}
    with ExitStack() as stack:
        start = partial(_started, fmu, parameters, step, timeout, stack)
        instance = start()
        state = None
        if fmu.can_roll_back:
            state = instance.get_state()
            stack.callback(instance.free_state, state)
        for forced in tries:
            velocities[forced] = _velocities(instance, bonds, step, forced)
            if state is not None:
                instance.set_state(state)
            elif forced != tries[-1]:
                instance = start()
    matrix = np.zeros((4, 4))
    for column, direction in enumerate(DIRECTIONS):
        if direction in bonds:
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


def _velocities(instance: FmuInstance, bonds: Mapping[str, Bond], step: float, forced: str | None) -> Matrix:
    """Return the velocities of a structure after one step with a unit force in one direction or none."""
    if forced is not None:
        force = bonds[forced].force
        instance.set({force.wire.end_connector: force.gain + force.offset})
    instance.do_step(0.0, step)
    velocities = np.zeros(4)
    for i, direction in enumerate(DIRECTIONS):
        if direction in bonds:
            link = bonds[direction].velocity
            velocities[i] = link.gain * instance.get_real([link.wire.start_connector])[0]
    return velocities
