"""Any FMU against the contract of a rail: a file in, a row of pass / fail / not offered for each demand out.

What the file declares is compared first; then the FMU runs. Everything that is said about its dynamics comes from its
own answers to held forces.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve

from fmus.interface import DEFAULT_STEP, DIRECTIONS

from ..errors import InputError, SimulationError
from ..fmi.instance import Fmu, open_fmu
from .mobility import published_mobility, with_step
from .rail import NOMINAL, PORTS, Motion, Probe, Signal, impulse_responses, in_si, read_mapping
from .rail_declaration import FAIL, NOT_OFFERED, NOT_RUN, PASS, Check, check_declaration
from .rail_passivity import Mobility, Responses, estimate_mobility, find_activity, find_growth

Real = NDArray[np.float64]

LINEAR = 1e-6
RECIPROCAL = 1e-3
INTEGRAL = 0.25
STEPS_AGREE = 0.02
"""Largest deviations that pass, relative to the largest value: of a superposition, of transposed elements, of a
displacement from the trapezoidal integral of its velocity, of responses with other steps."""

STEP_FACTORS = {0.2: 50, 0.5: 20, 1.0: 10, 2.0: 5, 5.0: 2}
"""Steps that are tried, relative to the one asked for, and how many make ten of that."""

RANDOM_STEPS = 2000


@dataclass(frozen=True)
class RailReport:
    """What was found.

    Attributes
    ----------
    file : the FMU
    step : communication step [s]
    checks : rows in order
    mobility : point mobility from the impulse responses; None if the FMU did not run
    """

    file: Path
    step: float
    checks: tuple[Check, ...]
    mobility: Mobility | None

    @property
    def failed(self) -> tuple[Check, ...]:
        """The rows that failed."""
        return tuple(check for check in self.checks if check.status == FAIL)


def check_rail(path: Path, mapping_texts: Sequence[str] = (), step: float = DEFAULT_STEP) -> RailReport:
    """Test an FMU against the contract of a rail.

    Parameters
    ----------
    mapping_texts : see `rail_probe.read_mapping`
    step : communication step [s] of the tests

    Raises
    ------
    InputError
        If the file is no FMU that runs here, or the mapping or the step make no sense.
    """
    if not 1e-9 <= step <= 1e-2:
        raise InputError(f"step {step:g}: must be from 1e-9 to 1e-2 s")
    fmu = open_fmu(path)
    mapping = read_mapping(mapping_texts, fmu)
    declared, factors = check_declaration(fmu, mapping)
    if any(check.status == FAIL for check in declared):
        return RailReport(path, step, (*declared, Check("running", NOT_RUN, "what the FMU declares fails")), None)
    mapping = in_si(mapping, factors)
    try:
        rail = _Rail(fmu, mapping, step, impulse_responses(fmu, mapping, step))
    except SimulationError as error:
        return RailReport(path, step, (*declared, Check("running", FAIL, str(error))), None)
    checks = [_attempt(name, check, rail) for name, check in _RUNNING.items()]
    return RailReport(path, step, (*declared, *checks), estimate_mobility(rail.responses))


@dataclass
class _Rail:
    """A rail under test: FMU, mapping to SI, step, and its impulse responses."""

    fmu: Fmu
    mapping: Mapping[str, Signal]
    step: float
    responses: Responses

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
        return Probe(self.fmu, self.mapping, self.step if step is None else step)


def _attempt(name: str, check: Callable[[_Rail], tuple[str, str]], rail: _Rail) -> Check:
    """Return the row of a check; a failed call is a failure."""
    try:
        return Check(name, *check(rail))
    except SimulationError as error:
        return Check(name, FAIL, str(error))


def _verdict(ok: bool) -> str:
    return PASS if ok else FAIL


def _rest(rail: _Rail) -> tuple[str, str]:
    """Without force nothing moves: all signals are fluctuations about the steady state."""
    probe = rail.probe()
    velocity = probe.run(np.zeros((200, 4))).velocity
    probe.close()
    largest = np.abs(velocity).max(axis=0)
    j = int(np.argmax(largest))
    if largest[j] > 0:
        return FAIL, f"without force v_{DIRECTIONS[j]} reaches {largest[j]:.3g} {PORTS[f'v_{DIRECTIONS[j]}'].unit}"
    return PASS, "no force, no motion"


def _linearity(rail: _Rail) -> tuple[str, str]:
    """Random forces in all directions give the superposition of the impulse responses."""
    forces, velocity = rail.forces, rail.motion.velocity
    pulses = rail.responses.velocity[:RANDOM_STEPS]
    expected = sum(fftconvolve(pulses[:, :, k], forces[:, k : k + 1], axes=0)[:RANDOM_STEPS] for k in range(4))
    deviation = float((np.abs(velocity - expected).max(axis=0) / _largest(velocity)).max())
    return _verdict(deviation <= LINEAR), f"ten times the force and all directions at once: {deviation:.1g} off"


def _largest(values: Real) -> Real:
    """Return the largest magnitude in each column, 1 where there is none."""
    largest = np.abs(values).max(axis=0)
    return np.where(largest > 0, largest, 1.0)


def _ways(velocity: Real, step: float) -> Real:
    """Return how far each step goes by the trapezoidal rule, from rest."""
    return np.asarray(step / 2 * (velocity + np.vstack([np.zeros(4), velocity[:-1]])))


def _displacement(rail: _Rail) -> tuple[str, str]:
    """Displacements are the integrals of the velocities, during a smooth push.

    Notes
    -----
    The limit is wide: what very fast modes move between the ends of the steps is in the displacement only. Wrong signs,
    units and directions are far beyond it.
    """
    probe = rail.probe()
    motion = probe.run(np.hanning(RANDOM_STEPS)[:, None] * NOMINAL)
    probe.close()
    integral = np.cumsum(_ways(motion.velocity, rail.step), axis=0)
    offered = [j for j, d in enumerate(DIRECTIONS) if f"u_{d}" in rail.mapping]
    deviation = (np.abs(motion.displacement - integral).max(axis=0) / _largest(integral))[offered]
    worst = int(np.argmax(deviation))
    direction = DIRECTIONS[offered[worst]]
    said = f"u_{direction} is within {deviation[worst]:.1g} of the integral of v_{direction}"
    return _verdict(deviation[worst] <= INTEGRAL), said


def _passivity(rail: _Rail) -> tuple[str, str]:
    """No force history takes more energy out than it put in."""
    growing = find_growth(rail.responses)
    if growing is not None:
        return FAIL, f"active: {growing}"
    active = find_activity(estimate_mobility(rail.responses), rail.step)
    if active is not None:
        return FAIL, f"active: {active}"
    exact = np.diff(rail.motion.displacement, axis=0, prepend=0.0)
    way = np.where(np.isfinite(exact), exact, _ways(rail.motion.velocity, rail.step))
    energy = np.cumsum((rail.forces * way).sum(axis=1))
    said = f"random forces put in {energy[-1]:.3g} J and never less than {min(energy.min(), 0.0):.1g} J"
    return _verdict(energy.min() >= -1e-6 * np.abs(energy).max()), said


def _reciprocity(rail: _Rail) -> tuple[str, str]:
    """Velocity in j per force in k is velocity in k per force in j."""
    pulses = rail.responses.velocity
    size = np.abs(pulses).max(axis=0)
    diagonal = np.sqrt(np.where(np.diag(size) > 0, np.diag(size), 1.0))
    scale = np.outer(diagonal, diagonal)
    if np.allclose(size, np.diag(np.diag(size)), atol=0.0):
        return PASS, "no cross terms"
    off = np.abs(pulses - pulses.transpose(0, 2, 1)).max(axis=0) / scale
    j, k = np.unravel_index(int(np.argmax(off)), off.shape)
    said = f"{DIRECTIONS[j]} per {DIRECTIONS[k]} is {off[j, k]:.1g} off its transpose"
    return _verdict(bool(off[j, k] <= RECIPROCAL)), said


def _interface_mobility(rail: _Rail) -> tuple[str, str]:
    """Check the published interface mobility: velocity after one step per force held over it."""
    own_names = all(signal == Signal(name) for name, signal in rail.mapping.items())
    parameters = with_step(rail.fmu, {}, rail.step)
    published = published_mobility(rail.fmu, parameters) if own_names else None
    if published is None:
        return NOT_OFFERED, "y_*_* not published in the contract's names; the master measures it"
    measured = rail.responses.velocity[0]
    deviation = float(np.abs(published - measured).max() / (np.abs(measured).max() or 1.0))
    return _verdict(deviation <= LINEAR), f"published y_*_* is {deviation:.1g} off the measured one"


def _state(rail: _Rail) -> tuple[str, str]:
    """Go back to an earlier state: the same future follows."""
    if not rail.fmu.description.coSimulation.canGetAndSetFMUstate:
        return NOT_OFFERED, "canGetAndSetFMUstate is false; the coupling does not need it"
    forces = rail.forces[:400]
    probe = rail.probe()
    probe.run(forces[:200])
    state = probe.get_state()
    first = probe.run(forces[200:]).velocity
    probe.set_state(state)
    second = probe.run(forces[200:]).velocity
    probe.free_state(state)
    probe.close()
    deviation = float((np.abs(second - first).max(axis=0) / _largest(first)).max())
    return _verdict(deviation <= 1e-9), f"after going back the same steps are {deviation:.1g} off"


def _step_range(rail: _Rail) -> tuple[str, str]:
    """Answers to a suddenly applied force do not depend on the step."""
    if not rail.fmu.description.coSimulation.canHandleVariableCommunicationStepSize:
        return NOT_OFFERED, f"only {rail.step:g} s is tried: canHandleVariableCommunicationStepSize is false"
    moves, faults = {}, {}
    for factor, every in STEP_FACTORS.items():
        try:
            probe = rail.probe(factor * rail.step)
            moves[factor] = probe.run(np.tile(NOMINAL, (100 * every, 1))).velocity[every - 1 :: every]
            probe.close()
        except SimulationError as error:
            faults[factor] = str(error)
    if 1.0 not in moves:
        return FAIL, faults[1.0]
    reference = moves[min(moves)]
    off = {f: float((np.abs(v - reference).max(axis=0) / _largest(reference)).max()) for f, v in moves.items()}
    good = [factor for factor, deviation in off.items() if deviation <= STEPS_AGREE]
    said = f"{min(good) * rail.step:.2g} to {max(good) * rail.step:.2g} s agree within {STEPS_AGREE:.0%}"
    bad = [f"{f * rail.step:.2g} s is {off[f]:.0%} off" for f in off if f not in good]
    bad += [f"{f * rail.step:.2g} s: {fault}" for f, fault in faults.items()]
    return _verdict({0.5, 1.0} <= set(good)), "; ".join([said, *bad])


_RUNNING: dict[str, Callable[[_Rail], tuple[str, str]]] = {
    "rest": _rest,
    "linearity": _linearity,
    "displacement": _displacement,
    "passivity": _passivity,
    "reciprocity": _reciprocity,
    "interface mobility": _interface_mobility,
    "get and set state": _state,
    "step sizes": _step_range,
}
