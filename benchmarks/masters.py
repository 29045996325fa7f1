"""Time per communication step of several masters on the same native FMUs, Case 1: `make bench`.

Machines differ and are noisy, so the numbers to read are the ratios of one run. "Orchestration" is what a master costs
beside the kernels, whose time is that of the fused loop in this process.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from importlib.metadata import version
from pathlib import Path

import fmpy
from fmpy.fmi2 import FMU2Slave
from rich.console import Console
from rich.table import Table
from stored import store

from fmus.component import Instance
from fmus.interface import connections
from fmus.packaging.build import build
from fmus.packaging.catalogue import components
from fmus.packaging.target import Target
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master
from orchestrator.coupling.settings import Settings
from orchestrator.system.reader import read_system

H = 5e-6
NOISE = 0.05
"""What two measurements of the same kernels may differ by, relative."""


ECOS = """
import json, sys, time
from ecospy import EcosSimulation
with EcosSimulation(ssp_path=sys.argv[1], step_size=float(sys.argv[2])) as simulation:
    simulation.init(parameter_set="initialValues")
    simulation.step(10)
    begin = time.perf_counter()
    simulation.step(int(sys.argv[3]))
    print("RESULT" + json.dumps(time.perf_counter() - begin), flush=True)
import os
os._exit(0)
"""

LIBCOSIM = """
import json, os, sys, time, zipfile
from pathlib import Path
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
log_output_level(CosimLogLevel.ERROR)
folder = Path(sys.argv[4]) / "ssp"
zipfile.ZipFile(sys.argv[1]).extractall(folder)
execution = CosimExecution.from_ssp_file(ssp_path=str(folder), step_size=round(float(sys.argv[2]) * 1e9))
execution.step(10)
begin = time.perf_counter()
execution.step(int(sys.argv[3]))
print("RESULT" + json.dumps(time.perf_counter() - begin), flush=True)
os._exit(0)
"""


@dataclass(frozen=True)
class Timing:
    """What a master needs.

    Attributes
    ----------
    name : of the master
    step : wall time per step [s]; the best of three
    note : how it couples, and anything to know
    """

    name: str
    step: float
    note: str


def fused(steps: int) -> float:
    """Return the time of the three components in one compiled loop."""
    system = Instance(components()["curvesqueal"], {"pulse_force": 100.0})
    system.initialise()
    system.do_step(10 * H)
    begin = time.perf_counter()
    system.do_step(steps * H)
    return time.perf_counter() - begin


def ours(ssp: Path, algorithm: str) -> Callable[[int], float]:
    """Return the timer of our master."""

    def run(steps: int) -> float:
        with Master(assemble(read_system(ssp)), Settings(H, steps * H, algorithm)) as master:
            begin = time.perf_counter()
            master.run()
            return time.perf_counter() - begin

    return run


def fmpy_loop(folder: Path) -> Callable[[int], float]:
    """Return the timer of a loop over FMPy's slaves, one call for all inputs and one for all outputs of each."""
    wires = connections()
    parts = ("wheel", "rail", "contact")
    sent = {p: list(dict.fromkeys(w.start_connector for w in wires if w.start_element == p)) for p in parts}
    slaves: dict[str, FMU2Slave] = {}
    sets: dict[str, list[int]] = {}
    gets: dict[str, list[int]] = {}
    places: dict[str, list[tuple[str, int]]] = {}
    for name in parts:
        unpacked = fmpy.extract(str(folder / f"{name}.fmu"))
        description = fmpy.read_model_description(unpacked)
        reference = {v.name: v.valueReference for v in description.modelVariables}
        own = [w for w in wires if w.end_element == name]
        sets[name] = [reference[w.end_connector] for w in own]
        gets[name] = [reference[n] for n in sent[name]]
        places[name] = [(w.start_element, sent[w.start_element].index(w.start_connector)) for w in own]
        slaves[name] = FMU2Slave(
            guid=description.guid, unzipDirectory=unpacked, instanceName=name,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        slaves[name].instantiate()
        slaves[name].setupExperiment(startTime=0.0)
        slaves[name].enterInitializationMode()
        if name == "contact":
            slaves[name].setReal([reference["pulse_force"]], [100.0])
        slaves[name].exitInitializationMode()

    def run(steps: int) -> float:
        values = {name: [0.0] * len(references) for name, references in gets.items()}
        begin = time.perf_counter()
        for k in range(steps):
            for name, slave in slaves.items():
                slave.setReal(sets[name], [values[part][i] for part, i in places[name]])
            for slave in slaves.values():
                slave.doStep(k * H, H)
            values = {name: slave.getReal(gets[name]) for name, slave in slaves.items()}
        return time.perf_counter() - begin

    return run


def fmpy_ssp(ssp: Path) -> Callable[[int], float]:
    """Return the timer of FMPy's own runner of SSPs; its start-up is taken off by a second, shorter run."""
    from fmpy.ssp.simulation import simulate_ssp  # noqa: PLC0415

    def run(steps: int) -> float:
        times = []
        for count in (steps, 10):
            begin = time.perf_counter()
            simulate_ssp(str(ssp), stop_time=count * H, step_size=H)
            times.append(time.perf_counter() - begin)
        return max(times[0] - times[1], 1e-9)

    return run


def program(script: str, ssp: Path) -> Callable[[int], float]:
    """Return the timer of a tool in a process of its own."""

    def run(steps: int) -> float:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [sys.executable, "-c", script, str(ssp), repr(H), str(steps), folder],
                capture_output=True, text=True, check=False, cwd=folder,
            )  # fmt: skip
        line = next((text for text in done.stdout.splitlines() if text.startswith("RESULT")), None)
        if line is None:
            raise RuntimeError(done.stderr.strip()[-300:])
        return float(json.loads(line.removeprefix("RESULT")))

    return run


