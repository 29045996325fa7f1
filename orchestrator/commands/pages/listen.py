"""The command `curvesqueal listen`: results in, sound file and levels out."""

from __future__ import annotations

from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from ...errors import InputError, SimulationError
from ...runs.changes import Changes
from ..options import changes_system
from ..progress import run_bar
from ..tools import Force, Json, notice, require_free, require_suffix, screen

if TYPE_CHECKING:  # xarray takes a second to import
    from ...sound.levels import Sound

WheelOption = Annotated[
    str | None,
    typer.Option(
        help="Wheel of the run that is made first, as of `run`; for results: whose radiating areas to take, by default "
        "those of their own wheel."
    ),
]
Distance = Annotated[float, typer.Option(help="From the wheel to the receiver [m].")]


@partial(changes_system, wheel=WheelOption)
def listen(  # noqa: PLR0913 - one argument per option
    source: Annotated[
        str, typer.Argument(metavar="RESULTS|CASE|FILE", help="Results of a run (.nc), or what is run first.")
    ],
    *,
    changes: Changes,
    out: Annotated[Path | None, typer.Option(help="WAV file to write; default: beside the results.")] = None,
    duration: Annotated[float | None, typer.Option(help="Simulated time of the run that is to be made [s].")] = None,
    distance: Distance = 7.5,
    force: Force = False,
    json: Json = False,
) -> None:
    """Make the sound of a run: a WAV file of the pressure at the receiver, with its calibration beside it.

    Of results that are there, or of a case or system that is run first with the same options as `run`.
    """
    from ...results.file import open_results  # noqa: PLC0415
    from ...sound.levels import RailSound, sound_of  # noqa: PLC0415 - loads scipy and xarray
    from ...sound.radiation import Radiation  # noqa: PLC0415
    from ...sound.wav import pressure_of, write_wav  # noqa: PLC0415

    results, wheel = _results(source, changes, duration, None if out is None else out.parent)
    path = results.with_suffix(".wav") if out is None else out
    require_suffix(path, (".wav",))
    require_free(path, force)
    radiation = Radiation(distance=distance)
    with open_results(results) as data:
        pressure = pressure_of(data, wheel, radiation)
        half = data.sizes["time"] // 2 * float(data.attrs["step_s"]) * int(data.attrs["record_every"])
        sound = sound_of(data, wheel, radiation, max(2.0, 1.01 / half))
        calibration = write_wav(pressure, path, f"{data.attrs['case']}, {results.name}")
    if json:
        levels = {
            "level_dba": sound.level_dba, "low_dba": sound.low_dba, "high_dba": sound.high_dba,
            "radiated_share": sound.radiated_share, "total_dba": sound.total_dba,
            "rail": asdict(sound.rail) if isinstance(sound.rail, RailSound) else {"unknown": sound.rail},
        }  # fmt: skip
        screen.print_json(data={"file": str(path), **asdict(calibration), **levels})
        return
    screen.print(
        f"{path}  ({calibration.duration_s:.2f} s; full scale {calibration.full_scale_pa:.3g} Pa)", highlight=False
    )
    screen.print(
        f"{sound.level_dba:.1f} dB(A) at {distance:g} m, {sound.low_dba:.1f} to {sound.high_dba:.1f} dB(A) with the "
        f"doubtful coefficients of the radiation model; wheel: {sound.wheelset}",
        highlight=False,
        soft_wrap=True,
    )
    for line in further(sound):
        screen.print(line, highlight=False, soft_wrap=True)


def _results(source: str, changes: Changes, duration: float | None, folder: Path | None) -> tuple[Path, str | None]:
    """Return a results file, and the wheelset to take for it; runs the system if it is not a results file."""
    if Path(source).suffix == ".nc":
        if changes != Changes(wheel=changes.wheel) or duration is not None:
            raise InputError(f"{source}: is the result of a run; only a case or a system can be changed")
        return Path(source), changes.wheel
    from ...runs.run import Report, run_scenario  # noqa: PLC0415 - loads the master

    with run_bar() as progress:
        report = Report(progress, notice, picture=False)
        outcome = run_scenario(changes.scenario(source, duration=duration), folder or Path("results"), report)
    if outcome.error is not None:
        raise SimulationError(f"{outcome.error}; results up to then are in {outcome.results}")
    return outcome.results, None


def further(sound: Sound) -> list[str]:
    """Return what there is to say about the energy and about the rail, in sentences."""
    lines = []
    if sound.radiated_share is not None:
        lines.append(f"The wheel radiates {100 * sound.radiated_share:.0f} % of what its damping takes.")
    if isinstance(sound.rail, str):
        lines.append(f"The rail's sound is not known: {sound.rail}.")
    elif np.isfinite(sound.rail.level_dba):
        lines.append(f"The rail alone makes {sound.rail.level_dba:.1f} dB(A), both {sound.total_dba:.1f} dB(A).")
    else:
        lines.append("The rail does not move, so it is silent.")
    return lines
