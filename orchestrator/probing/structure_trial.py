"""A structure that runs, judged row by row: what it does that would make a run worthless. No files, no declarations.

`check` shows the rows; a run refuses a replaced structure by the same ones.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS

from ..errors import SimulationError
from ..fmi.instance import Fmu, Value
from .mobility import published_mobility, with_step
from .rail import NOMINAL, PORTS, Motion, Probe, Signal
from .rail_declaration import FAIL, NOT_OFFERED, PASS
from .rail_passivity import Responses, estimate_mobility, find_activity, find_growth, find_lateness

Real = NDArray[np.float64]

LINEAR = 1e-6
RECIPROCAL = 1e-3
INTEGRAL = 0.25
"""Largest deviations that pass, relative to the largest value: of a superposition, of transposed elements, of a
displacement from the trapezoidal integral of its velocity."""

STEPS_AGREE = 0.02
"""Largest deviation of responses with other steps that passes, relative to the largest value."""

STEP_FACTORS = {0.2: 50, 0.5: 20, 1.0: 10, 2.0: 5, 5.0: 2}
"""Steps that are tried, relative to the one asked for, and how many make ten of that."""

LIGHTEST = 0.1
"""Mass that no wheel or rail is lighter than at the contact within one step [kg]; theirs are 1 to 10 kg."""

RANDOM_STEPS = 2000


@dataclass
class Trial:
    """A structure under test: FMU, mapping to SI, step, its impulse responses, and values of its parameters."""

    fmu: Fmu
    mapping: Mapping[str, Signal]
    step: float
    responses: Responses
    parameters: Mapping[str, Value] = field(default_factory=dict)

    @cached_property
    def forces(self) -> Real:
        """Forces with a mean and a scatter of ten nominal ones, always the same."""
        return np.asarray(10 * NOMINAL * (1 + np.random.default_rng(1).standard_normal((RANDOM_STEPS, 4))))

    @cached_property
    def motion(self) -> Motion:
        """What these forces do to the rail at rest."""
        probe = self.probe()
        motion = probe.run(self.forces)
        probe.close()
        return motion

    def probe(self, step: float | None = None) -> Probe:
        """Return a new instance."""
        return Probe(self.fmu, self.mapping, self.step if step is None else step, self.parameters)


def _rest(trial: Trial) -> tuple[str, str]:
    """Without force nothing moves: all signals are fluctuations about the steady state."""
    probe = trial.probe()
    velocity = probe.run(np.zeros((200, 4))).velocity
    probe.close()
    largest = np.abs(velocity).max(axis=0)
    j = int(np.argmax(largest))
    if largest[j] > 0:
        return FAIL, f"without force v_{DIRECTIONS[j]} reaches {largest[j]:.3g} {PORTS[f'v_{DIRECTIONS[j]}'].unit}"
    return PASS, "no force, no motion"


def _linearity(trial: Trial) -> tuple[str, str]:
    """Random forces in all directions give the superposition of the impulse responses."""
    from scipy.signal import fftconvolve  # noqa: PLC0415

    forces, velocity = trial.forces, trial.motion.velocity
    pulses = trial.responses.velocity[:RANDOM_STEPS]
    expected = sum(fftconvolve(pulses[:, :, k], forces[:, k : k + 1], axes=0)[:RANDOM_STEPS] for k in range(4))
    deviation = float((np.abs(velocity - expected).max(axis=0) / largest_of(velocity)).max())
    said = f"ten times the force and all directions at once: {deviation:.1g} off"
    return (PASS, said) if deviation <= LINEAR else (FAIL, f"not linear: {said}")


def largest_of(values: Real) -> Real:
    """Return the largest magnitude in each column, 1 where there is none."""
    largest = np.abs(values).max(axis=0)
    return np.where(largest > 0, largest, 1.0)


def _ways(velocity: Real, step: float) -> Real:
    """Return how far each step goes by the trapezoidal rule, from rest."""
    return np.asarray(step / 2 * (velocity + np.vstack([np.zeros(4), velocity[:-1]])))


def _displacement(trial: Trial) -> tuple[str, str]:
    """Displacements are the integrals of the velocities, during a smooth push.

    Notes
    -----
    The limit is wide: what very fast modes move between the ends of the steps is in the displacement only. Wrong signs,
    units and directions are far beyond it.
    """
    offered = [j for j, d in enumerate(DIRECTIONS) if f"u_{d}" in trial.mapping]
    if not offered:
        return NOT_OFFERED, "no displacements"
    probe = trial.probe()
    motion = probe.run(np.hanning(RANDOM_STEPS)[:, None] * NOMINAL)
    probe.close()
    integral = np.cumsum(_ways(motion.velocity, trial.step), axis=0)
    deviation = (np.abs(motion.displacement - integral).max(axis=0) / largest_of(integral))[offered]
    worst = int(np.argmax(deviation))
    direction = DIRECTIONS[offered[worst]]
    if deviation[worst] > INTEGRAL:
        return FAIL, f"u_{direction} is {deviation[worst]:.1g} off the integral of v_{direction}"
    return PASS, f"u_{direction} is within {deviation[worst]:.1g} of the integral of v_{direction}"


def _passivity(trial: Trial) -> tuple[str, str]:
    """No force history takes more energy out than it put in."""
    late = find_lateness(trial.responses)
    if late is not None:
        return FAIL, f"{late}; outputs are those at the end of the step"
    growing = find_growth(trial.responses)
    if growing is not None:
        return FAIL, f"active: {growing}"
    active = find_activity(estimate_mobility(trial.responses), trial.step)
    if active is not None:
        return FAIL, f"active: {active}"
    exact = np.diff(trial.motion.displacement, axis=0, prepend=0.0)
    way = np.where(np.isfinite(exact), exact, _ways(trial.motion.velocity, trial.step))
    energy = np.cumsum((trial.forces * way).sum(axis=1))
    said = f"random forces put in {energy[-1]:.3g} J and never less than {min(energy.min(), 0.0):.1g} J"
    return (PASS, said) if energy.min() >= -1e-6 * np.abs(energy).max() else (FAIL, f"active: {said}")


def _reciprocity(trial: Trial) -> tuple[str, str]:
    """Velocity in j per force in k is velocity in k per force in j."""
    pulses = trial.responses.velocity
    size = np.abs(pulses).max(axis=0)
    diagonal = np.sqrt(np.where(np.diag(size) > 0, np.diag(size), 1.0))
    scale = np.outer(diagonal, diagonal)
    if np.allclose(size, np.diag(np.diag(size)), atol=0.0):
        return PASS, "no cross terms"
    off = np.abs(pulses - pulses.transpose(0, 2, 1)).max(axis=0) / scale
    j, k = np.unravel_index(int(np.argmax(off)), off.shape)
    said = f"{DIRECTIONS[j]} per {DIRECTIONS[k]} is {off[j, k]:.1g} off its transpose"
    return (PASS, said) if off[j, k] <= RECIPROCAL else (FAIL, f"not reciprocal: {said}")


def _interface_mobility(trial: Trial) -> tuple[str, str]:
    """Velocity after one step per force held over it: of the right sign and size, and what is published."""
    measured = trial.responses.velocity[0]
    fault = mobility_fault(measured, trial.step)
    if fault is not None:
        return FAIL, fault
    own_names = all(signal == Signal(name) for name, signal in trial.mapping.items())
    parameters = with_step(trial.fmu, trial.parameters, trial.step)
    published = published_mobility(trial.fmu, parameters) if own_names else None
    if published is None:
        return NOT_OFFERED, "y_*_* not published in the contract's names; the master measures it"
    return published_verdict(published, measured)


def mobility_fault(measured: Real, step: float) -> str | None:
    """Return what is wrong with the diagonal of an interface mobility (4, 4) for a step [s]; None if nothing is."""
    for j, d in enumerate(DIRECTIONS):
        own = float(measured[j, j])
        if own < 0:
            return f"wrong sign: a {d} force moves it the other way, {own:.3g} m/s per newton after a step"
        if d != "spin" and own > step / LIGHTEST:
            return (
                f"wrong units: a {d} force of 1 N moves it by {own:.3g} m/s in a step, as if it had a mass of "
                f"{step / own:.1g} kg"
            )
    return None


def published_verdict(published: Real, measured: Real) -> tuple[str, str]:
    """Return whether a published interface mobility is the measured one, and how far it is off."""
    deviation = float(np.abs(published - measured).max() / (np.abs(measured).max() or 1.0))
    said = f"published y_*_* is {deviation:.1g} off the measured one"
    return (PASS, said) if deviation <= LINEAR else (FAIL, said)


def _verdict(ok: bool) -> str:
    return PASS if ok else FAIL


def _state(trial: Trial) -> tuple[str, str]:
    """Go back to an earlier state: the same future follows."""
    if not trial.fmu.description.coSimulation.canGetAndSetFMUstate:
        return NOT_OFFERED, "canGetAndSetFMUstate is false; the coupling does not need it"
    forces = trial.forces[:400]
    probe = trial.probe()
    probe.run(forces[:200])
    state = probe.get_state()
    first = probe.run(forces[200:]).velocity
    probe.set_state(state)
    second = probe.run(forces[200:]).velocity
    probe.free_state(state)
    probe.close()
    deviation = float((np.abs(second - first).max(axis=0) / largest_of(first)).max())
    return _verdict(deviation <= 1e-9), f"after going back the same steps are {deviation:.1g} off"


def _step_range(trial: Trial) -> tuple[str, str]:
    """Answers to a suddenly applied force do not depend on the step."""
    if not trial.fmu.description.coSimulation.canHandleVariableCommunicationStepSize:
        return NOT_OFFERED, f"only {trial.step:g} s is tried: canHandleVariableCommunicationStepSize is false"
    moves, faults = {}, {}
    for factor, every in STEP_FACTORS.items():
        try:
            probe = trial.probe(factor * trial.step)
            moves[factor] = probe.run(np.tile(NOMINAL, (100 * every, 1))).velocity[every - 1 :: every]
            probe.close()
        except SimulationError as error:
            faults[factor] = str(error)
    if 1.0 not in moves:
        return FAIL, faults[1.0]
    reference = moves[min(moves)]
    off = {f: float((np.abs(v - reference).max(axis=0) / largest_of(reference)).max()) for f, v in moves.items()}
    good = [factor for factor, deviation in off.items() if deviation <= STEPS_AGREE]
    said = f"{min(good) * trial.step:.2g} to {max(good) * trial.step:.2g} s agree within {STEPS_AGREE:.0%}"
    bad = [f"{f * trial.step:.2g} s is {off[f]:.0%} off" for f in off if f not in good]
    bad += [f"{f * trial.step:.2g} s: {fault}" for f, fault in faults.items()]
    return _verdict({0.5, 1.0} <= set(good)), "; ".join([said, *bad])


ROWS: dict[str, Callable[[Trial], tuple[str, str]]] = {
    "rest": _rest,
    "linearity": _linearity,
    "displacement": _displacement,
    "passivity": _passivity,
    "reciprocity": _reciprocity,
    "interface mobility": _interface_mobility,
    "get and set state": _state,
    "step sizes": _step_range,
}

_FIRST = ("rest", "interface mobility", "displacement")
"""Rows that say most simply what is wrong."""


def first_fault(trial: Trial) -> str | None:
    """Return what is wrong with a structure; None if nothing is."""
    for name in (*_FIRST, *ROWS):
        try:
            status, said = ROWS[name](trial)
        except SimulationError as error:
            return str(error)
        if status == FAIL:
            return said
    return None
