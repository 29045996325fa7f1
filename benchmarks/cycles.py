"""CPU of limit cycles against that of a run: one tone with stability, and all tones of a case, in one process.

    python benchmarks/cycles.py [CASE]

Ratios to a run of 6 s, of which 0.5 s are made, in `benchmarks/RESULTS.md`; compare the ratios, not the times.
"""

from __future__ import annotations

import sys
import time
from datetime import date

from rich.console import Console
from stored import store

from orchestrator.coupling.master import Master
from orchestrator.limit_cycles.search import cycles_of
from orchestrator.limit_cycles.tori.search import break_ups
from orchestrator.runs.scenario import Scenario

PART = 0.5


def main(case: str) -> None:
    """Print the ratios of a case."""
    assembly, settings = Scenario(case, duration=PART, record=(), seed=0).prepare()
    cycles_of(assembly, settings.step, tone_hz=1100.0)  # compiles
    run = 0.0
    for _ in range(2):  # the first one compiles the loop
        with Master(assembly, settings) as master:
            begin = time.process_time()
            master.run()
            run = (time.process_time() - begin) * 6.0 / PART
    table = []
    for words, tone in (("one tone", 1100.0), ("all tones", None)):
        begin = time.process_time()
        found = cycles_of(assembly, settings.step, tone_hz=tone)
        used = time.process_time() - begin
        table.append([f"{words} with stability", str(len(found.cycles)), f"{used:.2f}", f"{used / run:.2f}"])
    begin = time.process_time()
    broken = break_ups(found)
    used = time.process_time() - begin
    solved = sum(b.torus is not None for b in broken)
    words = f"what {len(broken)} of them break up into, two tones in {solved}"
    table.append([words, str(len(broken)), f"{used:.2f}", f"{used / run:.2f}"])
    for row in table:
        Console().print(f"{row[0]}: {row[2]} s, {row[3]} of a 6 s run", highlight=False)
    lines = [
        f"{case}; a run of 6 s at {settings.step * 1e6:g} us takes {run:.2f} s of CPU, same process; {date.today()}.",
        "Made by `make bench`.",
        "",
        "| what | tones | CPU [s] | of a 6 s run |",
        "| --- | --- | --- | --- |",
        *("| " + " | ".join(row) + " |" for row in table),
    ]
    store("Limit cycles", lines)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "case1")