def measure(folder: Path, steps: int) -> list[Timing]:
    """Time every master."""
    ssp = folder / "curvesqueal.ssp"
    timers: list[tuple[str, Callable[[int], float], int, str]] = [
        ("fused loop in this process", fused, steps, "staggered; no FMI at all"),
        ("curvesqueal", ours(ssp, "staggered"), steps, "staggered"),
        ("curvesqueal, jacobi", ours(ssp, "jacobi"), steps, "Jacobi"),
        ("ecos", program(ECOS, ssp), steps // 5, "Jacobi"),
        ("libcosim", program(LIBCOSIM, ssp), steps // 20, "Jacobi"),
        ("FMPy, a loop over its slaves", fmpy_loop(folder), steps // 10, "Jacobi"),
        ("FMPy, its runner of SSPs", fmpy_ssp(ssp), steps // 50, "Jacobi; ignores parameter sets, so nothing moves"),
    ]
    timings = []
    for name, timer, count, note in timers:
        try:
            timings.append(Timing(name, min(timer(count) for _ in range(3)) / count, note))
        except RuntimeError as error:
            timings.append(Timing(name, float("nan"), f"did not run: {error}"))
    return timings


def rows(timings: list[Timing]) -> list[list[str]]:
    """Return the table: times, and ratios to ours; a cost below the noise counts as `NOISE` of the kernels."""
    kernels, mine = timings[0].step, timings[1].step
    floor = NOISE * kernels
    own = max(mine - kernels, floor)
    table = []
    for t in timings:
        cost = t.step - kernels
        ratio = f"{'at least ' if own == floor else ''}{cost / own:.0f}"
        against = "-" if t is timings[0] else ratio if cost > floor else "below the noise"
        table.append([t.name, f"{t.step * 1e6:.2f}", f"{t.step / kernels:.2f}", against, t.note])
    return table


HEADINGS = ("master", "us per step", "to the fused loop", "orchestration, to ours", "how")


def main() -> None:
    """Measure, print and store."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=100_000)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        build(Path(name), Target("native"))
        table = rows(measure(Path(name), arguments.steps))
    shown = Table(title="Case 1, 5 us, native FMUs")
    for heading in HEADINGS:
        shown.add_column(heading)
    for row in table:
        shown.add_row(*row)
    Console().print(shown)
    versions = ", ".join(f"{p} {version(p)}" for p in ("curvesqueal", "numba", "fmpy", "ecospy", "libcosimpy"))
    lines = [
        f"Case 1, 5 us, native FMUs, the first {arguments.steps * H:g} s; best of three; {versions}; {date.today()}.",
        "Made by `make bench`. Machines are noisy: read the ratios. Orchestration is the time beside the kernels.",
        "",
        "| " + " | ".join(HEADINGS) + " |",
        "| " + " | ".join("---" for _ in HEADINGS) + " |",
        *("| " + " | ".join(row) + " |" for row in table),
    ]
    store("Masters on the same FMUs", lines)


if __name__ == "__main__":
    main()
