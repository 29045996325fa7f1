"""Which tone wins: many starts of one system in, how each of them ended out.

Several unstable modes grow at once and one of them takes over; which one depends on how the vibration starts. Every run
is appended to a file as soon as it is done, so that nothing is lost when the whole is stopped, and a run that the file
has is not made again.
"""

from __future__ import annotations

import json
import multiprocessing
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np

from fmus.interface import INITIAL_VELOCITY
from fmus.modal.parameters import names_of

from ..coupling.assembly import Assembly
from ..coupling.master import Master
from ..errors import InputError
from ..fmi.instance import Fmu
from ..results.file import ResultsFile, open_results
from ..signals.summary import summarise
from .scenario import Scenario

START_VELOCITY = 0.1
"""Lateral velocity of the contact point with which a chosen mode starts [m/s]: half of what sliding allows."""

RECORD_EVERY = 8
_NEAR = 0.02


@dataclass(frozen=True)
class Trial:
    """One start of a system.

    Attributes
    ----------
    system : a case or a file
    seed : of the random initial modal velocities
    start_hz : frequency of the wheel mode that starts at `START_VELOCITY`; None: no mode is preferred
    stiffness : of the contact spring [N/m]; None: as the system says
    duration, step : None: as the system says [s]
    """

    system: str
    seed: int
    start_hz: float | None = None
    stiffness: float | None = None
    duration: float | None = None
    step: float | None = None

    def scenario(self) -> Scenario:
        """Return the scenario of this start, without the chosen mode."""
        values = {} if self.stiffness is None else {"contact": {"hertz_stiffness": self.stiffness}}
        return Scenario(
            system=self.system,
            seed=self.seed,
            duration=self.duration,
            step=self.step,
            values=values,
            record_every=RECORD_EVERY,
            record=(),
        )


@dataclass(frozen=True)
class Ending:
    """How a trial ended.

    Attributes
    ----------
    trial : what was run
    frequency_hz : dominant frequency of the wheel's lateral velocity in the second half; None: at rest
    lateral_rms : of the wheel in the second half [m/s]
    contact_lost : part of the second half without normal force [-]
    fmus : first digits of the checksums of the FMUs
    """

    trial: Trial
    frequency_hz: float | None
    lateral_rms: float
    contact_lost: float
    fmus: str


def plan(system: str, runs: int, seed: int, starts: Sequence[float], stiffness: Sequence[float]) -> list[Trial]:
    """Return `runs` trials for every start and stiffness, seeds counted from `seed`.

    Raises
    ------
    InputError
        For fewer than one run, or a stiffness that is not above zero.
    """
    if runs < 1:
        raise InputError(f"runs {runs}: must be at least 1")
    if seed < 0:
        raise InputError(f"seed {seed}: must be >= 0")
    for value in stiffness:
        if not 0 < value < np.inf:
            raise InputError(f"stiffness {value:g}: must be > 0, such as 1.2e9 N/m")
    springs: list[float | None] = [*stiffness] or [None]
    modes: list[float | None] = [*starts] or [None]
    return [Trial(system, s, mode, spring) for spring, mode, s in product(springs, modes, range(seed, seed + runs))]


def run_trial(trial: Trial) -> Ending:
    """Run one trial to its end.

    Raises
    ------
    InputError, SimulationError
        If the system cannot be run, a component fails, or the wheel has no such mode.
    """
    scenario = trial.scenario()
    assembly, settings = scenario.prepare()
    if trial.start_hz is not None:
        wheel = assembly.fmus.get("wheel")
        if wheel is None:
            raise InputError(f"{trial.system}: has no component 'wheel' whose mode could start")
        assembly.parameters["wheel"].update(mode_start(wheel, assembly.parameters["wheel"], trial.start_hz))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "trial.nc"
        about = {"step_s": settings.step, "record_every": settings.record_every}
        with Master(assembly, settings) as master, ResultsFile(path, master.signals(), about) as results:
            master.run(results)
        with open_results(path) as data:
            summary = summarise(data)
    return Ending(
        trial=trial,
        frequency_hz=summary.dominant_frequency_hz,
        lateral_rms=summary.wheel_velocity_rms.get("lat", 0.0),
        contact_lost=summary.contact_lost or 0.0,
        fmus=_checksums(assembly),
    )


