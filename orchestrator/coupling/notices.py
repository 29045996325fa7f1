"""What a user should know before a run: an assembled system and settings in, sentences out."""

from __future__ import annotations

from collections.abc import Iterator

from ..system.friction import beyond_table
from .algorithms import find_algorithm
from .assembly import Assembly
from .rates import is_multiple
from .settings import Settings


def notices(assembly: Assembly, settings: Settings) -> Iterator[str]:
    """Yield a sentence for each choice that is made without being asked for, and for each risk that is known."""
    if not settings.whole:
        yield (
            f"a duration of {settings.duration:g} s is no whole number of steps of {settings.step:g} s: the run ends "
            f"at {settings.stop(assembly.system.start):g} s"
        )
    if not find_algorithm(settings.algorithm).simultaneous:
        yield from assembly.coupling.guesses()
    elif assembly.contact is not None:
        yield "jacobi delays the contact force by a step and can invent squeal; staggered does not"
    elif assembly.links:
        yield "jacobi gives every component the outputs of the step before, which can make a stable system grow"
    for name, count in assembly.periods(settings.step).items():
        if count > 1:
            yield f"{name} makes one step of {settings.step * count:g} s in {count} communication steps"
    yield from _of_friction(assembly)
    yield from _of_fmus(assembly, settings.step)


def _of_friction(assembly: Assembly) -> Iterator[str]:
    """Yield where the friction law of a contact is used outside its data."""
    for name, fmu in assembly.fmus.items():
        if "friction_law" in fmu.variables:
            starts = {parameter: fmu.variables[parameter].start for parameter in fmu.names("parameter")}
            said = beyond_table({**starts, **assembly.parameters[name]})
            if said:
                yield f"{name}: {said}"


def _of_fmus(assembly: Assembly, step: float) -> Iterator[str]:
    """Yield what FMUs say of themselves; once for all instances of an FMU."""
    told: set[str] = set()
    for name, fmu in assembly.fmus.items():
        if fmu.checksum in told:
            continue
        told.add(fmu.checksum)
        if fmu.description.coSimulation.needsExecutionTool:
            tool = fmu.description.generationTool or "a tool that it does not name"
            yield f"{name} ({fmu.path.name}) needs an execution tool on this machine: {tool}"
        clocks = [v.name for v in fmu.description.modelVariables if v.type == "Clock" and v.causality == "input"]
        if clocks:
            yield f"{name} ({fmu.path.name}): clocks are not supported; {', '.join(clocks)} never tick"
        binaries = [v for v in fmu.names("input") if fmu.variables[v].type == "Binary"]
        if binaries:
            yield f"{name} ({fmu.path.name}): binary inputs are not supported; {', '.join(binaries)} stay at the start"
        own = step * assembly.periods(step)[name]
        if fmu.inner_step is not None and not is_multiple(own, fmu.inner_step):
            yield (
                f"{name} ({fmu.path.name}) steps inside by {fmu.inner_step:g} s, of which its communication step of "
                f"{own:g} s is no multiple: its outputs are those of its last inner step"
            )
