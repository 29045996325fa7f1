"""The master: an assembled system in, a run in chunks out. It couples; it knows no physics."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from . import loop, recording
from .algorithms import stages
from .assembly import Assembly
from .errors import InputError, SimulationError
from .fmu import STATUS, FmuInstance, Value
from .mobility import contact_mobility, with_step
from .results import ResultsFile

Rows = NDArray[np.float64]

CHUNK_SECONDS = 0.1
"""Wall time between two returns from the compiled loop, for progress, stop requests and recording."""


@dataclass(frozen=True)
class Settings:
    """How to run a system.

    Attributes
    ----------
    step : communication step [s]
    duration : simulated time [s]; rounded to a whole number of steps
    algorithm : name of the master algorithm
    record_every : record after every this many steps
    record : patterns of local variables to record besides the outputs; None: the wheel's modal velocities
    """

    step: float
    duration: float
    algorithm: str = "staggered"
    record_every: int = 4
    record: tuple[str, ...] | None = None

    def __post_init__(self) -> None:
        """Check the values."""
        if not 0 < self.step < np.inf:
            raise InputError(f"step = {self.step:g} s: must be > 0")
        if not self.step <= self.duration < np.inf:
            raise InputError(f"duration = {self.duration:g} s: must be at least one step of {self.step:g} s")
        if self.record_every < 1:
            raise InputError(f"record_every = {self.record_every}: must be >= 1")

    @property
    def steps(self) -> int:
        """Number of steps."""
        return round(self.duration / self.step)


@dataclass
class Progress:
    """How far a run is.

    Attributes
    ----------
    total : steps of the whole run
    steps : steps made
    wall : wall time in the loop [s]
    energy_residual : energy that the scheme adds, by direction [J]
    energy_into_structures : energy that went through the bonds, by direction [J]
    stopped : whether a stop was requested before the end
    """

    total: int
    steps: int = 0
    wall: float = 0.0
    energy_residual: dict[str, float] = field(default_factory=dict)
    energy_into_structures: dict[str, float] = field(default_factory=dict)
    stopped: bool = False


class Master:
    """A system that is instantiated, initialised and ready to step; use it in a `with` statement.

    Parameters
    ----------
    assembly : Assembly
    settings : Settings

    Raises
    ------
    SimulationError
        If a component cannot be instantiated or initialised.
    """

    def __init__(self, assembly: Assembly, settings: Settings) -> None:
        self.assembly = assembly
        self.settings = settings
        self.parameters = self._all_parameters()
        self.outputs = [
            (name, variable)
            for name, fmu in assembly.fmus.items()
            for variable in fmu.names("output")
            if fmu.variables[variable].type == "Real"
        ]
        self.further = recording.recorded(assembly.fmus, settings.record)
        self.directions = list(dict.fromkeys(bond.direction for bond in assembly.bonds))
        self.stages = stages(settings.algorithm, assembly.coupling())
        self._exit = ExitStack()
        with ExitStack() as stack:
            self.instances: dict[str, FmuInstance] = {}
            for name, fmu in assembly.fmus.items():
                self.instances[name] = FmuInstance(fmu, name)
                stack.callback(self.instances[name].close)
            self.plan = self._plan()
            self._initialise()
            self._exit = stack.pop_all()

    def __enter__(self) -> Master:
        """Return the master itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free all instances."""
        self._exit.close()

    def signals(self) -> list[tuple[str, str, str]]:
        """Return name, unit and description of each recorded column."""
        fmus = self.assembly.fmus
        columns = [
            (f"{name}.{variable}", fmus[name].unit(variable) or "", fmus[name].variables[variable].description or "")
            for name, variable in self.outputs + self.further
        ]
        energy = [
            (f"energy_residual.{d}", "J", f"energy that the coupling scheme added so far, {d}") for d in self.directions
        ]
        return columns[: len(self.outputs)] + energy + columns[len(self.outputs) :]

    def _all_parameters(self) -> dict[str, dict[str, Value]]:
        """Return the parameters of all components, with the step and the interface mobilities put in."""
        a, step = self.assembly, self.settings.step
        parameters = {name: with_step(fmu, a.parameters[name], step) for name, fmu in a.fmus.items()}
        if a.contact is not None:
            parameters[a.contact].update(contact_mobility(a, step))
        return parameters

    def _plan(self) -> loop.Plan:
        """Resolve names to indices and functions to addresses."""
        a = self.assembly
        names = list(a.fmus)
        inputs = {name: [link for link in a.links if link.wire.end_element == name] for name in names}
        links = [link for name in names for link in inputs[name]]
        place_y = {key: i for i, key in enumerate(self.outputs)}
        place_u = {(k.wire.end_element, k.wire.end_connector): i for i, k in enumerate(links)}

        def references(keys: list[tuple[str, str]]) -> NDArray[np.uint32]:
            return np.array([a.fmus[e].variables[v].valueReference for e, v in keys], dtype=np.uint32)

        def begins(lengths: list[int]) -> NDArray[np.int64]:
            return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)

        def addresses(function: str) -> NDArray[np.int64]:
            return np.array([self.instances[name].address(function) for name in names], dtype=np.int64)

        def places(keys: list[int]) -> NDArray[np.int64]:
            return np.array(keys, dtype=np.int64)

        return loop.Plan(
            stage_begin=begins([len(stage) for stage in self.stages]),
            order=places([names.index(name) for stage in self.stages for name in stage]),
            handle=places([self.instances[name].handle for name in names]),
            set_real=addresses("fmi2SetReal"),
            get_real=addresses("fmi2GetReal"),
            do_step=addresses("fmi2DoStep"),
            input_begin=begins([len(inputs[name]) for name in names]),
            output_begin=begins([sum(e == name for e, _ in self.outputs) for name in names]),
            input_reference=references([(k.wire.end_element, k.wire.end_connector) for k in links]),
            output_reference=references(self.outputs),
            u=np.zeros(len(links)),
            y=np.zeros(len(self.outputs)),
            source=places([place_y[k.wire.start_element, k.wire.start_connector] for k in links]),
            gain=np.array([k.gain for k in links]),
            offset=np.array([k.offset for k in links]),
            bond_force=places([place_u[b.force.wire.end_element, b.force.wire.end_connector] for b in a.bonds]),
            bond_velocity=places(
                [place_y[b.velocity.wire.start_element, b.velocity.wire.start_connector] for b in a.bonds]
            ),
            bond_row=places([self.directions.index(b.direction) for b in a.bonds]),
            energy=np.zeros((len(self.directions), 2)),
        )

    def _initialise(self) -> None:
        """Set parameters, let outputs and inputs agree in initialisation mode, and make the exchange after it."""
        start, stop = self.assembly.system.start, self.assembly.system.start + self.settings.duration
        for name, instance in self.instances.items():
            instance.set(self.parameters[name])
            instance.enter_initialization_mode(start, stop)
        for stage in self.stages:
            for name in stage:
                self._bring_inputs(name)
                self._fetch_outputs(name)
        for name, instance in self.instances.items():
            self._bring_inputs(name)
            instance.exit_initialization_mode()
        for name in self.instances:
            self._fetch_outputs(name)

    def _bring_inputs(self, name: str) -> None:
        """Set the inputs of a component from the latest outputs."""
        plan, c = self.plan, list(self.instances).index(name)
        part = slice(plan.input_begin[c], plan.input_begin[c + 1])
        plan.u[part] = plan.gain[part] * plan.y[plan.source[part]] + plan.offset[part]
        links = [link for link in self.assembly.links if link.wire.end_element == name]
        values = zip(links, plan.u[part], strict=True)
        self.instances[name].set({link.wire.end_connector: float(value) for link, value in values})

    def _fetch_outputs(self, name: str) -> None:
        """Read the outputs of a component."""
        plan, c = self.plan, list(self.instances).index(name)
        variables = [v for e, v in self.outputs if e == name]
        plan.y[plan.output_begin[c] : plan.output_begin[c + 1]] = self.instances[name].get_real(variables)

    def run(
        self,
        results: ResultsFile | None = None,
        report: Callable[[Progress], None] = lambda _: None,
        stop_requested: Callable[[], bool] = lambda: False,
    ) -> Progress:
        """Step to the end, or until a stop is requested.

        Parameters
        ----------
        results : takes the recorded rows
        report : called after each chunk of steps
        stop_requested : asked after each chunk of steps

        Raises
        ------
        SimulationError
            If a component fails or puts out what is not a number; `results` keeps what was computed until then.
        """
        progress = Progress(self.settings.steps)
        for times, rows in self._chunks(progress):
            if results is not None and times.size:
                results.append(times, rows)
            report(progress)
            if stop_requested():
                progress.stopped = True
                break
        return progress

    def _chunks(self, progress: Progress) -> Iterator[tuple[Rows, Rows]]:
        """Run the compiled loop chunk by chunk; yield the times and rows that each records."""
        h, every, total = self.settings.step, self.settings.record_every, self.settings.steps
        start = self.assembly.system.start
        size = max(every, 100)
        further = recording.further(list(self.instances), self.further, self.assembly.fmus)
        while progress.steps < total:
            steps = min(size, total - progress.steps)
            rows = np.empty((steps // every + 1, len(self.signals())))
            begin = time.perf_counter()
            clock = (start, h, progress.steps)
            done, count, what, where, status = recording.advance(self.plan, further, clock, steps, every, rows)
            elapsed = time.perf_counter() - begin
            first = (progress.steps // every + 1) * every
            progress.wall += elapsed
            progress.steps += done
            progress.energy_residual = dict(zip(self.directions, self.plan.energy[:, 0].tolist(), strict=True))
            progress.energy_into_structures = dict(zip(self.directions, self.plan.energy[:, 1].tolist(), strict=True))
            yield start + h * (first + every * np.arange(count)), rows[:count]
            if what != loop.OK:
                raise SimulationError(self._explain(what, where, status, start + h * progress.steps))
            size = int(np.clip(size * CHUNK_SECONDS / max(elapsed, 1e-6), size / 4, 4 * size)) // every * every or every

    def _explain(self, what: int, where: int, status: int, moment: float) -> str:
        """Return the sentence that says which component failed, in which call and when."""
        if what == loop.NOT_FINITE:
            name, variable = self.outputs[where]
            return f"{name}: output {variable} = {self.plan.y[where]} at t = {moment:.9g} s: not a finite number"
        instance = list(self.instances.values())[where]
        call = {loop.SET: "setReal", loop.STEP: "doStep", loop.GET: "getReal"}[what]
        said = STATUS[status] if status < len(STATUS) else str(status)
        instance.lost = said == "fatal"
        return f"{instance.name}: {call} returned {said} at t = {moment:.9g} s{instance.last_message()}"
