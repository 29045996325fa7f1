"""What the user asks for, in words, and the system and settings that it means."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from fmus.contact.friction.named import NAMED
from fmus.interface import INITIAL_VELOCITY, PULSE_FORCE
from fmus.modal.parameters import names_of

from ..coupling.assembly import Assembly, assemble, open_fmus
from ..coupling.master import Settings
from ..errors import Fault, InputError
from ..fmi.instance import Fmu, Value
from ..system.cases import SYSTEM_FILES, find_system
from ..system.friction import FRICTION
from ..system.settable import spread

RANDOM_START = 1e-3
"""Standard deviation of the random initial modal velocities [kg^1/2 m/s]."""


@dataclass(frozen=True)
class Scenario:
    """One run as a user describes it.

    Attributes
    ----------
    system : a case such as "case1", an .ssp, .ssd or .fmu file
    duration, step, algorithm : None: as the system says
    values : parameter values by component and name
    sources : FMU files that replace a component's own
    seed : random initial modal velocities instead of the force pulse
    record_every : record after every this many steps
    record : patterns of variables to record besides the outputs; None: the wheel's modal velocities
    timeout : each FMU in a process of its own, and the time that a call may take [s]; None: all in this process
    strict : whether faults of files that change no number are errors
    """

    system: str
    duration: float | None = None
    step: float | None = None
    algorithm: str | None = None
    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    sources: Mapping[str, Path] = field(default_factory=dict)
    seed: int | None = None
    record_every: int = 4
    record: tuple[str, ...] | None = None
    timeout: float | None = None
    strict: bool = False

    def absolute(self) -> Scenario:
        """Return a scenario that means the same in any folder; an FMU may go to another one while it runs."""
        file, separator, variant = self.system.partition("#")
        named = Path(file).suffix in SYSTEM_FILES
        values = {
            component: {n: str(Path(str(v)).absolute()) if _is_file(n, v) else v for n, v in own.items()}
            for component, own in self.values.items()
        }
        return replace(
            self,
            system=f"{Path(file).absolute()}{separator}{variant}" if named else self.system,
            values=values,
            sources={name: file.absolute() for name, file in self.sources.items()},
        )

    def prepare(self) -> tuple[Assembly, Settings]:
        """Return the assembled system and the settings of the run."""
        system = find_system(self.system)
        step = self.step if self.step is not None else system.step_size
        if step is None:
            raise InputError(f"{self.system}: says no step size; give a step size")
        duration = self.duration
        if duration is None:
            duration = system.stop - system.start if system.stop is not None else None
        if duration is None:
            raise InputError(f"{self.system}: says no stop time; give a duration")
        algorithm = self.algorithm or system.algorithm or "staggered"
        settings = Settings(step, duration, algorithm, self.record_every, self.record, self.timeout)
        system = system.with_sources(dict(self.sources))
        fmus = open_fmus(system)
        if self.seed is not None:
            system = system.with_parameters(random_start(fmus, self.seed))
        system = system.with_parameters(spread(self.values, fmus))
        assembly = assemble(system, fmus)
        faults = [notice for notice in assembly.notices if isinstance(notice, Fault)]
        if faults and self.strict:
            raise InputError(f"{faults[0]}; refused, as everything is read strictly")
        return assembly, settings


def _is_file(name: str, value: Value) -> bool:
    """Return whether a value is the file of a friction law."""
    return name == FRICTION and str(value) not in NAMED and Path(str(value)).is_file()


def random_start(fmus: Mapping[str, Fmu], seed: int) -> dict[str, dict[str, Value]]:
    """Return random initial modal velocities for every structure that has them, and no force pulse.

    The velocities are independent and normal with standard deviation `RANDOM_START`.
    """
    if seed < 0:
        raise InputError(f"seed = {seed}: must be >= 0")
    random = np.random.default_rng(seed)
    values: dict[str, dict[str, Value]] = {}
    for name, fmu in fmus.items():
        own: dict[str, Value] = {}
        for variable in names_of(INITIAL_VELOCITY, fmu.names("parameter")).values():
            own[variable] = float(RANDOM_START * random.standard_normal())
        if PULSE_FORCE in fmu.variables:
            own[PULSE_FORCE] = 0.0
        if own:
            values[name] = own
    return values
