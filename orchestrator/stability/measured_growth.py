"""What each master algorithm does to the growth rates of any system of FMUs: measured in its own steps.

Each connection is disturbed over one step; what the outputs do beyond an undisturbed run is the system's free decay,
of which the eigensystem realisation tells the modes. A run with the opposite disturbance, twice as large, tells whether
the system is linear: then its answer is the opposite, twice as large. Nothing is known of the FMUs but their outputs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import lcm, pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..coupling.algorithms import ALGORITHMS
from ..coupling.assembly import Assembly
from ..coupling.master import Master, Settings
from ..errors import InputError, SimulationError
from .realisation import FreeModes, realise

Real = NDArray[np.float64]

SAMPLES = 2400
"""Samples of a free decay, one per step."""

FINER = 8
"""The reference has steps that are shorter by this."""

MOST_CONNECTIONS = 16
"""Connections that are disturbed, at most: the first ones. A mode that none of them moves is not seen."""

DISTURBANCE = 1e-3
"""Size of a disturbance, relative to the largest value of the input in the undisturbed run."""

NONLINEAR = 1e-5
"""Difference of the answers to two disturbances, relative to the larger, from which a system is not linear."""

EARLY = 100
"""Samples that tell the size of an input, before anything has grown far."""

GROWN = 1e6
"""A decay that has grown by this hides its other modes; what follows is left out."""

REFERENCES = ("staggered", "iterative", "jacobi")
"""Algorithms that the reference is sought with, in this order."""


@dataclass(frozen=True)
class Measured:
    """Modes of a system under an algorithm.

    Attributes
    ----------
    algorithm, step : how it was stepped [s]
    modes : what was seen
    reason : why nothing is known; empty if it is
    """

    algorithm: str
    step: float
    modes: FreeModes = field(default_factory=lambda: FreeModes(np.zeros(0, dtype=complex)))
    reason: str = ""


class _Rows:
    """Keeps the rows of a short run."""

    path = Path()

    def __init__(self) -> None:
        self.parts: list[Real] = []
        self.rows = 0

    def append(self, time: Real, rows: Real) -> None:
        """Keep rows; they are evenly spaced in `time`."""
        del time
        self.parts.append(rows.copy())
        self.rows += len(rows)

    def sync(self) -> None:
        """Do nothing."""


def measured_growth(
    assembly: Assembly, step: float, report: Callable[[int, int], None] = lambda _done, _all: None
) -> tuple[Measured, tuple[Measured, ...]]:
    """Return the modes of a reference with finer steps, and those of every algorithm at a step [s].

    Parameters
    ----------
    report : called with the number of measurements that are made and of all

    Raises
    ------
    InputError
        If nothing can be known of the system under any algorithm; the sentence says why.
    """
    _check_kinds(assembly)
    found = []
    for k, name in enumerate(ALGORITHMS):
        report(k, len(ALGORITHMS) + 1)
        found.append(_measured(assembly, name, step, 1))
    known = {m.algorithm for m in found if not m.reason}
    if not known:
        raise InputError("; ".join(dict.fromkeys(m.reason for m in found)))
    report(len(ALGORITHMS), len(ALGORITHMS) + 1)
    best = next(name for name in REFERENCES if name in known)
    return _measured(assembly, best, step, FINER), tuple(found)


def _check_kinds(assembly: Assembly) -> None:
    """Raise InputError if there is nothing to disturb, or values that no small disturbance can have."""
    if not assembly.links:
        raise InputError("the system has no connections, so no algorithm changes it")
    for link in assembly.links:
        kind = assembly.fmus[link.wire.end_element].variables[link.wire.end_connector].type
        if kind != "Real":
            raise InputError(f"connection {link.wire} carries {kind} values, so the system is not linear")


def _measured(assembly: Assembly, algorithm: str, step: float, finer: int) -> Measured:
    """Return the modes under an algorithm, sampled once per `step`, or why they are not known."""
    every = finer * lcm(*assembly.periods(step).values())
    settings = Settings(step / finer, SAMPLES * every * step / finer, algorithm, record_every=every, record=())
    try:
        decays = _free_decays(assembly, settings)
        modes = realise(decays, step * every / finer)
    except (InputError, SimulationError) as error:
        return Measured(algorithm, settings.step, reason=str(error))
    return Measured(algorithm, settings.step, modes)


def _free_decays(assembly: Assembly, settings: Settings) -> Real:
    """Return the answers of all outputs to a disturbance of each connection, (k, outputs, connections)."""
    plain, inputs = _run(assembly, settings, None, 0.0)
    answers = []
    for place, name, scale in inputs[:MOST_CONNECTIONS]:
        size = DISTURBANCE * scale
        one, _ = _run(assembly, settings, place, size)
        other, _ = _run(assembly, settings, place, -2.0 * size)
        n = min(len(plain), len(one), len(other))
        answer, twice = (one[:n] - plain[:n]) / size, (other[:n] - plain[:n]) / (-2.0 * size)
        n = _until_grown(answer)
        largest = np.abs(answer[:n]).max(initial=0.0)
        rounding = 1e-13 * np.abs(plain[:n]).max(initial=0.0) / size
        if np.abs(answer[:n] - twice[:n]).max(initial=0.0) > NONLINEAR * largest + rounding:
            raise InputError(
                f"an opposite disturbance of {name}, twice as large, has not the opposite answer, twice as large: the "
                "system is not linear there, or does not repeat itself"
            )
        answers.append(answer[:n])
    shortest = min(len(a) for a in answers)
    return np.stack([a[:shortest] for a in answers], axis=2)


def _until_grown(answer: Real) -> int:
    """Return the number of samples before an answer has grown out of sight of its beginning."""
    size = np.abs(answer).max(axis=1, initial=0.0)
    first = np.flatnonzero(size > 0)
    if not first.size:
        return len(answer)
    begin = size[first[0] : first[0] + 4].max()
    large = np.flatnonzero(~(size <= GROWN * begin))
    return int(large[0]) if large.size else len(answer)


def _run(
    assembly: Assembly, settings: Settings, place: int | None, size: float
) -> tuple[Real, list[tuple[int, str, float]]]:
    """Return the outputs after each sample, and the inputs that are fed: place, name and largest value.

    Parameters
    ----------
    place : of the input that is disturbed by `size` over the first sample, None: none
    """
    rows = _Rows()
    with Master(assembly, settings) as master:
        if place is not None:
            master.plan.offset[place] += size
        master.run(rows, steps=settings.record_every)
        if place is not None:
            master.plan.offset[place] -= size
        try:
            master.run(rows)
        except SimulationError:  # what was computed until then will do, if it is enough
            if rows.rows < SAMPLES // 40:
                raise
        table: Real = np.vstack(rows.parts)[:, : len(master.outputs)]
        inputs = []
        for k, each in enumerate(master.wiring.inputs):
            if each.source is None:
                continue
            seen = each.gain * table[:EARLY, master.outputs.index(each.source)] + each.offset
            inputs.append((k, ".".join(each.key), float(np.abs(seen).max()) or float(master.plan.u_scale[k, 0]) or 1.0))
        real = [
            k
            for k, (e, v) in enumerate(master.outputs)
            if assembly.fmus[e].variables[v].fmi_type in {"Real", "Float64"}
        ]
    return table[:, real], inputs


def matched(reference: FreeModes, modes: FreeModes) -> tuple[list[complex | None], list[complex]]:
    """Return the mode that stands for each one of the reference, None if none does, and those that are left.

    The nearest pair first; a pair is one if it is nearer than half the size of its reference.
    """
    left = list(modes.s)
    result: list[complex | None] = [None] * len(reference.s)
    pairs = [(abs(s - r) / abs(r), i, s) for i, r in enumerate(reference.s) for s in left if abs(r) > 0]
    for distance, i, s in sorted(pairs, key=lambda pair: pair[:2]):
        if distance < 0.5 and result[i] is None and s in left:
            result[i] = s
            left.remove(s)
    return result, left


def as_json(reference: Measured, found: Sequence[Measured]) -> dict[str, Any]:
    """Return reference and algorithms as data."""
    algorithms = {}
    for each in found:
        pairs, left = matched(reference.modes, each.modes)
        rows = [
            {"frequency_hz": _hertz(s), "growth_rate": s.real, "reference": r.real}
            for s, r in zip(pairs, reference.modes.s.tolist(), strict=True)
            if s is not None
        ]
        rows += [{"frequency_hz": _hertz(s), "growth_rate": s.real, "reference": None} for s in left]
        errors = [abs(row["growth_rate"] - row["reference"]) for row in rows if row["reference"] is not None]
        algorithms[each.algorithm] = {
            "not_known": each.reason or None,
            "fastest_growth_rate": max((row["growth_rate"] for row in rows), default=None),
            "max_growth_rate_error": max(errors, default=None),
            "modes": rows,
        }
    modes = [{"frequency_hz": _hertz(s), "growth_rate": s.real} for s in reference.modes.s.tolist()]
    told = {"algorithm": reference.algorithm, "step_s": reference.step, "not_known": reference.reason or None}
    return {"reference": {**told, "modes": modes}, "algorithms": algorithms}


def _hertz(s: complex) -> float:
    return abs(s.imag) / (2 * pi)
