"""Figures 8 to 12 of the paper and what its text says of them: results of the four cases in, items and pictures out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..figures.run import draw_directions, draw_sound
from ..published.cases import CASES, INFERRED, PAPER_HZ, SAME_TONE
from ..results.file import open_results
from ..signals.axes import NORMAL, PLANE
from ..signals.limit_cycle import Growth, LimitCycle, growth_of, limit_cycle
from ..sound.levels import Sound, sound_of
from ..stability.analysis import REPORTED_BELOW_HZ
from ..stability.linear_model import model_of
from .page import Item, Row

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr


SIMILAR_DB = 6.0
"""Levels within this range count as similar: the paper says "quite similar" without a number."""

_WORDS = {"lat": "lateral", "ver": "vertical", PLANE: "lateral in the contact plane", NORMAL: "contact normal"}


@dataclass(frozen=True)
class Facts:
    """What is known of the run of one case.

    Attributes
    ----------
    title : of the case
    cycle, growth, sound : of the run
    gains : loop gains of the linear system by frequency [Hz]; empty where components do not tell their modes
    normal_ratio : rail over wheel along the contact normal at the dominant tone, linear; None without a tone
    """

    title: str
    cycle: LimitCycle
    growth: tuple[Growth, ...]
    sound: Sound
    gains: dict[float, float]
    normal_ratio: float | None = None


def items(results_folder: Path, figures: Path) -> list[Item]:
    """Return the time-domain items of the paper and write their pictures.

    Parameters
    ----------
    results_folder : with case1.nc to case4.nc, as `curvesqueal run` leaves them; inferred1.nc to inferred4.nc get a
        column
    figures : folder for the pictures

    Raises
    ------
    InputError
        If the results of a case are missing, or hold no sound.
    """
    missing = [case for case in CASES if not (results_folder / f"{case}.nc").is_file()]
    if missing:
        raise InputError(f"{results_folder}: has no {missing[0]}.nc; run: curvesqueal run {missing[0]} first")
    figures.mkdir(parents=True, exist_ok=True)
    pictures = {}
    facts: dict[str, Facts] = {}
    for number, case in enumerate(CASES, start=8):
        pictures[case] = figures / f"figure-{number}.png"
        with open_results(results_folder / f"{case}.nc") as data:
            facts[case] = facts_of(data)
            draw_directions(data, pictures[case])
    picture = figures / "figure-12.png"
    draw_sound({case: f.sound for case, f in facts.items()}, picture)
    found = [*histories(facts, pictures), radiation(facts, (picture,)), *claims(facts)]
    twins = _inferred(results_folder)
    if not twins:
        return found
    beside = [*histories(twins, {}), radiation(twins), *claims(twins)]
    return [a.beside(b, f"Inferred: {b.sentence}") for a, b in zip(found, beside, strict=True)]


def _inferred(results_folder: Path) -> dict[str, Facts]:
    """Return what is known of the runs of the inferred cases, by the case as printed; nothing if one is missing."""
    files = {case: results_folder / f"{twin}.nc" for case, twin in zip(CASES, INFERRED, strict=True)}
    if not all(file.is_file() for file in files.values()):
        return {}
    facts = {}
    for case, file in files.items():
        with open_results(file) as data:
            facts[case] = facts_of(data)
    return facts


def histories(facts: Mapping[str, Facts], pictures: Mapping[str, Path]) -> list[Item]:
    """Return the items of Figs 8 to 11."""
    return [
        history(f"Figure {n}", case, f, (pictures[case],) if case in pictures else ())
        for n, (case, f) in enumerate(facts.items(), start=8)
    ]


def facts_of(data: xr.Dataset) -> Facts:
    """Return what is known of a run."""
    model = model_of(data)
    cycle = limit_cycle(data)
    return Facts(
        title=str(data.attrs.get("title", data.attrs.get("case", ""))),
        cycle=cycle,
        growth=growth_of(data, model.poles),
        sound=sound_of(data),
        gains=model.loop_gains(REPORTED_BELOW_HZ),
        normal_ratio=None if cycle.frequency_hz is None else model.normal_ratio(cycle.frequency_hz),
    )


def history(label: str, case: str, facts: Facts, pictures: tuple[Path, ...] = ()) -> Item:
    """Return the item of a velocity history and its spectra."""
    cycle = facts.cycle
    rows: list[Row] = [_dominant(case, cycle)]
    rows += [(f"growth at {g.frequency_hz:.0f} Hz, pole {g.pole:.2f}", "1/s", None, g.seen, f"{g.seen - g.pole:+.2f}")
             for g in sorted(facts.growth, key=lambda g: -g.pole)[:3]]  # fmt: skip
    rows += [
        ("wheel, lateral velocity, rms", "m/s", None, cycle.lateral_rms, None),
        ("change of the rms within the second half", "%", None, 100 * cycle.unsteadiness, None),
        ("strongest tone that is no harmonic, re the dominant one", "dB", None, cycle.second_tone_db, None),
    ]
    rows += [
        (f"rail re wheel, {_WORDS[d]}, rms", "%", None, 100 * r, None) for d, r in cycle.rail_to_wheel.items() if r > 0
    ]
    if cycle.stick is not None and cycle.normal_force is not None and cycle.friction_force is not None:
        rows += [
            ("friction force below 95 % of its limit (stick)", "% of time", None, 100 * cycle.stick, None),
            ("contact lost", "% of time", None, 100 * (cycle.contact_lost or 0.0), None),
            ("normal force, smallest and largest", "kN", None, _range(cycle.normal_force), None),
            ("friction force, smallest and largest", "kN", None, _range(cycle.friction_force), None),
        ]
    return Item(label, f"time history of {facts.title}", tuple(rows), _history_sentence(case, cycle), pictures)


def _dominant(case: str, cycle: LimitCycle) -> Row:
    paper, ours = PAPER_HZ[case], cycle.frequency_hz
    return ("dominant frequency", "Hz", paper, ours, None if ours is None else f"{100 * (ours / paper - 1):+.2f} %")


def _range(values: tuple[float, float]) -> str:
    return f"{values[0] / 1e3:.1f} to {values[1] / 1e3:.1f}"


def _history_sentence(case: str, cycle: LimitCycle) -> str:
    """Return what a history says of the paper's figure."""
    if not cycle.squeals or cycle.frequency_hz is None:
        return "Miss: no squeal, the vibration dies away."
    steady = "A limit cycle is reached" if cycle.steady else "The level still changes"
    if as_published(case, cycle):
        return f"{steady}; the dominant tone is the paper's."
    return (
        f"{steady}. Miss: {cycle.frequency_hz:.0f} Hz dominates, not {PAPER_HZ[case]:.0f} Hz. Both tones are stable "
        "limit cycles with this wheel; which one wins depends on the start (docs/time-domain.md)."
    )


