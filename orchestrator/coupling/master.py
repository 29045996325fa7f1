"""The master: an assembled system in, a run in chunks out. It couples; it knows no physics."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, SimulationError
from ..fmi.instance import STATUS, FmuInstance, Value
from ..probing.mobility import with_step
from ..results.file import ResultsFile
from . import loop, recording
from .algorithms import find_algorithm, stages
from .assembly import Assembly
from .contact_mobility import contact_mobility
from .plan import Wiring, make_plan, transfers
from .rates import period
from .settings import Progress, Settings

__all__ = ["Master", "Progress", "Settings"]

Rows = NDArray[np.float64]

CHUNK_SECONDS = 0.1
"""Wall time between two returns from the compiled loop, for progress, stop requests and recording."""


class Master:
    """A system that is instantiated, initialised and ready to step; use it in a `with` statement.

    Parameters
    ----------
    assembly : Assembly
    settings : Settings

    Attributes
    ----------
    notices : sentences about choices that the master made by itself

    Raises
    ------
    InputError
        If the algorithm and the FMUs do not go together.
    SimulationError
        If a component cannot be instantiated or initialised.
    """

    def __init__(self, assembly: Assembly, settings: Settings) -> None:
        self.assembly = assembly
        self.settings = settings
        self.algorithm = find_algorithm(settings.algorithm)
        coupling = assembly.coupling()
        self.stages = stages(settings.algorithm, coupling)
        self.periods = {name: period(fmu, settings.step) for name, fmu in assembly.fmus.items()}
        self._check_algorithm()
        self.notices = [] if self.algorithm.simultaneous else coupling.guesses()
        self.notices += [
            f"{name} makes one step of {settings.step * n:g} s in {n} communication steps"
            for name, n in self.periods.items()
            if n > 1
        ]
        self.parameters = self._all_parameters()
        self.wiring = Wiring.of(assembly)
        self.outputs = list(self.wiring.outputs)
        self.directions = list(self.wiring.directions)
        self.further = recording.recorded(assembly.fmus, settings.record)
        self.progress = Progress(settings.steps)
        self._exit = ExitStack()
        with ExitStack() as stack:
            self.instances: dict[str, FmuInstance] = {}
            for name, fmu in assembly.fmus.items():
                self.instances[name] = FmuInstance(fmu, name, settings.timeout)
                stack.callback(self.instances[name].close)
            self.plan = make_plan(assembly, self.instances, self.wiring, self.stages, self.algorithm, self.periods)
            stack.callback(self._free_states)
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

    def _check_algorithm(self) -> None:
        """Raise InputError if the algorithm repeats steps and a component cannot."""
        if self.algorithm.sweeps == 1:
            return
        for name, fmu in self.assembly.fmus.items():
            why = None
            if not fmu.can_roll_back:
                why = "cannot get and set its state"
            elif self.periods[name] > 1:
                why = "steps more slowly than the others"
            if why is not None:
                raise InputError(
                    f"{self.settings.algorithm}: {name} ({fmu.path.name}) {why}, so a step cannot be repeated; "
                    "use the algorithm staggered"
                )

    def _all_parameters(self) -> dict[str, dict[str, Value]]:
        """Return the parameters of all components, with the step and the interface mobilities put in."""
        a, step = self.assembly, self.settings.step
        parameters = {name: with_step(fmu, a.parameters[name], step) for name, fmu in a.fmus.items()}
        if a.contact is not None:
            parameters[a.contact].update(contact_mobility(a, step, self.settings.timeout))
        return parameters

    def _initialise(self) -> None:
        """Set parameters, let outputs and inputs agree in initialisation mode, and make the exchange after it."""
        start, stop = self.assembly.system.start, self.assembly.system.start + self.settings.duration
        for name, instance in self.instances.items():
            instance.set(self.parameters[name])
            instance.enter_initialization_mode(start, stop)
        for _ in range(self.algorithm.sweeps):
            before = self.plan.y.copy()
            for stage in self.stages:
                for name in stage:
                    self._bring_inputs(name)
                    self._fetch_outputs(name)
            if np.allclose(self.plan.y, before, rtol=self.algorithm.tolerance, atol=0):
                break
        for name, instance in self.instances.items():
            self._bring_inputs(name)
            instance.exit_initialization_mode()
        for name in self.instances:
            self._fetch_outputs(name)

    def _bring_inputs(self, name: str) -> None:
        """Set the inputs of a component from the latest outputs."""
        plan, part = self.plan, self.wiring.inputs_of(name)
        plan.u[part] = plan.gain[part] * plan.y[plan.source[part]] + plan.offset[part]
        variables = [each.key[1] for each in self.wiring.inputs[part]]
        self.instances[name].set(dict(zip(variables, plan.u[part].tolist(), strict=True)))

    def _fetch_outputs(self, name: str) -> None:
        """Read the outputs of a component."""
        part = self.wiring.outputs_of(name)
        self.plan.y[part] = self.instances[name].get_real([variable for _, variable in self.outputs[part]])

    def _free_states(self) -> None:
        """Free the states that an iteration went back to."""
        for instance, state in zip(self.instances.values(), self.plan.state.tolist(), strict=True):
            if state:
                instance.free_state(ctypes.c_void_p(state))

    def run(
        self,
        results: ResultsFile | None = None,
        report: Callable[[Progress], None] = lambda _: None,
        stop_requested: Callable[[], bool] = lambda: False,
        steps: int | None = None,
    ) -> Progress:
        """Step on to the end, or until a stop is requested.

        Parameters
        ----------
        results : takes the recorded rows
        report : called after each chunk of steps
        stop_requested : asked after each chunk of steps
        steps : number of steps to make now; default all that are left

        Raises
        ------
        SimulationError
            If a component fails or puts out what is not a number; `results` keeps what was computed until then.
        """
        progress = self.progress
        end = progress.total if steps is None else min(progress.steps + steps, progress.total)
        for times, rows in self._chunks(end):
            if results is not None and times.size:
                results.append(times, rows)
            report(progress)
            if stop_requested():
                progress.stopped = True
                break
        return progress

    def _chunks(self, end: int) -> Iterator[tuple[Rows, Rows]]:
        """Run the compiled loop chunk by chunk up to step `end`; yield the times and rows that each records."""
        h, every, progress = self.settings.step, self.settings.record_every, self.progress
        start = self.assembly.system.start
        size = max(every, 100)
        further = transfers(self.assembly, self.instances, self.further, "Get")
        while progress.steps < end:
            steps = min(size, end - progress.steps)
            rows = np.empty((steps // every + 1, len(self.signals())))
            begin = time.perf_counter()
            clock = (start, h, progress.steps)
            done, count, what, where, status = recording.advance(self.plan, further, clock, steps, every, rows)
            elapsed = time.perf_counter() - begin
            first = (progress.steps // every + 1) * every
            progress.wall += elapsed
            progress.steps += done
            self._take_figures()
            yield start + h * (first + every * np.arange(count)), rows[:count]
            if what != loop.OK:
                raise SimulationError(self._explain(what, where, status, start + h * progress.steps))
            size = int(np.clip(size * CHUNK_SECONDS / max(elapsed, 1e-6), size / 4, 4 * size)) // every * every or every

    def _take_figures(self) -> None:
        """Bring energies and sweeps of the progress up to date."""
        plan, progress = self.plan, self.progress
        progress.energy_residual = dict(zip(self.directions, plan.energy[:, 0].tolist(), strict=True))
        progress.energy_into_structures = dict(zip(self.directions, plan.energy[:, 1].tolist(), strict=True))
        if self.algorithm.sweeps > 1:
            progress.sweeps = plan.sweeps[1] / max(progress.steps, 1)
            progress.most_sweeps = int(plan.sweeps[2])

    def _explain(self, what: int, where: int, status: int, moment: float) -> str:
        """Return the sentence that says which component failed, in which call and when."""
        at = f"at t = {moment:.9g} s"
        if what == loop.NOT_FINITE:
            name, variable = self.outputs[where]
            return f"{name}: output {variable} = {self.plan.y[where]} {at}: not a finite number"
        if what == loop.NOT_CONVERGED:
            name, variable = self.wiring.inputs[where].key
            return (
                f"{self.settings.algorithm}: input {name}.{variable} still changes after "
                f"{self.algorithm.sweeps} sweeps {at}; take a smaller step or another algorithm"
            )
        instance = list(self.instances.values())[where]
        if status == loop.ENDED:
            return f"{instance.name}: asks to end the simulation {at}{instance.last_message()}"
        said = STATUS[status] if status < len(STATUS) else str(status)
        instance.lost = said == "fatal"
        return f"{instance.name}: {_CALLS[what]} returned {said} {at}{instance.last_message()}"


_CALLS = {
    loop.SET: "setReal", loop.STEP: "doStep", loop.GET: "getReal",
    loop.SAVE: "getFMUstate", loop.RESTORE: "setFMUstate",
}  # fmt: skip