def mode_start(wheel: Fmu, parameters: Mapping[str, object], frequency_hz: float) -> dict[str, float]:
    """Return the initial velocity with which the wheel mode at a frequency moves the contact at `START_VELOCITY`.

    Of the modes within 2 % the one with the largest lateral amplitude.

    Raises
    ------
    InputError
        If no mode that moves the contact laterally is near.
    """

    def value(name: str) -> float:
        given = parameters.get(name, wheel.variables[name].start)
        return float(str(given))

    shown = wheel.names("parameter")
    frequency, shape, start = (names_of(block, shown) for block in ("frequency", "shape_lat", INITIAL_VELOCITY))
    if not frequency.keys() <= shape.keys() & start.keys() or not frequency:
        raise InputError(f"start-mode {frequency_hz:g}: the wheel shows no modes, so there is none to start on")
    lateral = {n: abs(value(shape[n])) for n in frequency}
    near = {n: a for n, a in lateral.items() if a > 0 and abs(value(frequency[n]) / frequency_hz - 1) < _NEAR}
    if not near:
        audible = sorted(value(frequency[n]) for n, a in lateral.items() if a > 0.3 * max(lateral.values()))
        raise InputError(
            f"start-mode {frequency_hz:g}: the wheel has no lateral mode within 2 % of {frequency_hz:g} Hz; "
            f"its strong ones are at {', '.join(f'{f:.0f}' for f in audible[:12])} Hz"
        )
    chosen = max(near, key=lambda n: near[n])
    return {start[chosen]: START_VELOCITY / near[chosen]}


def _checksums(assembly: Assembly) -> str:
    return " ".join(fmu.checksum[:8] for fmu in assembly.fmus.values())


def compete(
    trials: Sequence[Trial],
    path: Path,
    jobs: int,
    report: Callable[[int, int], None] = lambda _done, _all: None,
    stop_requested: Callable[[], bool] = lambda: False,
) -> list[Ending]:
    """Run the trials that a file does not have yet, several at once, and append each to the file.

    Parameters
    ----------
    path : JSON lines, one per trial; made if it is not there
    jobs : number of processes
    report : called with the numbers of trials done and wanted
    stop_requested : asked twice a second; what is done by then is returned

    Raises
    ------
    InputError
        If the file holds something else, or a trial cannot be run.
    SimulationError
        If a component fails.
    """
    wanted = set(trials)
    checksums = _checksums(trials[0].scenario().prepare()[0])
    done = [e for e in read_endings(path) if e.trial in wanted and e.fmus == checksums]
    report(len(done), len(trials))
    missing = [t for t in trials if t not in {e.trial for e in done}]
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        for ending in _run_all(missing, jobs, stop_requested):
            file.write(json.dumps(asdict(ending)) + "\n")
            file.flush()
            done.append(ending)
            report(len(done), len(trials))
    return done


def _run_all(trials: Sequence[Trial], jobs: int, stop_requested: Callable[[], bool]) -> Iterator[Ending]:
    """Yield the endings as they come in."""
    # A process made by the fork server leaves without the destructors of the FMU libraries, which may free twice.
    methods = multiprocessing.get_all_start_methods()
    context = multiprocessing.get_context("forkserver" if "forkserver" in methods else "spawn")
    with ProcessPoolExecutor(max(1, min(jobs, len(trials))), mp_context=context, initializer=_ignore_signals) as pool:
        pending: set[Future[Ending]] = {pool.submit(run_trial, trial) for trial in trials}
        try:
            while pending and not stop_requested():
                finished, pending = wait(pending, timeout=0.5, return_when=FIRST_COMPLETED)
                for future in finished:
                    yield future.result()
        finally:
            pool.shutdown(wait=not stop_requested(), cancel_futures=True)
            if stop_requested():
                for process in multiprocessing.active_children():
                    process.terminate()


def _ignore_signals() -> None:
    """Leave Ctrl-C to the parent."""
    import signal  # noqa: PLC0415

    signal.signal(signal.SIGINT, signal.SIG_IGN)


def read_endings(path: Path) -> list[Ending]:
    """Return the trials that a file holds; none if it is not there. A last line that was cut off is left out.

    Raises
    ------
    InputError
        If the file holds something else.
    """
    if not path.is_file():
        return []
    lines = path.read_text(encoding="utf-8").split("\n")
    endings = []
    for number, line in enumerate(lines[:-1], start=1):
        try:
            fields = json.loads(line)
            endings.append(Ending(**{**fields, "trial": Trial(**fields["trial"])}))
        except (ValueError, TypeError, KeyError):
            raise InputError(f"{path}, line {number}: is no trial of a competition; give another folder") from None
    if lines[-1]:
        path.write_text("".join(f"{line}\n" for line in lines[:-1]), encoding="utf-8")
    return endings
