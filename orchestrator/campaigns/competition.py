"""Which tone wins: many starts of one system as a campaign, and the shares of the tones that they end in.

Several unstable modes grow at once and one of them takes over; which one depends on how the vibration starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..signals.tones import Tone, tones_of_runs
from .plan import Plan, make_plan
from .rows import DONE, FAILED
from .store import open_campaign
from .sweep import How, sweep

RECORD_EVERY = 8

_SPRING, _START, _SEED = "contact.hertz_stiffness", "start_hz", "seed"


@dataclass(frozen=True)
class Starts:
    """Which starts of a system compete.

    Attributes
    ----------
    runs, seed : number of random starts, and the first seed
    modes : frequencies of the wheel modes to start on [Hz]; none: no mode is preferred
    stiffness : of the contact spring [N/m]; none: as the system says
    """

    runs: int
    seed: int = 0
    modes: Sequence[float] = ()
    stiffness: Sequence[float] = ()

    def __post_init__(self) -> None:
        """Check the values."""
        if self.runs < 1:
            raise InputError(f"runs = {self.runs}: must be at least 1")
        if self.seed < 0:
            raise InputError(f"seed = {self.seed}: must be >= 0")
        for value in self.stiffness:
            if not 0 < value < np.inf:
                raise InputError(f"stiffness = {value:g}: must be > 0, such as 1.2e9 N/m")


@dataclass(frozen=True)
class Ended:
    """How a competition ended.

    Attributes
    ----------
    groups : tones by what was common to their starts, in words
    wanted, done : numbers of runs
    failures : sentences of the runs that failed
    store : where the runs are
    """

    groups: dict[str, list[Tone]]
    wanted: int
    done: int
    failures: tuple[str, ...]
    store: Path


def competition_plan(system: str, starts: Starts, duration: float | None = None, step: float | None = None) -> Plan:
    """Return the plan of a competition: every start and stiffness with every seed."""
    where: dict[str, Any] = {"file" if Path(system).suffix else "case": system}
    where |= {name: value for name, value in (("duration", duration), ("step", step)) if value is not None}
    vary: dict[str, Any] = {}
    if starts.stiffness:
        vary[_SPRING] = list(dict.fromkeys(starts.stiffness))
    if starts.modes:
        vary[_START] = list(dict.fromkeys(starts.modes))
    vary[_SEED] = {"from": starts.seed, "to": starts.seed + starts.runs - 1}
    compute = {"stage": "time", "record_every": RECORD_EVERY, "sound": False}
    return make_plan({"system": where, "vary": vary, "compute": compute})


def compete(plan: Plan, folder: Path, how: How) -> Ended:
    """Run a competition; runs that an earlier one in the folder has made are not made again.

    Raises
    ------
    InputError
        If the system cannot be run.
    """
    name = f"competition-{Path(plan.base.system).stem}"
    store = folder / f"{name}-{plan.digest[:8]}.zarr"
    kin = tuple(path for path in sorted(folder.glob(f"{name}-*.zarr")) if path != store)
    ended = sweep(plan, store, how, kin)
    data = open_campaign(store).load()
    groups: dict[str, list[int]] = {}
    for k in np.flatnonzero(data["status"].to_numpy() == DONE):
        start = f"started at {float(data[_START][k]):g} Hz" if _START in data else "random start"
        spring = f", {float(data[_SPRING][k]):g} N/m" if _SPRING in data else ""
        groups.setdefault(start + spring, []).append(int(k))
    failed = np.flatnonzero(data["status"].to_numpy() == FAILED)
    failures = tuple(sorted({str(data["message"].to_numpy()[k]) for k in failed}))
    tone, irregular = (data[name].to_numpy() for name in ("tone", "irregular"))
    found = {words: tones_of_runs(tone[rows], irregular[rows]) for words, rows in groups.items()}
    return Ended(found, ended.wanted, ended.done, failures, store)
