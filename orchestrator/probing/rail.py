"""An FMU in the place of a rail, driven by hand: names mapped to the contract, forces in, motions out. No judgement."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS, Port, structure_inputs, structure_outputs

from ..errors import InputError, SimulationError
from ..fmi.instance import Fmu, FmuInstance, Value
from ..system.reader import read_system
from .mobility import with_step
from .rail_passivity import Responses

Real = NDArray[np.float64]

PORTS: dict[str, Port] = {port.name: port for port in (*structure_inputs(), *structure_outputs())}
"""The contract of a rail by name."""

OPTIONAL = ("u_lon", "u_spin")
"""Outputs that the contact does not take."""

DISPLACEMENTS = ("u_lat", "u_ver")
"""What the contact spring takes; a rail that has neither has its velocities integrated."""

NOMINAL = np.array([PORTS[f"f_{d}"].nominal for d in DIRECTIONS])
"""Amplitudes of test forces [N, N m]."""

BLOCK = 0.02
LONGEST = 0.4
"""Impulse responses are followed in blocks until they have settled, at most so long [s]."""

SETTLED = 1e-5
GROWN = 1e3
"""A response has settled, or grown without doubt, when the largest value of a block relative to the first's is this."""


@dataclass(frozen=True)
class Signal:
    """A variable of the FMU in the place of one of the contract: contract value = factor * value.

    Attributes
    ----------
    variable : name in the FMU
    factor : sign, and change of units where the FMU tells none
    unit : what a system structure says that the FMU does not; None: nothing
    """

    variable: str
    factor: float = 1.0
    unit: str | None = None


@dataclass(frozen=True)
class Motion:
    """Velocities and displacements at the ends of the steps, (n, 4) each; a displacement that is not offered is NaN."""

    velocity: Real
    displacement: Real


def read_mapping(texts: Sequence[str], fmu: Fmu) -> dict[str, Signal]:
    """Return the variable of the FMU for each name of the contract: its own name unless a text says otherwise.

    Parameters
    ----------
    texts : 'v_lat=mySpeedY', with a factor 'v_lat=-0.001*mySpeedY', or the name of an .ssd or .ssp file whose
        connections to the contact's rail_* connectors say it
    """
    mapping = {name: Signal(name) for name in PORTS if name in fmu.variables}
    for text in texts:
        if "=" not in text and Path(text).suffix in (".ssd", ".ssp"):
            mapping.update(_mapping_of_system(Path(text)))
            continue
        match = re.fullmatch(r"(\w+)=(-?)(?:([\d.]+(?:[eE][-+]?\d+)?)\*)?(\S+)", text)
        if match is None:
            raise InputError(f"mapping {text}: must be NAME=VARIABLE or NAME=FACTOR*VARIABLE, such as v_lat=-vy")
        name, minus, factor, variable = match.groups()
        if name not in PORTS:
            raise InputError(f"mapping {text}: the rail's contract has no {name!r}; it has {', '.join(PORTS)}")
        mapping[name] = Signal(variable, float(factor or 1.0) * (-1.0 if minus else 1.0))
    for name, signal in mapping.items():
        if signal.factor == 0:
            raise InputError(f"mapping {name}: the factor is 0; must not be")
    return mapping


def _mapping_of_system(path: Path) -> dict[str, Signal]:
    """Return the mapping that a system structure makes between its rail and its contact."""
    system = read_system(path)
    mapping: dict[str, Signal] = {}
    for wire in system.wires:
        if wire.end_connector.startswith("rail_"):
            name, element, variable, factor = (
                wire.end_connector, wire.start_element, wire.start_connector, wire.factor
            )  # fmt: skip
        elif wire.start_connector.startswith("rail_"):
            name, element, variable = wire.start_connector, wire.end_element, wire.end_connector
            factor = 1 / wire.factor if wire.factor else 0.0
        else:
            continue
        if wire.offset:
            raise InputError(f"{path}: connection {wire} has an offset of {wire.offset:g}; a rail's must be 0")
        if any(hop.table is not None for hop in wire.hops):
            raise InputError(f"{path}: connection {wire} looks values up in a table; a rail's must not")
        if not all(hop.convert for hop in wire.hops):
            raise InputError(f"{path}: connection {wire} suppresses the conversion of units; a rail's must not")
        mapping[name.removeprefix("rail_")] = Signal(variable, factor, system.elements[element].units.get(variable))
    unknown = sorted(set(mapping) - set(PORTS))
    if not mapping or unknown:
        raise InputError(f"{path}: connects no rail to a contact's rail_* connectors")
    return mapping


