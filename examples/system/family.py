"""A family of squeal scenarios from one FMU, with nothing but FMPy: how the friction coefficient decides.

    curvesqueal build
    python examples/system/family.py build/curvesqueal.fmu

The FMU is the whole system, coupled inside: any FMI 2.0 host gets the right growth, whatever its own master does.
"""

from __future__ import annotations

import sys

import fmpy
import numpy as np

DURATION = 0.6
INTERVAL = 5e-5
GROWTH = (0.05, 0.2)
"""The part of the run in which the vibration is still small [s]."""


def growth_rate(time: np.ndarray, velocity: np.ndarray) -> float:
    """Return the slope of ln(rms) over the early part of the run [1/s]."""
    early = (time > GROWTH[0]) & (time < GROWTH[1])
    pieces = 10
    level = [np.log(np.sqrt(np.mean(piece**2))) for piece in np.array_split(velocity[early], pieces)]
    middle = [piece.mean() for piece in np.array_split(time[early], pieces)]
    return float(np.polyfit(middle, level, 1)[0])


def main() -> None:
    """Print growth rate and level for some friction coefficients, with falling and with constant friction."""
    file = sys.argv[1] if len(sys.argv) > 1 else "build/curvesqueal.fmu"
    print("mu0    falling ratio    growth rate [1/s]    rms velocity at the end [m/s]")  # noqa: T201
    for falling in (0.1, 0.0):
        for mu0 in (0.1, 0.2, 0.3, 0.4):
            result = fmpy.simulate_fmu(
                file,
                start_values={"mu0": mu0, "falling_ratio": falling},
                stop_time=DURATION,
                step_size=INTERVAL,
                output_interval=INTERVAL,
                output=["wheel_v_lat"],
            )
            velocity = result["wheel_v_lat"]
            rate = growth_rate(result["time"], velocity)
            level = np.sqrt(np.mean(velocity[-2000:] ** 2))
            print(f"{mu0:4.2f}   {falling:8.2f}       {rate:12.1f}   {level:20.2e}")  # noqa: T201


if __name__ == "__main__":
    main()