def as_published(case: str, cycle: LimitCycle) -> bool:
    """Return whether the dominant tone is the paper's, within 1 %."""
    return cycle.frequency_hz is not None and abs(cycle.frequency_hz / PAPER_HZ[case] - 1) < SAME_TONE


def radiation(facts: Mapping[str, Facts], pictures: tuple[Path, ...] = ()) -> Item:
    """Return the item of Fig. 12: A-weighted levels at 7.5 m, of the wheel, of the rail, and of both."""
    rows: list[Row] = []
    for case, f in facts.items():
        band = f"{f.sound.low_dba:.1f} to {f.sound.high_dba:.1f}"
        rows.append((f"{case}, A-weighted level at 7.5 m", "dB(A)", None, f"{f.sound.level_dba:.1f} ({band})", None))
        if f.sound.rail_dba is not None:
            rows.append((f"{case}, the rail's", "dB(A)", None, f"{f.sound.rail_dba:.1f}", None))
            rows.append((f"{case}, wheel and rail", "dB(A)", None, f"{f.sound.total_dba:.1f}", None))
    sentence = (
        "The paper's figure is a curve without numbers. In brackets what doubtful coefficients of the radiation model, "
        "a receiver on the axis and a hard ground make of it. The rail's sound is not in the paper."
    )
    if not pictures:
        sentence = f"levels of the wheel within {_spread(facts):.1f} dB."
    return Item("Figure 12", "noise radiation from the wheel", tuple(rows), sentence, pictures)


def claims(facts: Mapping[str, Facts]) -> list[Item]:
    """Return what the text says of Figs 8 to 12, with numbers."""
    return [_steady(facts), _one_tone(facts), _with_and_without_rail(facts), _not_the_largest_gain(facts),
            _rail_smaller(facts), _rail_larger(facts), _similar_levels(facts)]  # fmt: skip


def _verdict(holds: bool, reason: str) -> str:
    return "Holds." if holds else f"Miss: {reason}"


def _steady(facts: Mapping[str, Facts]) -> Item:
    rows = tuple(
        (f"{case}: change of the rms within the second half", "%", None, 100 * f.cycle.unsteadiness, None)
        for case, f in facts.items()
    )
    holds = all(f.cycle.steady for f in facts.values())
    return Item("Claim", "a steady state is obtained in all four cases", rows, _verdict(holds, "see the numbers."))


def _one_tone(facts: Mapping[str, Facts]) -> Item:
    rows = tuple(
        (f"{case}: strongest tone that is no harmonic, re the dominant one", "dB", None, f.cycle.second_tone_db, None)
        for case, f in facts.items()
    )
    holds = all(f.cycle.second_tone_db < -20 for f in facts.values())
    return Item(
        "Claim", "of several unstable frequencies only one becomes dominant", rows, _verdict(holds, "see above.")
    )


