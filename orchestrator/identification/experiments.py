"""What else Table 4 can be asked: the misfit over the slope, cases held out, the printed friction coefficient.

Tables for `inferred-identification.toml` go out, whatever they say.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..published.table4 import CASES
from .fit import FREE_MODES
from .misfit import Misfit
from .search import CELL_WEIGHTS, Found, Search, best, quality, starts

Real = NDArray[np.float64]
Report = Callable[[str], None]

SLOPES = (0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.75, 1.0)
"""Slope factors whose misfit is shown."""

HELD_OUT = ((1, 2), (1, 2, 3), (2, 3, 4), (1, 3))
"""Cases that are fitted; the others are predicted."""

_SEEDS = tuple(range(3))


def experiments(misfit: Misfit, first: Found, report: Report = lambda _: None) -> str:
    """Return the tables of all experiments.

    Parameters
    ----------
    misfit : as the identification has it
    first : the best end of the identification
    """
    return "\n".join([
        "",
        "# The fit to the table alone with the slope factor held, everything else free.",
        *profile(misfit, first.vector, report),
        "# Some cases fitted with the slope free and with the printed one; the others predicted. Gains of pairs that",
        "# are unstable in both; cells of the cases that were held out.",
        *hold_outs(misfit, report),
        "# The whole fit with the friction coefficient of Table 1 held.",
        *printed_friction(misfit, report),
    ]).rstrip("\n") + "\n"  # fmt: skip


def profile(misfit: Misfit, vector: Real, report: Report) -> list[str]:
    """Return lines: how near the table is at each slope, from the neighbour's outcome and from seeded starts."""
    place = misfit.prior.place("slope_factor")
    at = float(np.exp(vector[place] * misfit.prior.width[place]))
    outcome: dict[float, Found] = {}
    for side in (sorted(s for s in SLOPES if s >= at), sorted((s for s in SLOPES if s < at), reverse=True)):
        here = vector
        for slope in side:
            outcome[slope] = _at_slope(misfit, slope, here)
            here = outcome[slope].vector
            report(f"s {slope:g}: cost {outcome[slope].cost:.1f}")
    lines = []
    for slope in SLOPES:
        free = misfit.prior.wheel(outcome[slope].vector)
        q = quality(misfit, free)
        lines += [
            "[[profile]]", f"slope_factor = {slope!r}", f"cost = {outcome[slope].cost:.2f}",
            f"rms_ln_gain = {q.rms():.4f}", f"worst_gain = {q.worst:.3f}", f"cells_right = {int(q.right.sum())}",
            f"friction = {free.friction:.3f}", f"mass_factor = {free.mass_factor:.3f}", "",
        ]  # fmt: skip
    return lines


def _at_slope(misfit: Misfit, slope: float, near: Real) -> Found:
    """Return the best of a descent from a neighbouring slope and of seeded starts."""
    search = Search(misfit, {"slope_factor": slope}, with_aims=False)
    vector, cost = search.held_in(near), np.inf
    for weight in CELL_WEIGHTS[1:]:
        vector, cost = search.descend(replace(misfit, cells=weight), vector)
    return best([Found(-1, vector, cost, True), *starts(search, _SEEDS)])


def hold_outs(misfit: Misfit, report: Report) -> list[str]:
    """Return lines: what cases that were not fitted come out as."""
    lines = []
    for fitted in HELD_OUT:
        held_out = [case for case in CASES if case not in fitted]
        for held in ({}, {"slope_factor": 1.0}):
            search = Search(replace(misfit, cases=fitted), held, with_aims=False)
            end = best(list(starts(search, _SEEDS)))
            free = misfit.prior.wheel(end.vector)
            q = quality(misfit, free)
            right = q.right[[case - 1 for case in held_out]]
            line = (
                f"fitted {fitted}, s {'held' if held else 'free'}: {free.slope_factor:.3f}, rms {q.rms(fitted):.3f}; "
                f"held out: rms {q.rms(held_out):.3f}, {int(right.sum())} of {right.size} cells"
            )
            report(line)
            lines += [
                "[[hold_out]]", f"fitted = {list(fitted)}", f"slope_held = {str(bool(held)).lower()}",
                f"slope_factor = {free.slope_factor:.3f}", f"cost = {end.cost:.1f}",
                f"rms_ln_gain_fitted = {q.rms(fitted):.4f}", f"rms_ln_gain_held_out = {q.rms(held_out):.4f}",
                f"cells_right_held_out = {int(right.sum())}", f"cells_held_out = {right.size}", "",
            ]  # fmt: skip
    return lines


def printed_friction(misfit: Misfit, report: Report) -> list[str]:
    """Return lines: what the printed friction coefficient needs of the wheel."""
    printed = misfit.prior.middle.friction
    search = Search(misfit, {"friction": printed})
    end = best(list(starts(search, _SEEDS)))
    free = misfit.prior.wheel(end.vector)
    q = quality(misfit, free)
    ratio = free.lateral / misfit.prior.middle.lateral
    report(f"mu0 {printed:g}: cost {end.cost:.2f}, rms {q.rms():.4f}, s {free.slope_factor:.3f}")
    return [
        "[printed_friction]", f"friction = {printed!r}", f"cost = {end.cost:.2f}", f"rms_ln_gain = {q.rms():.4f}",
        f"worst_gain = {q.worst:.3f}", f"cells_right = {int(q.right.sum())}",
        f"slope_factor = {free.slope_factor:.4f}", f"mass_factor = {free.mass_factor:.3f}",
        f"modes = {_names(FREE_MODES)}", f"lateral_re_finite_elements = [{', '.join(f'{r:.2f}' for r in ratio)}]",
    ]  # fmt: skip


def _names(names: Sequence[str]) -> str:
    return "[" + ", ".join(f'"{name}"' for name in names) + "]"
