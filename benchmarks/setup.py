"""Time to set up a system of many FMUs against the time of reading it: both must grow as the system does.

    python benchmarks/setup.py [--json]

Reading is reading the SSD, ten wires per FMU; setting up is checking it against the FMU, ordering the steps, making the
instances and the exchange before the first step. The FMU has ten inputs and ten outputs.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.table import Table as Sheet

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from fmi3_fmu import write_ssd
from foreign_fmus import foreign_fmu, variable
from stored import store

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.system.reader import read_system

SIZES = (250, 500, 1000)
WIRES = 10
"""Per FMU."""


def measure(folder: Path, count: int) -> dict[str, float]:
    """Return the times of reading and of setting up a system of this many FMUs [s]."""
    inputs = "".join(variable(f"u{k}", k, "input", start=0) for k in range(WIRES // 2))
    outputs = "".join(variable(f"y{k}", 8 + k, "output") for k in range(WIRES // 2))
    more = "".join(variable(f"n{k}", k, "input", "Integer", 0) for k in range(WIRES // 2))
    whole = "".join(variable(f"m{k}", 8 + k, "output", "Integer") for k in range(WIRES // 2))
    fmu = foreign_fmu(folder / "part.fmu", inputs + outputs + more + whole, step="m->r[8]=m->t", depends="")
    pairs = [(f"y{k}", f"u{k}") for k in range(WIRES // 2)] + [(f"m{k}", f"n{k}") for k in range(WIRES // 2)]
    wires = [(f"c{(j + i + 1) % count}.{y}", f"c{j}.{u}") for j in range(count) for i, (y, u) in enumerate(pairs)]
    ssd = write_ssd(folder / "system.ssd", {f"c{j}": fmu for j in range(count)}, wires)
    begin = time.perf_counter()
    system = read_system(ssd)
    read = time.perf_counter()
    with Master(assemble(system), Settings(0.1, 1.0)):
        ready = time.perf_counter()
    return {"fmus": count, "wires": len(wires), "read_s": read - begin, "set_up_s": ready - read}


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        measure(Path(folder), 2)  # compiled code is loaded once
        rows = [measure(Path(folder), count) for count in SIZES]
    ratios = [f"| {row['fmus']} | {row['wires']} | {row['set_up_s'] / row['read_s']:.2f} |" for row in rows]
    store("Setting up large systems", [
        "`python benchmarks/setup.py`: time until a system is ready to step over that of reading its file.", "",
        "| FMUs | wires | setting up / reading |", "| --- | --- | --- |", *ratios,
    ])  # fmt: skip
    if "--json" in sys.argv:
        Console().print_json(data=rows)
        return
    table = Sheet("FMUs", "wires", "reading [s]", "setting up [s]", "ratio")
    for row in rows:
        ratio = row["set_up_s"] / row["read_s"]
        table.add_row(
            f"{row['fmus']}", f"{row['wires']}", f"{row['read_s']:.2f}", f"{row['set_up_s']:.2f}", f"{ratio:.2f}"
        )
    Console().print(table)


if __name__ == "__main__":
    main()
