"""Which tone wins: many starts of one system as a campaign, and the shares of the tones that they end in.

Several unstable modes grow at once and one of them takes over; which one depends on how the vibration starts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..limit_cycles.search import cycles_of
from ..runs.scenario import Scenario
from ..signals.tones import SAME_TONE, Tone, tones_of_runs
from .ends import Ends, missing_words
from .plan import Plan, make_plan
from .prepared import pack
from .rows import DONE, FAILED
from .store import open_campaign
from .sweep import How, sweep

Real = NDArray[np.floating[Any]]

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
    lateral_rms : median lateral velocity of the wheel [m/s] of each tone of `groups`
    """

    groups: dict[str, list[Tone]]
    wanted: int
    done: int
    failures: tuple[str, ...]
    store: Path
    lateral_rms: dict[str, list[float]]


def competition_plan(scenario: Scenario, starts: Starts) -> Plan:
    """Return the plan of a competition: every start and stiffness of a scenario with every seed."""
    where: dict[str, Any] = {"file" if Path(scenario.system).suffix else "case": scenario.system}
    how = {"duration": scenario.duration, "step": scenario.step}
    where |= {name: value for name, value in how.items() if value is not None}
    if scenario.values:
        where["set"] = {f"{c}.{name}": value for c, own in scenario.values.items() for name, value in own.items()}
    if scenario.sources:
        where["replace"] = {name: str(file.absolute()) for name, file in scenario.sources.items()}
    vary: dict[str, Any] = {}
    if starts.stiffness:
        vary[_SPRING] = list(dict.fromkeys(starts.stiffness))
    if starts.modes:
        vary[_START] = list(dict.fromkeys(starts.modes))
    vary[_SEED] = {"from": starts.seed, "to": starts.seed + starts.runs - 1}
    compute = {"stage": "time", "record_every": RECORD_EVERY, "sound": False, "compare": False}
    return make_plan({"system": where, "vary": vary, "compute": compute})


def compete(plan: Plan, folder: Path, how: How) -> Ended:
    """Run a competition; runs that an earlier one in the folder has made are not made again.

    Raises
    ------
    InputError
        If the system cannot be run.
    """
    name = f"competition-{Path(plan.base.system).stem}"
    store = folder / f"{name}-{pack(plan)[0].digest[:8]}.zarr"
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
    lateral = data["lateral_rms"].to_numpy()
    levels = {
        words: [_median(lateral[rows], tone[rows], irregular[rows], t) for t in found[words]]
        for words, rows in groups.items()
    }
    return Ended(found, ended.wanted, ended.done, failures, store, levels)


def _median(lateral: Real, frequency_hz: Real, irregular: Real, tone: Tone) -> float:
    """Return the median lateral rms of the runs that ended in a tone; nan at rest and without one."""
    if tone.frequency_hz is None:
        return float("nan")
    chosen = (np.abs(frequency_hz / tone.frequency_hz - 1) < SAME_TONE) & (irregular != 1)
    return float(np.median(lateral[chosen]))


def against_cycles(plan: Plan, ended: Ended) -> dict[str, tuple[str, ...]]:
    """Return what each group's tones are, and which cycles that last no run ended in, in words.

    Raises
    ------
    InputError
        If the cycles of the system are not known.
    """
    words: dict[str, tuple[str, ...]] = {}
    known: dict[str, Ends] = {}
    for group, found in ended.groups.items():
        spring = group.rpartition(", ")[2].removesuffix(" N/m") if group.endswith("N/m") else ""
        if spring not in known:
            base = plan.base
            values = {name: dict(own) for name, own in base.values.items()}
            if spring:
                values.setdefault("contact", {})["hertz_stiffness"] = spring
            sources = {name: Path(file) for name, file in base.sources.items()}
            assembly, settings = Scenario(base.system, step=base.step, values=values, sources=sources).prepare()
            known[spring] = Ends(cycles_of(assembly, settings.step))
        tones = [t.frequency_hz for t in found if t.frequency_hz is not None]
        lines = [
            f"{t.words}: {known[spring].words(t.frequency_hz, rms)}"
            for t, rms in zip(found, ended.lateral_rms[group], strict=True)
            if t.frequency_hz is not None
        ]
        missing = missing_words(known[spring].found, tones)
        words[group] = (*lines, *([missing] if missing else []))
    return words
