"""The time stage: an assembly in, tone, level and growth of a simulated run out. Nothing is written."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fmus.modal.parameters import modal_velocities
from fmus.wheel.wheelset import Wheelset

from ...coupling.master import Master
from ...errors import InputError
from ...runs.attributes import all_parameters
from ...runs.verdict import energy_share
from ...signals.limit_cycle import SQUEAL_VELOCITY
from ...signals.lines import is_irregular
from ...signals.summary import sample_interval, summarise
from ...sound.levels import sound_of
from ...sound.wheelset import wheelset_of
from ..prepared import Prepared, structure_key
from ..rows import Number, Quantity
from .ended import ended_in

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

RESOLUTION_HZ = 2.0
COARSEST_HZ = 7.5
"""Distance of the lines of a spectrum, and the largest one from which bands can be made where a run is short [Hz]."""

QUANTITIES = (
    Quantity("squeals", "1", "1 if the wheel vibrates laterally at the end of the run, 0 if not"),
    Quantity("tone", "Hz", "dominant frequency of the wheel's lateral velocity, second half", lacks=True),
    Quantity("irregular", "1", "1 if that is no tone, for the motion has no line spectrum, 0 if it is", lacks=True),
    Quantity(
        "ended_in", "", "limit cycle or two tones that the run ended in, irregular, at rest, or none that is known"
    ),
    Quantity("mode", "", "wheel mode with the largest velocity in the second half"),
    Quantity("level", "dB", "A-weighted sound pressure level, second half", lacks=True),
    Quantity("level_low", "dB", "lower end of the band of the level", lacks=True),
    Quantity("level_high", "dB", "upper end of the band of the level", lacks=True),
    Quantity("lateral_rms", "m/s", "lateral velocity of the wheel, rms, second half"),
    Quantity("contact_lost", "1", "part of the second half without normal force", lacks=True),
    Quantity("growth_seen", "s-1", "growth rate of the wheel's lateral velocity while it grows", lacks=True),
    Quantity("energy_residual", "1", "energy that the coupling adds, of the energy into wheel and rail", lacks=True),
)


@dataclass
class _Kept:
    """Rows of a run in memory, in single precision, which leaves room for many runs at once."""

    path: Path = field(default_factory=Path)
    rows: int = 0
    times: list[NDArray[np.float64]] = field(default_factory=list)
    values: list[NDArray[np.float32]] = field(default_factory=list)

    def append(self, time: NDArray[np.float64], rows: NDArray[np.float64]) -> None:
        """Take rows."""
        self.times.append(time)
        self.values.append(rows.astype(np.float32))
        self.rows += len(time)

    def sync(self) -> None:
        """Do nothing: there is no disk."""


def simulated(prepared: Prepared) -> dict[str, Number]:
    """Return what a run of the system ends in.

    Raises
    ------
    InputError
        If it cannot be run.
    SimulationError
        If a component fails.
    """
    assembly, settings = prepared.assembly, prepared.settings
    kept = _Kept()
    with Master(assembly, settings) as master:
        progress = master.run(kept)
        data = _dataset(master, kept)
        wheelset = _wheelset(prepared, master, data)
    summary = summarise(data)
    lateral = summary.wheel_velocity_rms.get("lat", np.nan)
    share = energy_share(progress)
    loud = lateral > SQUEAL_VELOCITY
    irregular = is_irregular(data["wheel.v_lat"].to_numpy(), sample_interval(data)) if loud else None
    tone = summary.dominant_frequency_hz
    still = not loud and not (summary.growth_rate or 0.0) > 0  # small and growing is not at rest
    return {
        "squeals": float(loud),
        "tone": _number(tone),
        "irregular": _number(irregular),
        "ended_in": ended_in(prepared, None if still else tone, lateral, irregular) if prepared.compare else "",
        **_heard(data, wheelset),
        "lateral_rms": lateral,
        "contact_lost": _number(summary.contact_lost),
        "growth_seen": _number(summary.growth_rate),
        "energy_residual": np.nan if share is None else share,
    }


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _dataset(master: Master, kept: _Kept) -> xr.Dataset:
    """Return the rows of a run as a results file has them."""
    import xarray as xr  # noqa: PLC0415

    values = np.concatenate(kept.values)
    signals = {
        column.name: ("time", values[:, k], {"units": column.unit})
        for k, column in enumerate(master.signals())
        if column.dtype == np.float64
    }
    about = {"step_s": master.settings.step, "record_every": master.settings.record_every}
    return xr.Dataset(signals, {"time": np.concatenate(kept.times)}, about)


def _wheelset(prepared: Prepared, master: Master, data: xr.Dataset) -> Wheelset | None:
    """Return the wheelset whose radiating areas are those of the wheel; None if it is not known."""
    known, fmus = prepared.workshop.wheelsets, master.assembly.fmus
    if "wheel" not in fmus:
        return None
    key = structure_key(fmus["wheel"], master.parameters["wheel"])
    if key not in known:
        about = json.dumps(all_parameters({"wheel": fmus["wheel"]}, master.parameters))
        try:
            known[key] = wheelset_of(data.assign_attrs(all_parameters=about))
        except InputError:
            known[key] = None
    return known[key]


def _heard(data: xr.Dataset, wheelset: Wheelset | None) -> dict[str, Number]:
    """Return the level and its band, and the mode that moves most."""
    velocities = modal_velocities("wheel", data.data_vars)
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    duration = half.sizes["time"] * sample_interval(data)
    squares = [float(np.square(half[name].to_numpy()).mean()) for name in velocities]
    found: dict[str, Number] = {"mode": "", "level": np.nan, "level_low": np.nan, "level_high": np.nan}
    if squares:
        k = int(np.argmax(squares))
        found["mode"] = str(k + 1) if wheelset is None or not wheelset.modes.labels else wheelset.modes.labels[k]
    resolution = max(RESOLUTION_HZ, 1.001 / duration)
    if wheelset is not None and len(wheelset.modes) == len(velocities) and resolution <= COARSEST_HZ:
        sound = sound_of(data, wheelset, resolution_hz=resolution)
        levels = (sound.level_dba, sound.low_dba, sound.high_dba)
        found.update(zip(("level", "level_low", "level_high"), levels, strict=True))
    return found


def squeals(values: dict[str, Number]) -> bool:
    """Return whether a run ended in squeal."""
    return bool(values["squeals"])
