"""What the user asks for, in words, and the system and settings that it means."""

from __future__ import annotations

import hashlib
import re
import shutil
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import fmus as components
from fmus.interface import INITIAL_VELOCITY, PULSE_FORCE
from fmus.packaging.build import SSP_NAME, build, default_target
from fmus.packaging.system_structure import SSP_FOLDER, read_cases

from .archive import cache_folder
from .assembly import Assembly, assemble, open_fmus
from .errors import InputError
from .fmu import Fmu, Value
from .master import Settings
from .system import System, read_system

RANDOM_START = 1e-3
"""Standard deviation of the random initial modal velocities [kg^1/2 m/s]."""


@dataclass(frozen=True)
class Scenario:
    """One run as a user describes it.

    Attributes
    ----------
    system : a case such as "case1", an .ssp or an .ssd file
    duration, step, algorithm : None: as the system says
    values : parameter values by component and name
    sources : FMU files that replace a component's own
    seed : random initial modal velocities instead of the force pulse
    record_every : record after every this many steps
    record : patterns of variables to record besides the outputs; None: the wheel's modal velocities
    timeout : each FMU in a process of its own, and the time that a call may take [s]; None: all in this process
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

    def prepare(self) -> tuple[Assembly, Settings]:
        """Return the assembled system and the settings of the run."""
        system = find_system(self.system)
        step = self.step if self.step is not None else system.step_size
        if step is None:
            raise InputError(f"{self.system}: says no step size; give --step")
        duration = self.duration
        if duration is None:
            duration = system.stop - system.start if system.stop is not None else None
        if duration is None:
            raise InputError(f"{self.system}: says no stop time; give --duration")
        algorithm = self.algorithm or system.algorithm or "staggered"
        settings = Settings(step, duration, algorithm, self.record_every, self.record, self.timeout)
        system = system.with_sources(dict(self.sources))
        fmus = open_fmus(system)
        if self.seed is not None:
            system = system.with_parameters(random_start(fmus, self.seed))
        system = system.with_parameters({name: dict(values) for name, values in self.values.items()})
        return assemble(system, fmus), settings


def find_system(text: str) -> System:
    """Return the system of a case name or a file."""
    path = Path(text)
    if path.suffix in (".ssp", ".ssd") or ".ssp#" in path.name:
        return read_system(path)
    names = [case.name for case in read_cases()]
    if text not in names:
        raise InputError(f"{text}: neither a case ({', '.join(names)}) nor an .ssp or .ssd file")
    return read_system(built_ssp(), variant=text)


def built_ssp() -> Path:
    """Return the project's own SSP, built when its sources have changed since the last time."""
    digest = hashlib.sha256()
    package = Path(components.__file__).parent
    for folder, pattern in ((package, "*"), (SSP_FOLDER, "*.toml")):
        for path in sorted(folder.rglob(pattern)):
            if path.is_file() and "__pycache__" not in path.parts:
                digest.update(path.name.encode() + path.read_bytes())
    try:
        target = default_target()
    except ValueError as error:
        raise InputError(f"the FMUs of the cases cannot be built here: {error}") from None
    digest.update(str(target).encode())
    folder = cache_folder().parent / "built"
    final = folder / digest.hexdigest()[:32]
    if not final.is_dir():
        folder.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(dir=folder, prefix="building-"))
        try:
            build(temporary, target, only_cases=True)
            temporary.replace(final)
        except OSError:  # somebody else was faster
            if not final.is_dir():
                raise
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
    return final / SSP_NAME


def random_start(fmus: Mapping[str, Fmu], seed: int) -> dict[str, dict[str, Value]]:
    """Return random initial modal velocities for every structure that has them, and no force pulse.

    The velocities are independent and normal with standard deviation `RANDOM_START`.
    """
    random = np.random.default_rng(seed)
    values: dict[str, dict[str, Value]] = {}
    for name, fmu in fmus.items():
        own: dict[str, Value] = {}
        for variable in fmu.names("parameter"):
            if variable.startswith(INITIAL_VELOCITY):
                own[variable] = float(RANDOM_START * random.standard_normal())
        if PULSE_FORCE in fmu.variables:
            own[PULSE_FORCE] = 0.0
        if own:
            values[name] = own
    return values


def parse_values(texts: Iterable[str]) -> dict[str, dict[str, Value]]:
    """Return parameter values of texts such as 'contact.mu0=0.35'."""
    values: dict[str, dict[str, Value]] = {}
    for text in texts:
        match = re.fullmatch(r"([^.=\s]+)\.([^=\s]+)=(.+)", text)
        if match is None:
            raise InputError(f"--set {text}: must be COMPONENT.PARAMETER=VALUE, such as contact.mu0=0.35")
        component, name, value = match.groups()
        values.setdefault(component, {})[name] = value
    return values


def parse_sources(texts: Iterable[str]) -> dict[str, Path]:
    """Return replacements of texts such as 'rail=my-rail.fmu'."""
    sources = {}
    for text in texts:
        name, separator, file = text.partition("=")
        if not (name and separator and file):
            raise InputError(f"--replace {text}: must be COMPONENT=FILE.fmu, such as rail=my-rail.fmu")
        sources[name] = Path(file)
    return sources
