"""The master as a library: load a system, simulate it, look at the results.

Five lines do it:

>>> from orchestrator import load, simulate
>>> scenario = load("case1", duration=0.002, values={"contact": {"mu0": 0.35}})
>>> run = simulate(scenario, folder=folder)
>>> run.data["wheel.v_lat"].sizes["time"]
101
>>> run.spurious.largest < 5  # growth-rate error of the scheme below 5 kHz [1/s]
True
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from matplotlib.figure import Figure

from .coupling.master import Progress
from .errors import SimulationError
from .figures.cycles import draw_cycle, draw_cycles
from .fmi.file import Value
from .limit_cycles.catalogue import NEAR, Catalogue
from .limit_cycles.search import cycles_of
from .limit_cycles.tori.search import BreakUp
from .limit_cycles.tori.search import break_ups as _break_ups
from .runs.outcome import Outcome
from .runs.run import Keeping, Report, run_scenario
from .runs.run import resume as _resume
from .runs.scenario import Scenario
from .runs.starts import on_cycle


def load(  # noqa: PLR0913 - one argument per property of a scenario
    system: str | Path,
    *,
    duration: float | None = None,
    step: float | None = None,
    algorithm: str | None = None,
    values: Mapping[str, Mapping[str, Value]] | None = None,
    replace: Mapping[str, str | Path] | None = None,
    seed: int | None = None,
    start_cycle: float | None = None,
    record_every: int = 4,
    timeout: float | None = None,
    strict: bool = False,
) -> Scenario:
    """Return a scenario that can be simulated; everything in it is checked.

    Parameters
    ----------
    system : a case of the paper, "case1" to "case4", an .ssp or an .ssd file
    duration : simulated time [s]; None: as the system says
    step : communication step [s]; None: as the system says
    algorithm : "staggered", "jacobi" or "iterative"; None: as the system says
    values : parameter values by component and name, in the units of the FMUs
    replace : FMU files by the component whose place they take
    seed : random initial modal velocities instead of the force pulse
    start_cycle : start on the limit cycle near this frequency [Hz], without a growth phase
    record_every : record after every this many steps
    timeout : each FMU in a process of its own, and the time that a call may take [s]; a script needs
        `if __name__ == "__main__":` then
    strict : refuse files with faults that change no number, which are told otherwise

    Raises
    ------
    InputError
        If something is missing, unknown, out of range or does not fit together; the message is one sentence.
    """
    scenario = Scenario(
        system=str(system),
        duration=duration,
        step=step,
        algorithm=algorithm,
        values=values or {},
        sources={name: Path(file) for name, file in (replace or {}).items()},
        seed=seed,
        record_every=record_every,
        timeout=timeout,
        strict=strict,
    ).absolute()
    scenario.prepare()
    return scenario if start_cycle is None else on_cycle(scenario, start_cycle)


def simulate(  # noqa: PLR0913 - one argument per thing that it may leave or tell
    scenario: Scenario | str,
    *,
    folder: str | Path = "results",
    progress: Callable[[Progress], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
    picture: bool = False,
    csv: bool = False,
    checkpoint: str | Path | None = None,
    checkpoint_every: float = Keeping.every,
) -> Outcome:
    """Simulate a scenario; return its numbers, and its results as an xarray dataset in `.data`.

    Parameters
    ----------
    scenario : what `load` returned, or the name of a case
    folder : where the results go; earlier ones there are kept
    progress : called about ten times a second with how far the run is
    notice : called with each sentence that a user should read
    picture : whether to draw histories and spectra beside the results
    csv : whether to write the results as CSV, too
    checkpoint : file for checkpoints, from which `resume` goes on
    checkpoint_every : wall time between checkpoints [s]

    Raises
    ------
    InputError
        If the scenario cannot be run.
    SimulationError
        If a component fails; the results up to then are in the file that the message names.
    """
    chosen = load(scenario) if isinstance(scenario, str) else scenario
    keeping = None if checkpoint is None else Keeping(Path(checkpoint), checkpoint_every)
    return _complete(run_scenario(chosen, Path(folder), Report(progress, notice, csv, picture), keeping))


def resume(
    checkpoint: str | Path,
    *,
    progress: Callable[[Progress], None] = lambda _: None,
    notice: Callable[[str], None] = lambda _: None,
    checkpoint_every: float = Keeping.every,
) -> Outcome:
    """Go on with a run from its checkpoint, to the bit as if it had never stopped; parameters as for `simulate`."""
    return _complete(_resume(Path(checkpoint), Report(progress, notice, picture=False), checkpoint_every))


def cycles(
    scenario: Scenario | str,
    *,
    tone_hz: float | None = None,
    with_stability: bool = True,
    down_to: float = NEAR,
    progress: Callable[[str, int, int], None] = lambda _what, _done, _all: None,
) -> Catalogue:
    """Return every tone that a system can squeal at, computed as a limit cycle, without time stepping.

    Parameters
    ----------
    scenario : what `load` returned, or the name of a case
    tone_hz : only the tone near this frequency [Hz]
    with_stability : whether to judge if each tone lasts
    down_to : growth rate down to which stable poles are followed, too [1/s]; -60 for all tones that are known
    progress : called with what is being done, and how much of how much is done

    Returns
    -------
    A catalogue whose `.cycles` have frequency, levels, forces over a period, exponents and fate; arrays in SI.

    Raises
    ------
    InputError
        If there is no tone, none at the frequency asked for, or the system's behaviour is not known.
    """
    chosen = load(scenario) if isinstance(scenario, str) else scenario
    assembly, settings = chosen.prepare()
    return cycles_of(
        assembly, settings.step, tone_hz=tone_hz, with_stability=with_stability, down_to=down_to, report=progress
    )


def break_ups(
    found: Catalogue, progress: Callable[[str, int, int], None] = lambda _what, _done, _all: None
) -> tuple[BreakUp, ...]:
    """Return what each cycle of a catalogue with growing sidebands breaks up into.

    Parameters
    ----------
    found : what `cycles` returned, with stability
    progress : called with what is being done, and how much of how much is done

    Returns
    -------
    For each such cycle `.torus`, two tones at once with frequencies, velocities, forces and lines in SI, or None where
    the equations were not solved; `.tried` then says how far they were.
    """
    return _break_ups(found, progress)


def plot_cycles(found: Catalogue, tone_hz: float | None = None, title: str = "") -> Figure:
    """Return a figure of all tones, or of the one near a frequency [Hz]."""
    return draw_cycles(found, title) if tone_hz is None else draw_cycle(found.near(tone_hz), title)


def _complete(outcome: Outcome) -> Outcome:
    """Return an outcome; raise SimulationError if an error ended the run."""
    if outcome.error is not None:
        raise SimulationError(f"{outcome.error}; results up to then are in {outcome.results}")
    return outcome
