"""The master: an assembled system in, a run in chunks out. It couples; it knows no physics."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, SimulationError
from ..fmi.file import WHOLE
from ..fmi.instance import STATUS, FmuInstance, Value
from ..probing.mobility import with_step
from ..results.file import Column, Results
from .algorithms import find_algorithm, stages
from .assembly import Assembly
from .bonds import energy_account, sums
from .contact_mobility import contact_mobility
from .faults import fault_of
from .loop import data
from .loop.recorded import Further, advance, snapshot
from .loop.steps import exchange
from .notices import notices
from .plan import Schedule, Wiring, make_plan, transfers, wide
from .recording import recorded
from .settings import Progress, Settings
from .texts import Texts

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
        self.stages = stages(settings.algorithm, assembly.coupling)
        self.periods = assembly.periods(settings.step)
        self.stop = settings.stop(assembly.system.start)
        self._check()
        self.notices = list(notices(assembly, settings))
        self.parameters = self._all_parameters()
        self.wiring = Wiring.of(assembly)
        self.outputs = list(self.wiring.outputs)
        self._index = {name: k for k, name in enumerate(assembly.fmus)}
        self.account = energy_account(assembly.contact, assembly.fmus)
        self.further = list(dict.fromkeys([*recorded(assembly.fmus, settings.record), *self.account.values()]))
        self.progress = Progress(settings.steps)
        self._exit = ExitStack()
        with ExitStack() as stack:
            self.instances: dict[str, FmuInstance] = {}
            for name, fmu in assembly.fmus.items():
                self.instances[name] = FmuInstance(fmu, name, settings.timeout)
                stack.callback(self.instances[name].close)
            self.texts = Texts.of(assembly, self.instances)
            schedule = Schedule(self.algorithm, self.stages, self.periods)
            self.plan = make_plan(assembly, self.instances, self.wiring, schedule, self.texts)
            self._more = self._further()
            stack.callback(self._free_states)
            self._initialise()
            self._exit = stack.pop_all()
        apart = [name for name, instance in self.instances.items() if instance.apart and settings.timeout is None]
        if apart:
            self.notices.append(
                f"{', '.join(apart)}: a process can have one instance of this FMU only; in a process of its own, slowly"
            )

    def __enter__(self) -> Master:
        """Return the master itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Free all instances."""
        self._exit.close()

    def signals(self) -> list[Column]:
        """Return the recorded columns."""
        columns = [self._column(name, variable) for name, variable in self.outputs + self.further]
        energy = [
            Column(f"energy_into.{s}_{d}", "J", f"energy that the forces put into the {s} so far, {d}")
            for s, d in self.wiring.bonds
        ]
        return columns[: len(self.outputs)] + energy + columns[len(self.outputs) :]

    def _column(self, name: str, variable: str) -> Column:
        """Return the column of a variable, in its type."""
        fmu, instance = self.assembly.fmus[name], self.instances[name]
        known = fmu.variables[variable]
        dtype = np.dtype(bool) if known.type == "Boolean" else instance.layout(known.fmi_type)
        return Column(f"{name}.{variable}", fmu.unit(variable) or "", known.description or "", dtype)

    def _further(self) -> Further:
        """Return the calls that get the further variables, and room for these."""
        count = len(self.further)
        calls = transfers(self.assembly, self.instances, self.further, "Get")
        room = max(self.plan.scratch.size, calls.size.max(initial=1))
        self.plan = self.plan._replace(scratch=np.zeros(room, dtype=np.uint64))
        whole = any(self.assembly.fmus[name].variables[v].type in WHOLE for name, v in self.further)
        words = np.zeros(count, dtype=np.int64)
        return Further(calls, np.zeros(count), words, wide(self.assembly, self.further), whole)

    def _check(self) -> None:
        """Raise InputError if a component does not get to the end, or cannot repeat a step that has to be."""
        for name, fmu in self.assembly.fmus.items():
            count = self.periods[name]
            if self.settings.steps % count:
                raise InputError(
                    f"{name} makes one step in {count} communication steps, and the run has {self.settings.steps}: it "
                    f"would not get to the end; take a duration that is a multiple of {count * self.settings.step:g} s"
                )
            if self.algorithm.sweeps == 1:
                continue
            why = None
            if not fmu.can_roll_back:
                why = "cannot get and set its state"
            elif count > 1:
                why = "steps more slowly than the others"
            if why is not None:
                other = "jacobi" if self.assembly.coupling.order.loops else "staggered"
                raise InputError(
                    f"{self.settings.algorithm}: {name} ({fmu.path.name}) {why}, so a step cannot be repeated; "
                    f"use the algorithm {other}"
                )

    def _all_parameters(self) -> dict[str, dict[str, Value]]:
        """Return the parameters of all components, with the step and the interface mobilities put in."""
        a, step = self.assembly, self.settings.step
        parameters = {name: with_step(fmu, a.parameters[name], step) for name, fmu in a.fmus.items()}
        if a.contact is not None:
            parameters[a.contact].update(contact_mobility(a, step, self.settings.timeout))
            parameters[a.contact].update(a.integration())
        return parameters

    def _initialise(self) -> None:
        """Set parameters, let outputs and inputs agree in initialisation mode, and make the exchange after it."""
        start = self.assembly.system.start
        for name, instance in self.instances.items():
            instance.set(self.parameters[name])
            instance.enter_initialization_mode(start, self._told_stop(name))
        for _ in range(self.algorithm.sweeps):
            before = self.plan.y.copy()
            for stage in self.stages:
                for name in stage:
                    self._exchange(name, data.SET)
                    self._exchange(name, data.GET)
            if np.allclose(self.plan.y, before, rtol=self.algorithm.tolerance, atol=0):
                break
        for name, instance in self.instances.items():
            self._exchange(name, data.SET)
            instance.exit_initialization_mode()
        for name in self.instances:
            self._exchange(name, data.GET)

    def _told_stop(self, name: str) -> float:
        """Return the stop time that a component is told: where its last step ends, to the bit, by its own sum."""
        h, count = self.settings.step, self.periods[name]
        if self.assembly.fmus[name].takes_any_step:
            return self.stop
        last = self.assembly.system.start + (self.settings.steps - count) * h
        return max(self.stop, last + count * h)

    def _exchange(self, name: str, what: int) -> None:
        """Bring the inputs of a component up to date or get its outputs, between steps."""
        where = self._index[name]
        status = exchange(self.plan, where, what == data.SET)
        if status > 1:
            raise SimulationError(self._explain(what, where, status, self.assembly.system.start))

    def refresh(self) -> None:
        """Get the texts and the figures of the run so far, after the states of the components were set."""
        self.texts.refresh()
        self._take_figures()

    def _free_states(self) -> None:
        """Free the states that an iteration went back to."""
        for instance, state in zip(self.instances.values(), self.plan.state.tolist(), strict=True):
            if state:
                instance.free_state(ctypes.c_void_p(state))

    def run(
        self,
        results: Results | None = None,
        report: Callable[[Progress], None] = lambda _: None,
        stop_requested: Callable[[], bool] = lambda: False,
        steps: int | None = None,
    ) -> Progress:
        """Step on to the end, or until a stop is requested or a component ends the run.

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
        if results is not None and progress.steps == 0:
            results.append(np.array([self.assembly.system.start]), self._first_row())
        for times, rows in self._chunks(end):
            if results is not None and times.size:
                results.append(times, rows)
            report(progress)
            if progress.ended:
                break
            if stop_requested():
                progress.stopped = True
                break
        return progress

    def _first_row(self) -> Rows:
        """Return what is recorded after the initialisation."""
        row = np.zeros((1, len(self.signals())))
        where, status = snapshot(self.plan, self._more, (row, row.view(np.int64)))
        if status > 1:
            raise SimulationError(self._explain(data.GET, where, status, self.assembly.system.start))
        return row

    def _chunks(self, end: int) -> Iterator[tuple[Rows, Rows]]:
        """Run the compiled loop chunk by chunk up to step `end`; yield the times and rows that each records."""
        h, every, progress = self.settings.step, self.settings.record_every, self.progress
        clock = (self.assembly.system.start, h, progress.total, self.stop)
        columns = len(self.signals())
        size = 1  # a step may take long
        while progress.steps < end and not progress.ended:
            steps = min(size, end - progress.steps)
            rows = np.empty((steps // every + 2, columns))
            record = (rows, rows.view(np.int64))
            begin = time.perf_counter()
            done, count, what, where, status = advance(
                self.plan, self._more, clock, progress.steps, steps, every, record
            )
            elapsed = time.perf_counter() - begin
            first = (progress.steps // every + 1) * every
            progress.wall += elapsed
            progress.steps += done
            self._take_figures()
            numbers = np.minimum(first + every * np.arange(count), progress.steps)
            fault = what != data.OK and not self._ended(what, where, status)
            yield self._times(numbers), rows[:count]
            if fault:
                raise SimulationError(self._explain(what, where, status, self._times(np.array([progress.steps]))[0]))
            size = max(1, int(np.clip(size * CHUNK_SECONDS / max(elapsed, 1e-6), size / 4, 8 * size)))

    def _times(self, numbers: NDArray[np.int64]) -> Rows:
        """Return the times after steps of these numbers, as the components were told them."""
        times = self.assembly.system.start + self.settings.step * numbers
        return np.where(numbers == self.progress.total, self.stop, times)

    def _ended(self, what: int, where: int, status: int) -> bool:
        """Return whether a component ended the run, and say so in the progress."""
        if what != data.STEP:
            return False
        instance = list(self.instances.values())[where]
        if status == data.ENDED or (STATUS[status : status + 1] == ("discard",) and instance.ended()):
            at = self._times(np.array([self.progress.steps]))[0]
            self.progress.ended = f"{instance.name} ended the simulation at t = {at:.9g} s{instance.last_message()}"
            return True
        return False

    def _take_figures(self) -> None:
        """Bring energies and sweeps of the progress up to date."""
        plan, progress = self.plan, self.progress
        progress.energy_residual = self._kept_account() or sums(self.wiring.bonds, plan.energy[:, 0], 1)
        progress.energy_into_structures = sums(self.wiring.bonds, plan.energy[:, 1], 1)
        progress.energy_into = sums(self.wiring.bonds, plan.energy[:, 1], 0)
        if self.algorithm.sweeps > 1:
            progress.sweeps = plan.sweeps[1] / max(progress.steps, 1)
            progress.most_sweeps = int(plan.sweeps[2])

    def _kept_account(self) -> dict[str, float]:
        """Return the energy that holding the forces added, by the contact's account; empty where it keeps none."""
        if not self.account:
            return {}
        contact = self.instances[str(self.assembly.contact)]
        return dict(zip(self.account, contact.get_real([name for _, name in self.account.values()]), strict=True))

    def _explain(self, what: int, where: int, status: int, moment: float) -> str:
        """Return the sentence that says which component failed, in which call and when."""
        at = f"at t = {moment:.9g} s"
        if what == data.NOT_FINITE:
            name, variable = self.outputs[where]
            return f"{name}: output {variable} = {self.plan.y[where]} {at}: not a finite number"
        if what == data.NOT_CONVERGED:
            name, variable = self.wiring.inputs[where].key
            return (
                f"{self.settings.algorithm}: input {name}.{variable} still changes after "
                f"{self.algorithm.sweeps} sweeps {at}; take a smaller step or another algorithm"
            )
        return fault_of(list(self.instances.values())[where], what, status, at)
