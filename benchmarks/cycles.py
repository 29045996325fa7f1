"""CPU of limit cycles against that of a run: one tone with stability, and all tones of a case, in one process.

    python benchmarks/cycles.py [CASE]

Ratios to a run of 6 s, of which 0.5 s are made; compare the ratios, not the times.
"""

from __future__ import annotations

import sys
import time

from rich.console import Console

from orchestrator.coupling.master import Master
from orchestrator.limit_cycles.search import cycles_of
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
    for words, tone in (("one tone, stability", 1100.0), ("all tones, stability", None)):
        begin = time.process_time()
        found = cycles_of(assembly, settings.step, tone_hz=tone)
        used = time.process_time() - begin
        Console().print(
            f"{words}: {len(found.cycles)} tones, {used:.2f} s, {used / run:.2f} of a 6 s run", highlight=False
        )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "case1")
