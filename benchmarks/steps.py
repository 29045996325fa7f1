"""Time per step: each component in this process and as an FMU in the compiled loop, as ratios of one run.

    python benchmarks/steps.py [--json]

The kernels are timed in a compiled loop, next to the floating-point operations that they are made of. Machines are
noisy; compare the ratios, not the times. NUMBA_CPU_NAME=generic times the code of a baseline x86-64 CPU.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numba
from rich.console import Console
from rich.table import Table

from fmus.component import Instance
from fmus.packaging.catalogue import components
from orchestrator.coupling.master import Master, Settings
from orchestrator.runs.scenario import Scenario

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


@numba.njit
def repeat(step, steps, parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    """Call a compiled kernel many times."""
    for _ in range(steps):
        step(parameters, derived, state, inputs, outputs, h)


def kernel_time(instance: Instance, steps: int = 5_000) -> float:
    """Return the time of one step of a component in a compiled loop [s]."""
    arrays = (instance.parameters, instance.derived, instance.state, instance.inputs, instance.outputs)
    step = instance.component.kernel("do_step")
    repeat(step, 1, *arrays, STEP)

    def measure() -> float:
        begin = time.perf_counter()
        repeat(step, steps, *arrays, STEP)
        return (time.perf_counter() - begin) / steps

    return best(measure)


def operations(instance: Instance) -> float:
    """Return the floating-point operations of a step: 33 per mode, 26 per FASTSIM cell and evaluation."""
    if instance.component.name != "contact":
        return 33 * instance.component.state_size / 2
    index = instance.component.parameter_index
    cells = instance.parameters[index["grid_cells"]] * instance.parameters[index["grid_strips"]]
    evaluations = instance.outputs[[v.name for v in instance.component.of("output")].index("force_evaluations")]
    return float(26 * cells * evaluations)


def master_time(case: str, steps: int = 10_000) -> float:
    """Return the time of one step of a case: three FMUs through FMI in the compiled loop [s]."""
    assembly, _ = Scenario(case).prepare()

    def measure() -> float:
        with Master(assembly, Settings(STEP, steps * STEP)) as master:
            return master.run().wall / steps

    return best(measure)


def main() -> None:
    """Print the table, or JSON with --json."""
    names = ("wheel", "rail", "contact")
    work = {}
    kernels = {}
    for name in names:
        instance = Instance(components()[name])
        instance.initialise()
        instance.inputs[0] = 1e-3  # a contact with some spin does not take the short way
        instance.inputs[3] = 1e-2
        kernels[f"{name}, kernel alone"] = kernel_time(instance)
        work[f"{name}, kernel alone"] = operations(instance)
    times = {name: component_time(name) for name in names}
    parts = sum(times.values())
    times["wheel + rail + contact"] = parts
    times |= kernels
    times["case1 through FMI"] = master_time("case1")
    if "--json" in sys.argv:
        sys.stdout.write(json.dumps({name: {"us": t * 1e6, "ratio": t / parts} for name, t in times.items()}) + "\n")
        return
    table = Table("what", "us per step", "ratio", "operations", "per ns")
    for name, t in times.items():
        count = work.get(name)
        rate = ("", "") if count is None else (f"{count:.0f}", f"{count / t * 1e-9:.1f}")
        table.add_row(name, f"{t * 1e6:.2f}", f"{t / parts:.2f}", *rate)
    Console().print(table)


if __name__ == "__main__":
    main()
