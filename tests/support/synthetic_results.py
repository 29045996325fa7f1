"""Results of runs that never were: given motion of given modes of the generic wheelset, to test what is made of it."""

from __future__ import annotations

import json

import numpy as np
import xarray as xr

from fmus.interface import MODAL_VELOCITY_UNIT
from fmus.wheel.wheelset import DATA, Wheelset, read_wheelset

STEP = 5e-6
EVERY = 4


def generic() -> Wheelset:
    return read_wheelset(DATA / "generic840.toml")


def mode_number(label: str) -> int:
    """Return the index of a mode such as '(3,0)', cosine family."""
    return generic().modes.labels.index(f"{label} cosine")


def vibrating(tones: dict[str, tuple[float, float]], duration: float = 2.0) -> xr.Dataset:
    """Return results in which modes vibrate as sines.

    Parameters
    ----------
    tones : frequency [Hz] and amplitude [kg^1/2 m/s] by label
    """
    wheelset = generic()
    count = round(duration / (STEP * EVERY))
    time = STEP * EVERY * (1 + np.arange(count))
    quiet = np.zeros(count, np.float32)
    moving = {mode_number(label): tone for label, tone in tones.items()}
    columns = {}
    for i in range(len(wheelset.modes)):
        values = quiet
        if i in moving:
            frequency, amplitude = moving[i]
            values = (amplitude * np.sin(2 * np.pi * frequency * time)).astype(np.float32)
        columns[f"wheel.modal_velocity_{i + 1:03d}"] = ("time", values, {"units": MODAL_VELOCITY_UNIT})
    frequencies = {f"frequency_{i + 1:03d}": w / (2 * np.pi) for i, w in enumerate(wheelset.modes.omega)}
    return xr.Dataset(
        columns,
        coords={"time": ("time", time, {"units": "s"})},
        attrs={
            "case": "synthetic",
            "step_s": STEP,
            "record_every": EVERY,
            "all_parameters": json.dumps({"wheel": frequencies}),
        },
    )
