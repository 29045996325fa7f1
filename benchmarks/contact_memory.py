"""What the memory of the contact changes: cases with the steady law and with memory, side by side.

    python benchmarks/contact_memory.py [case1 case2 ...]

Prints the table "Contact with memory" of docs/time-domain.md: 6 s from the force pulse.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from fmus.contact.parameters import FASTSIM, WITH_MEMORY
from orchestrator import load, simulate
from orchestrator.paper.time_domain import Facts, facts_of

DURATION = 6.0
LAWS = {"steady": FASTSIM, "memory": WITH_MEMORY}


def facts(case: str, law: int) -> Facts:
    """Return what is known of the run of a case with a creep law."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = load(case, duration=DURATION, values={"contact": {"creep_law": law}})
        return facts_of(simulate(scenario, folder=folder).data)


def rows(found: Facts) -> dict[str, str]:
    """Return the rows of the table, by their heading."""
    cycle = found.cycle
    growth = max(found.growth, key=lambda g: g.pole, default=None)
    levels = [h.wheel["lat"] for h in cycle.harmonics]
    again = ", ".join(f"{20 * np.log10(level / levels[0]):.0f}" for level in levels[1:5])
    return {
        "strongest line [Hz]": f"{cycle.frequency_hz or 0:.1f}" + (" irregular" if cycle.irregular else ""),
        "fastest pole: growth rate, seen [1/s]": f"{growth.pole:.2f}, {growth.seen:.2f}" if growth else "-",
        "wheel, lateral rms [m/s]": f"{cycle.lateral_rms:.4f}",
        "change of the rms within the second half [%]": f"{100 * cycle.unsteadiness:.2g}",
        "strongest tone that is no harmonic [dB]": f"{cycle.second_tone_db:.0f}",
        "harmonics 2 to 5 of the wheel, lateral [dB]": again,
        "stick, contact lost [% of time]": f"{100 * (cycle.stick or 0):.0f}, {100 * (cycle.contact_lost or 0):.0f}",
        "friction force [kN]": "{:.1f} to {:.1f}".format(*(1e-3 * f for f in cycle.friction_force or (0, 0))),
        "level at 7.5 m [dB(A)]": f"{found.sound.level_dba:.1f}",
    }


def main(cases: list[str]) -> None:
    """Print a table for each case."""
    for case in cases:
        columns = {name: rows(facts(case, law)) for name, law in LAWS.items()}
        table = Table(title=case, title_justify="left")
        for heading in ("", *columns):
            table.add_column(heading)
        for heading in columns["steady"]:
            table.add_row(escape(heading), *(column[heading] for column in columns.values()))
        Console(width=120).print(table)


if __name__ == "__main__":
    main(sys.argv[1:] or ["case1", "case2", "case3", "case4"])
