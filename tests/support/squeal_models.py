"""Wheel, rail and contact of the paper's cases without FMUs, and their time domain in one compiled loop."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from fmus.compile import kernel
from fmus.component import Instance
from fmus.contact.component import contact
from fmus.interface import STEP_SIZE
from fmus.modal.component import structure
from fmus.modal.data import read_modal_data
from fmus.modal.modes import Modes
from fmus.packaging.ssp.structure import system_mobility
from fmus.rail.component import DATA as RAIL_DATA
from fmus.system.kernels import couple, feed_contact, feed_structures
from fmus.wheel.class158 import class158, identified_stiffness
from fmus.wheel.wheelset import DATA, read_wheelset
from orchestrator.limit_cycles.balance import State
from orchestrator.limit_cycles.catalogue import Catalogue, Cycle, find_cycles
from orchestrator.limit_cycles.measures import Motion
from orchestrator.limit_cycles.model import SquealModel

Real = NDArray[np.float64]

FALLING = {1: 0.1, 2: 0.1, 3: 0.0, 4: 0.0}
RIGID = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))


def rail_modes(case: int) -> Modes:
    """Return the rail of a case."""
    return read_modal_data(RAIL_DATA / "rail.toml").modes if case in {1, 3} else RIGID


@cache
def class158_case(case: int) -> SquealModel:
    """Return a case as it is shipped."""
    law = {"hertz_stiffness": identified_stiffness(), "falling_ratio": FALLING[case]}
    return SquealModel(class158().modes, rail_modes(case), law)


@cache
def generic_case(case: int) -> SquealModel:
    """Return a case with the finite-element wheel, which goes with the contact's own stiffness."""
    wheel = read_wheelset(DATA / "generic840.toml").modes
    return SquealModel(wheel, rail_modes(case), {"hertz_stiffness": 1.2e9, "falling_ratio": FALLING[case]})


@cache
def tone_of(case: int, tone_hz: float, wheel: str = "class158") -> Catalogue:
    """Return the cycles near a frequency with their stability, computed once."""
    model = class158_case(case) if wheel == "class158" else generic_case(case)
    return find_cycles(model, tone_hz=tone_hz)


def only(found: Catalogue) -> Cycle:
    """Return the one cycle of a catalogue."""
    assert len(found.cycles) == 1
    return found.cycles[0]


@kernel
def _run(wheel, rail, parts, h, steps, record):  # type: ignore[no-untyped-def]
    """Step the coupled system and record the lateral velocities of wheel and rail at every step."""
    for k in range(steps):
        couple(wheel, rail, parts, h)
        record[k, 0] = wheel[4][1]
        record[k, 1] = rail[4][1]


def fused_run(model: SquealModel, state: tuple[Real, Real], h: float, duration: float) -> Real:
    """Return lateral velocities of wheel and rail at every step, (steps, 2).

    Parameters
    ----------
    state : modal velocities and displacements at the start
    """
    assert isinstance(model.wheel, Modes)
    assert isinstance(model.rail, Modes)
    parts = [structure("wheel", "", model.wheel), structure("rail", "", model.rail)]
    wheel, rail = (Instance(p, {STEP_SIZE: h}) for p in parts)
    law = Instance(contact(system_mobility(parts, h)), {k: v for k, v in model.contact.items() if "mobility" not in k})
    n = len(model.wheel)
    for part, place in ((wheel, slice(0, n)), (rail, slice(n, None))):
        part.initialise()
        part.state[:] = np.concatenate([state[0][place], state[1][place]])
        shape = model.wheel.shape if part is wheel else model.rail.shape
        part.outputs[:] = np.concatenate([state[0][place] @ shape, state[1][place] @ shape])
    arrays = [(i.parameters, i.derived, i.state, i.inputs, i.outputs) for i in (wheel, rail, law)]
    feed_contact(*arrays)
    law.initialise()
    feed_structures(*arrays)
    record = np.zeros((round(duration / h), 2))
    _run(*arrays, h, len(record), record)
    return record


def start_of(motion: Motion, scale: float = 1.0) -> tuple[Real, Real]:
    """Return modal velocities and displacements of a cycle at the start of its period, times `scale`."""
    k = np.arange(len(motion.forces))
    lines = np.where(k == 0, 1.0, 2.0)[:, None, None] * motion.states
    velocity, displacement = scale * lines.sum(axis=0).real.T
    return velocity, displacement


def at_rest(cycle: Cycle) -> State:
    """Return the trivial solution in the place of a cycle."""
    return State(0 * cycle.state.forces, cycle.state.omega, 0.0, 0.0)