def _with_and_without_rail(facts: Mapping[str, Facts]) -> Item:
    rows = tuple(_dominant(case, f.cycle) for case, f in facts.items())
    rows = tuple((f"{case}: {row[0]}", *row[1:]) for case, row in zip(facts, rows, strict=True))
    missed = [case for case, f in facts.items() if not as_published(case, f.cycle)]
    reason = f"not in {', '.join(missed)} from the default start; docs/time-domain.md has the distribution over starts."
    return Item("Claim", "1100 Hz dominates with the rail, 1978 Hz without", rows, _verdict(not missed, reason))


def _not_the_largest_gain(facts: Mapping[str, Facts]) -> Item:
    rows: list[Row] = []
    others = []
    for case, f in facts.items():
        if not f.gains or f.cycle.frequency_hz is None:
            continue
        largest = max(f.gains, key=lambda hz: f.gains[hz])
        own = min(f.gains, key=lambda hz: abs(hz - (f.cycle.frequency_hz or 0.0)))
        rows.append((f"{case}: largest loop gain {f.gains[largest]:.2f} at", "Hz", None, largest, None))
        rows.append((f"{case}: gain {f.gains[own]:.2f} of the dominant tone at", "Hz", None, own, None))
        if largest != own:
            others.append(case)
    sentence = _verdict(bool(others), "the dominant tone has the largest gain everywhere.")
    sentence += f" The dominant tone is another one in {', '.join(others)}." if others else ""
    return Item("Claim", "the dominant tone is not necessarily that of the largest loop gain", tuple(rows), sentence)


def _rail_smaller(facts: Mapping[str, Facts]) -> Item:
    with_rail = {case: f for case, f in facts.items() if f.cycle.rail_to_wheel.get("lat", 0.0) > 0}
    rows = [
        (f"{case}: rail re wheel, {_WORDS[d]}, rms", "%", None, 100 * ratio, None)
        for case, f in with_rail.items()
        for d, ratio in f.cycle.rail_to_wheel.items()
    ]
    rows += [
        (f"{case}: normal ratio by the closed form, at the dominant tone", "%", None, 100 * f.normal_ratio, None)
        for case, f in with_rail.items()
        if f.normal_ratio is not None
    ]
    holds = all(f.cycle.rail_to_wheel[PLANE] < 0.5 for f in with_rail.values() if PLANE in f.cycle.rail_to_wheel)
    sentence = _verdict(holds, "see the numbers.") + (
        " It is true of the direction of the squeal, lateral in the contact plane. Along the contact normal no wheel "
        "can do it: the contact spring ties both together, rail over wheel is |Y33r| / |Y33r + j omega/K_H|, nearly "
        "1. The larger vertical ratio belongs to track axes, where the wheel's normal and lateral motion nearly cancel."
    )
    return Item("Claim", "the rail vibrates much less than the wheel", tuple(rows), sentence)


def _rail_larger(facts: Mapping[str, Facts]) -> Item:
    rows: list[Row] = []
    for case, f in facts.items():
        for h in f.cycle.harmonics:
            if h.frequency_hz in f.cycle.rail_above_wheel_hz:
                excess = float(20 * np.log10(h.rail["lat"] / h.wheel["lat"]))
                rows.append((f"{case}: rail over wheel, lateral, at {h.frequency_hz:.0f} Hz", "dB", None, excess, None))
    sentence = _verdict(bool(rows), "the rail is below the wheel at every harmonic.")
    sentence += " A steady limit cycle has lines at harmonics only, so rail modes show as their envelope, not as peaks."
    return Item("Claim", "the rail exceeds the wheel at harmonics or rail modes", tuple(rows), sentence)


def _spread(facts: Mapping[str, Facts]) -> float:
    """Return the largest minus the smallest level of the wheel [dB]."""
    levels = [f.sound.level_dba for f in facts.values()]
    return max(levels) - min(levels)


def _similar_levels(facts: Mapping[str, Facts]) -> Item:
    spread = _spread(facts)
    rows: tuple[Row, ...] = (("largest minus smallest level of the four cases", "dB", None, spread, None),)
    reason = (
        "on the rigid rail the limit cycle couples (4,0) with the radial mode (2,r), whose normal motion only the "
        "wheel's damping of 1e-4 limits: the normal force swings from nearly 0 to three times the load, and (2,r) "
        "radiates most. With the rail, which takes that energy, the levels are alike."
    )
    verdict = _verdict(spread < SIMILAR_DB, reason)
    return Item("Claim", "the sound pressure levels of the four cases are similar", rows, verdict)
