"""Systems ready to run: the base of a campaign and a point in, an assembly with the point's values out.

FMUs are known by their content. The process that reads the plan packs them; any process, on any machine, unpacks them
once and keeps what it has prepared.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from fmus.cache import cache_folder, mark_used
from fmus.interface import INITIAL_DISPLACEMENT, INITIAL_VELOCITY
from fmus.wheel.wheelset import Wheelset

from ..archive import sha256
from ..coupling.assembly import Assembly, assemble, open_fmus
from ..coupling.settings import Settings
from ..errors import InputError
from ..fmi.instance import Fmu, Value
from ..runs.identity import component
from ..runs.scenario import random_start
from ..runs.starts import mode_start
from ..stability.poles import Structure
from ..stability.tracking import TrackedPoles
from ..system.cases import find_system
from ..system.model import Element, System, listing
from ..system.values import component_values
from .ends import Ends
from .factors import SEED, START_HZ
from .plan import Plan, split
from .shipped import shipped_fmu


@dataclass(frozen=True)
class Campaign:
    """All that a worker needs to know of a plan.

    Attributes
    ----------
    plan : what varies and what is computed
    system : the base, its components' sources being checksums
    settings : of the run of the base
    sources : checksum of each FMU that takes a place, by what the plan calls it
    names : file name of each FMU by checksum, for messages
    """

    plan: Plan
    system: System
    settings: Settings
    sources: Mapping[str, str]
    names: Mapping[str, str]

    @cached_property
    def system_digest(self) -> str:
        """Hash of the base and of how it is run: FMUs, values, wires; where its files lie does not count."""
        elements = {
            name: replace(e, parameters={key: replace(p, origin=None) for key, p in sorted(e.parameters.items())})
            for name, e in self.system.elements.items()
        }
        plain = replace(self.system, name="", path=Path(), elements=elements, variants=(), notices=())
        return hashlib.sha256(repr((plain, self.settings, sorted(self.sources.items()))).encode()).hexdigest()

    @property
    def digest(self) -> str:
        """Hash of the plan and of the system that it is for."""
        return hashlib.sha256(f"{self.plan.digest} {self.system_digest}".encode()).hexdigest()


@dataclass
class Workshop:
    """What a process keeps between runs.

    Attributes
    ----------
    assemblies : by the checksums in the places of the components
    structures : what is known of them, by the hash of FMU and values
    poles : of the system that was looked at last
    wheelsets : by the hash of FMU and values; None: not known
    ends : cycles that runs may end in, by the hashes of the components and the tone; None: no pole is near
    """

    assemblies: dict[tuple[str, ...], Assembly] = field(default_factory=dict)
    structures: dict[str, Structure] = field(default_factory=dict)
    poles: TrackedPoles = field(default_factory=TrackedPoles)
    wheelsets: dict[str, Wheelset | None] = field(default_factory=dict)
    ends: dict[str, Ends | None] = field(default_factory=dict)


@dataclass(frozen=True)
class Prepared:
    """A system that is ready for a stage.

    Attributes
    ----------
    assembly, settings : what to run and how
    workshop : what the process keeps
    compare : whether the end of a run is looked for among the limit cycles
    """

    assembly: Assembly
    settings: Settings
    workshop: Workshop
    compare: bool = True


def pack(plan: Plan) -> tuple[Campaign, dict[str, bytes]]:
    """Return a campaign and the content of its FMUs by checksum.

    Raises
    ------
    InputError
        If the system or an FMU is not there.
    """
    system = find_system(plan.base.system)
    step = plan.base.step or system.step_size
    if step is None:
        raise InputError(f"{plan.base.system}: says no step size; give [system] step")
    duration = plan.base.duration
    if duration is None and system.stop is not None:
        duration = system.stop - system.start
    if duration is None:
        raise InputError(f"{plan.base.system}: says no stop time; give [system] duration")
    every = plan.compute.record_every
    record = None if plan.compute.sound else ()
    settings = Settings(step, duration, plan.base.algorithm or system.algorithm or "staggered", every, record)
    files = {name: element.source for name, element in system.elements.items()}
    asked = {text: _file(text) for text in _asked(plan)}
    checksums = {path: sha256(path) for path in {*files.values(), *asked.values()}}
    elements = {n: replace(e, source=Path(checksums[files[n]])) for n, e in system.elements.items()}
    names = {checksum: path.name for path, checksum in checksums.items()}
    sources = {text: checksums[path] for text, path in asked.items()}
    contents = {checksum: path.read_bytes() for path, checksum in checksums.items()}
    return Campaign(plan, replace(system, elements=elements), settings, sources, names), contents


def _asked(plan: Plan) -> set[str]:
    """Return what the plan calls the FMUs that take a place: files and names of shipped ones."""
    found = set(plan.base.sources.values())
    for name, factor in plan.factors.items():
        if name not in plan.choices and name not in (SEED, START_HZ) and "." not in name:
            levels = factor.levels()
            found |= {str(v) for v in ([] if levels is None else levels)}
    for choice in plan.choices.values():
        for what in choice.values():
            found |= {str(v) for key, v in what.items() if "." not in key}
    return found


def _file(text: str) -> Path:
    path = Path(text)
    if path.suffix != ".fmu":
        return shipped_fmu(text)
    if not path.is_file():
        raise InputError(f"{text}: no such FMU")
    return path


def content_folder() -> Path:
    """Return where the FMUs of campaigns are kept, by checksum."""
    return cache_folder("campaigns")


def keep(contents: Mapping[str, bytes]) -> None:
    """Write FMUs that this machine does not have yet."""
    folder = content_folder()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    for checksum, content in contents.items():
        final = folder / f"{checksum}.fmu"
        if final.is_file() and sha256(final) == checksum:
            mark_used(final)
            continue
        handle, temporary = tempfile.mkstemp(dir=folder)
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        Path(temporary).replace(final)


def prepare(campaign: Campaign, workshop: Workshop, point: Mapping[str, Value]) -> Assembly:
    """Return the assembly of a point.

    Raises
    ------
    InputError
        If a component or parameter is not there, or a value is out of its range.
    """
    plan = campaign.plan
    sources, values = dict(plan.base.sources), {n: dict(v) for n, v in plan.base.values.items()}
    for key, value in _settings_of(plan, point).items():
        if "." in key:
            component, parameter = split(key, "[vary]")
            values.setdefault(component, {})[parameter] = value
        elif key not in (SEED, START_HZ):
            sources[key] = str(value)
    base = _base(campaign, workshop, sources)
    seed = point.get(SEED, plan.base.seed)
    if seed is not None:
        base = _with(base, random_start(base.fmus, int(seed)))
    changed = _with(base, values)
    if START_HZ in point:
        changed = _started(changed, float(point[START_HZ]))
    return changed


def _settings_of(plan: Plan, point: Mapping[str, Value]) -> dict[str, Value]:
    """Return a point with each choice replaced by what it sets."""
    flat: dict[str, Value] = {}
    for name, value in point.items():
        flat.update(plan.choices[name][str(value)] if name in plan.choices else {name: value})
    return flat


def _base(campaign: Campaign, workshop: Workshop, sources: Mapping[str, str]) -> Assembly:
    """Return the assembly of the FMUs in their places, without a point's values."""
    elements = dict(campaign.system.elements)
    for name, text in sources.items():
        if name not in elements:
            raise InputError(f"the system has no component {name!r}; it has {listing(elements)}")
        elements[name] = replace(elements[name], source=Path(campaign.sources[text]))
    key = tuple(str(element.source) for element in elements.values())
    if key not in workshop.assemblies:
        there = {n: replace(e, source=content_folder() / f"{e.source}.fmu") for n, e in elements.items()}
        system = replace(campaign.system, elements=there)
        fmus = {name: replace(fmu, path=Path(campaign.names[fmu.checksum])) for name, fmu in open_fmus(system).items()}
        workshop.assemblies[key] = assemble(system, fmus)
    return workshop.assemblies[key]