class Probe(FmuInstance):
    """A running rail with the contract's names, at rest, for steps of one size.

    Parameters
    ----------
    mapping : by name of the contract, factors for SI units; a direction without force and velocity is rigid
    step : communication step [s]
    parameters : values to set before the start
    """

    def __init__(
        self, fmu: Fmu, mapping: Mapping[str, Signal], step: float, parameters: Mapping[str, Value] | None = None
    ) -> None:
        super().__init__(fmu, "rail")
        self.step_size = step
        self._steps = 0
        moving = [d for d in DIRECTIONS if f"f_{d}" in mapping]
        self._forces = [mapping[f"f_{d}"].variable for d in moving]
        self._force_factor = np.array([1 / mapping[f"f_{d}"].factor for d in moving])
        self._moving = np.array([d in moving for d in DIRECTIONS])
        outputs = [f"{kind}_{d}" for kind in "vu" for d in DIRECTIONS]
        self._offered = np.array([name in mapping for name in outputs])
        offered = [mapping[name] for name in outputs if name in mapping]
        self._motions = [signal.variable for signal in offered]
        self._motion_factor = np.array([signal.factor for signal in offered])
        self.set(with_step(fmu, parameters or {}, step))
        self.enter_initialization_mode(0.0, 1e3)
        self.exit_initialization_mode()

    def run(self, forces: Real) -> Motion:
        """Make a step with each row of forces held over it, and return what moves.

        Raises
        ------
        SimulationError
            If a call fails or the rail puts out what is not a number.
        """
        motion = np.full((len(forces), 8), np.nan)
        motion[:, :4][:, ~self._moving] = 0.0
        rows = (forces[:, self._moving] * self._force_factor).tolist()
        for n, row in enumerate(rows):
            self.set(dict(zip(self._forces, row, strict=True)))
            self.do_step(self._steps * self.step_size, self.step_size)
            self._steps += 1
            motion[n, self._offered] = self.get_real(self._motions)
        motion[:, self._offered] *= self._motion_factor
        if not np.isfinite(motion[:, self._offered]).all():
            n = int(np.flatnonzero(~np.isfinite(motion[:, self._offered]).all(axis=1))[0])
            time = (self._steps - len(forces) + n + 1) * self.step_size
            raise SimulationError(f"rail: an output at t = {time:.6g} s is not a finite number")
        return Motion(motion[:, :4], motion[:, 4:])


def in_si(mapping: Mapping[str, Signal], factors: Mapping[str, float]) -> dict[str, Signal]:
    """Return the mapping with the factors of a change of units put in."""
    return {name: replace(signal, factor=signal.factor * factors[name]) for name, signal in mapping.items()}


def impulse_responses(
    fmu: Fmu,
    mapping: Mapping[str, Signal],
    step: float,
    parameters: Mapping[str, Value] | None = None,
    duration: float = LONGEST,
) -> Responses:
    """Return what a unit force held over the first step does, for each direction of the force.

    Each is followed until the velocity in its direction has settled, grown, or lasted for `duration` [s]; after that,
    zeros.
    """
    start = partial(Probe, fmu, mapping, step, parameters)
    columns = [_impulse_response(start, step, k, duration) for k in range(4)]
    longest = max(len(column) for column in columns)
    padded = np.stack([np.pad(column, ((0, longest - len(column)), (0, 0))) for column in columns], axis=2)
    padded[:, ~np.isfinite(padded[0])] = np.nan
    return Responses(padded[:, :4], padded[:, 4:], step)


def _impulse_response(start: Callable[[], Probe], step: float, direction: int, duration: float) -> Real:
    """Return velocities and ways (n, 8) per unit force in one direction over the first step."""
    block = max(round(BLOCK / step), 50)
    forces = np.zeros((block, 4))
    forces[0, direction] = NOMINAL[direction]
    probe = start()
    parts = [probe.run(forces)]
    first = np.abs(parts[0].velocity[:, direction]).max()
    while len(parts) * block * step < duration:
        last = np.abs(parts[-1].velocity[:, direction]).max()
        if not SETTLED * first < last < GROWN * first:
            break
        parts.append(probe.run(np.zeros((block, 4))))
    probe.close()
    ways = np.diff(np.concatenate([part.displacement for part in parts]), axis=0, prepend=0.0)
    return np.asarray(np.hstack([np.concatenate([part.velocity for part in parts]), ways]) / NOMINAL[direction])
