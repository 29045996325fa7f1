"""Checkpoints: everything that the rest of a run depends on, in one file that is always whole.

The file is a zip of arrays (NumPy's .npz): the scenario as JSON text, the states of the FMUs as bytes, the master's own
numbers, and how many rows the results file had.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coupling.assembly import Assembly
from ..coupling.master import Master
from ..coupling.settings import Settings
from ..errors import InputError, SimulationError
from ..results.file import ResultsFile
from .attributes import RUN
from .identity import difference, resolved
from .scenario import Scenario

FORMAT = 3
"""Version of the file format."""

_NUMBERS = ("u", "u_word", "y", "y_word", "energy", "u_scale", "sweeps")
"""Arrays of the plan that a run carries along."""


@dataclass(frozen=True)
class Checkpoint:
    """A run in the middle.

    Attributes
    ----------
    path : the file
    scenario : what was asked for
    run : random digits that only this run and its results have
    resolved : what the identity of the scenario is the hash of
    checksums : of the FMUs, by component
    states : of the FMUs, by component
    numbers : the master's arrays
    steps : steps made
    wall : wall time so far [s]
    results : the results file
    rows : its rows when the checkpoint was made
    """

    path: Path
    scenario: Scenario
    run: str
    resolved: Mapping[str, Any]
    checksums: Mapping[str, str]
    states: Mapping[str, bytes]
    numbers: Mapping[str, NDArray[Any]]
    steps: int
    wall: float
    results: Path
    rows: int

    def check(self, assembly: Assembly, settings: Settings) -> None:
        """Raise InputError if what would run now is not what was run until the checkpoint."""
        for name, fmu in assembly.fmus.items():
            if self.checksums.get(name, fmu.checksum) != fmu.checksum:
                raise InputError(f"{self.path}: {name} ({fmu.path}) is not the FMU that the checkpoint was made with")
        other = difference(self.resolved, resolved(assembly, settings))
        if other is not None:
            raise InputError(f"{self.path}: the run cannot go on, as it is another one now: {other}")
        if not 0 <= self.steps <= settings.steps or self.states.keys() != assembly.fmus.keys():
            raise InputError(f"{self.path}: is damaged: its steps and states are not those of the run")

    def restore(self, master: Master) -> None:
        """Put the state of the run into a master that is initialised.

        Raises
        ------
        InputError
            If the numbers or states are not those of such a run.
        """
        for name, values in self.numbers.items():
            own = getattr(master.plan, name)
            if values.shape != own.shape or values.dtype != own.dtype:
                raise InputError(f"{self.path}: is damaged: its numbers {name} are not those of the run")
        try:
            for name, instance in master.instances.items():
                instance.restore(self.states[name])
        except SimulationError as error:
            raise InputError(f"{self.path}: {error}") from None
        for name, values in self.numbers.items():
            getattr(master.plan, name)[...] = values
        master.refresh()
        master.progress.steps, master.progress.wall = self.steps, self.wall


def check_serialisable(assembly: Assembly) -> None:
    """Raise InputError if the state of an FMU cannot be kept."""
    for name, fmu in assembly.fmus.items():
        if not fmu.can_serialise:
            raise InputError(f"checkpoint: {name} ({fmu.path.name}) cannot serialise its state, so it cannot be kept")


def write_checkpoint(
    path: Path, scenario: Scenario, master: Master, results: ResultsFile, known: Mapping[str, Any]
) -> None:
    """Write a checkpoint; the file that was there before stays whole until the new one is.

    Parameters
    ----------
    results : the results of the run, which are on the disk before the checkpoint says so
    known : what the identity of the scenario is the hash of

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    results.sync()
    head = {
        "format": FORMAT,
        "scenario": _as_data(scenario),
        "checksums": {name: fmu.checksum for name, fmu in master.assembly.fmus.items()},
        "steps": master.progress.steps,
        "wall": master.progress.wall,
        "results": str(results.path.absolute()),
        "rows": results.rows,
        "run": results.attributes[RUN],
        "resolved": known,
    }
    arrays = {f"number_{name}": getattr(master.plan, name) for name in _NUMBERS}
    for name, instance in master.instances.items():
        arrays[f"state_{name}"] = np.frombuffer(instance.save(), dtype=np.uint8)
    partial = path.with_name(f".{results.attributes[RUN]}.partial")  # of this run alone
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with partial.open("wb") as file:
            np.savez(file, head=np.frombuffer(json.dumps(head).encode(), dtype=np.uint8), **arrays)
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
    except OSError as error:
        raise InputError(f"checkpoint {path}: cannot be written: {error.strerror or error}") from None


def _as_data(scenario: Scenario) -> dict[str, Any]:
    """Return a scenario as JSON data that means the same in any folder."""
    data = asdict(scenario.absolute())
    return {**data, "sources": {name: str(source) for name, source in data["sources"].items()}}


def read_checkpoint(path: Path) -> Checkpoint:
    """Return the checkpoint in a file.

    Raises
    ------
    InputError
        If the file is missing or is no checkpoint.
    """
    if not path.is_file():
        raise InputError(f"{path}: no such checkpoint file")
    try:
        with np.load(path, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        head = json.loads(arrays["head"].tobytes())
        if head["format"] != FORMAT:
            raise InputError(f"{path}: is a checkpoint of format {head['format']}; this version reads format {FORMAT}")
        fields = head["scenario"]
        sources = {name: Path(source) for name, source in fields["sources"].items()}
        return Checkpoint(
            path,
            Scenario(**{**fields, "sources": sources}),
            str(head["run"]),
            head["resolved"],
            head["checksums"],
            {name.removeprefix("state_"): a.tobytes() for name, a in arrays.items() if name.startswith("state_")},
            {name: arrays[f"number_{name}"] for name in _NUMBERS},
            int(head["steps"]),
            float(head["wall"]),
            Path(head["results"]),
            int(head["rows"]),
        )
    except InputError:
        raise
    except Exception as error:  # a damaged archive makes zipfile and numpy raise whatever they like
        raise InputError(f"{path}: is not a checkpoint of curvesqueal: {error}") from None