def _with(assembly: Assembly, values: Mapping[str, Mapping[str, Value]]) -> Assembly:
    """Return an assembly with other parameter values, checked as those of a scenario are."""
    system = assembly.system.with_parameters({name: dict(own) for name, own in values.items()})
    parameters = dict(assembly.parameters)
    for name, element in system.elements.items():
        before = assembly.system.elements[name]
        if element is not before:
            changed = {k: p for k, p in element.parameters.items() if before.parameters.get(k) is not p}
            parameters[name] = {**parameters[name], **_converted(element, changed, assembly.fmus[name])}
    return replace(assembly, system=system, parameters=parameters)


def _converted(element: Element, changed: Mapping[str, object], fmu: Fmu) -> dict[str, Value]:
    own = {k: p for k, p in element.parameters.items() if k in changed}
    return component_values(replace(element, parameters=own), fmu).values


def structure_key(fmu: Fmu, values: Mapping[str, Value]) -> str:
    """Return the hash of an FMU and its values but for how it starts."""
    start = (INITIAL_VELOCITY, INITIAL_DISPLACEMENT)
    return component(fmu, {name: value for name, value in values.items() if not name.startswith(start)})


def _started(assembly: Assembly, frequency_hz: float) -> Assembly:
    """Return an assembly whose wheel starts on the mode near a frequency."""
    wheel = assembly.fmus.get("wheel")
    if wheel is None:
        raise InputError("the system has no component 'wheel' whose mode could start")
    start = mode_start(wheel, assembly.parameters["wheel"], frequency_hz)
    return replace(assembly, parameters={**assembly.parameters, "wheel": {**assembly.parameters["wheel"], **start}})
