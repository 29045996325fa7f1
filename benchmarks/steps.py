"""Time per step: each component in this process and as an FMU in the compiled loop, as ratios of one run.

    python benchmarks/steps.py [--json]

Machines are noisy; compare the ratios, not the times.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

from rich.console import Console
from rich.table import Table

from fmus.component import Instance
from fmus.packaging.build import components
from orchestrator.master import Master, Settings
from orchestrator.scenario import Scenario

STEP = 5e-6
REPEATS = 5


def best(measure: Callable[[], float]) -> float:
    """Return the smallest of some measurements."""
    return min(measure() for _ in range(REPEATS))


def component_time(name: str, steps: int = 20_000) -> float:
    """Return the time of one step of a component in this process [s], the call from Python included."""
    instance = Instance(components()[name])
    instance.initialise()
    instance.do_step(STEP)

    def measure() -> float:
        begin = time.perf_counter()
        for _ in range(steps):
            instance.do_step(STEP)
        return (time.perf_counter() - begin) / steps

    return best(measure)


def master_time(case: str, steps: int = 10_000) -> float:
    """Return the time of one step of a case: three Python FMUs through FMI in the compiled loop [s]."""
    assembly, _ = Scenario(case).prepare()

    def measure() -> float:
        with Master(assembly, Settings(STEP, steps * STEP)) as master:
            return master.run().wall / steps

    return best(measure)


def main() -> None:
    """Print the table, or JSON with --json."""
    times = {name: component_time(name) for name in ("wheel", "rail", "contact")}
    parts = sum(times.values())
    times["wheel + rail + contact"] = parts
    times["case1 through FMI, Python FMUs"] = master_time("case1")
    if "--json" in sys.argv:
        sys.stdout.write(json.dumps({name: {"us": t * 1e6, "ratio": t / parts} for name, t in times.items()}) + "\n")
        return
    table = Table("what", "us per step", "ratio")
    for name, t in times.items():
        table.add_row(name, f"{t * 1e6:.2f}", f"{t / parts:.2f}")
    Console().print(table)


if __name__ == "__main__":
    main()
