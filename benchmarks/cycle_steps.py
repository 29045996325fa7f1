"""Error of the communication step: the level of runs that start on a limit cycle, against the cycle's own.

    python benchmarks/cycle_steps.py [case1 1100 1977 3976 5019 ...]

Prints the rms lateral velocity of the wheel from 0.1 to 0.3 s at 10, 5 and 2.5 us. The cycle is made without
steps, so it is the limit that these tend to.
"""

from __future__ import annotations

import sys
import tempfile

import numpy as np
from rich.console import Console
from rich.table import Table

from orchestrator import cycles, load, simulate

STEPS = (1e-5, 5e-6, 2.5e-6)
BEGIN, END = 0.1, 0.3
TONES = {"case1": ("272", "1100", "1977", "2950", "3976", "5019"), "case2": ("1980",)}


def level(system: str, tone: float, step: float) -> float:
    """Return the rms lateral velocity of the wheel in a run from a cycle [m/s]."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = load(system, duration=END, step=step, start_cycle=tone, record_every=2)
        lateral = simulate(scenario, folder=folder).data["wheel.v_lat"].load()
    late = lateral["time"].to_numpy() > BEGIN
    return float(np.sqrt(np.square(lateral.to_numpy()[late].astype(float)).mean()))


def main(system: str, tones: tuple[str, ...]) -> None:
    """Print the table of a system."""
    table = Table(title=f"{system}: rms of the wheel's lateral velocity in m/s, and its error", title_justify="left")
    for heading in ("tone [Hz]", "cycle", *(f"{1e6 * step:g} us" for step in STEPS)):
        table.add_column(heading, justify="right")
    for tone in map(float, tones):
        found = cycles(system, tone_hz=tone, with_stability=False).all_near(tone)
        cycle = min(found, key=lambda c: abs(c.frequency_hz - tone))
        exact = cycle.wheel_velocity_rms["lat"]
        cells = [f"{100 * (level(system, tone, step) / exact - 1):+.2f} %" for step in STEPS]
        table.add_row(f"{cycle.frequency_hz:.1f}", f"{exact:.5f}", *cells)
    Console(width=120).print(table)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main(sys.argv[1], tuple(sys.argv[2:]) or TONES["case1"])
    else:
        for name, chosen in TONES.items():
            main(name, chosen)
