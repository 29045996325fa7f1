"""What section 5.2 of the paper says beyond its Table 4, claim by claim, as an item of the page."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fmus.modal.modes import Modes
from fmus.wheel.class158 import identified_stiffness
from fmus.wheel.wheelset import DATA, read_wheelset

from ..errors import InputError
from ..published.table4 import CELL_MODES, read_paper_table
from ..stability.analysis import REPORTED_BELOW_HZ, Stability, without_normal_motion
from ..stability.cases import find_rail, find_wheel
from ..stability.loop import linear_contact
from ..stability.poles import exact_poles
from .page import Item, Row
from .table4 import Table4

SINGLE = ("(1,0)", "(0,0)", "(2,0)", "(3,0)", "(4,0)")
"""Modes that the paper finds alone behind an instability of Case 3."""

_NEAR = 0.02
"""Relative distance from the natural frequency within which a pole is that of the mode."""


def claims(results: Mapping[int, Stability], table: Table4) -> Item:
    """Return the item.

    Parameters
    ----------
    results, table : stability of the four cases, and Table 4 made of it
    """
    modes = {(cell.case, cell.mode): cell.modes for cell in table.cells}
    paper = read_paper_table()
    rows: list[Row] = []
    for mode in SINGLE:
        f = paper.frequency_hz[2, CELL_MODES.index(mode)]
        eliminated = "eliminated" if stable_without_normal_motion(mode) else "remains"
        rows.append((f"Case 3, {f:g} Hz without the normal displacement of {mode}", "-", "eliminated", eliminated, ""))
    for case, column in [*((3, mode) for mode in (*SINGLE, "(6,0)")), (4, "(0,0)"), (4, "(4,0)")]:
        f = paper.frequency_hz[case - 1, CELL_MODES.index(column)]
        named, ours = " ".join(paper.modes[case, column]), " ".join(modes[case, column])
        same = "same" if named == ours else "different"
        rows.append((f"wheel modes behind {f:g} Hz of Case {case}", "-", named, ours, same))
    counts = [float(len(results[case].instabilities)) for case in (3, 4)]
    rows.append(("unstable frequencies, constant friction, with rail", "-", 6.0, counts[0], f"{counts[0] - 6:+.0f}"))
    rows.append(("unstable frequencies, constant friction, without rail", "-", 2.0, counts[1], f"{counts[1] - 2:+.0f}"))
    for stiffness in sorted({1.2e9, identified_stiffness()}):
        found = float(straight_web_instabilities(0.0, stiffness))
        rows.append((f"straight web, 0 degrees, K_H {stiffness:.3g} N/m: unstable modes", "-", 0.0, found, ""))
    for degrees in (1.0, 2.0, 3.0):
        found = float(straight_web_instabilities(degrees, 1.2e9))
        rows.append((f"straight web, {degrees:g} degrees, K_H 1.2e+09 N/m: unstable modes", "-", None, found, None))
    return Item(
        "Section 5.2", "further claims", tuple(rows),
        "Modes behind an instability are the fewest with which alone it remains. At 263.1 Hz of Case 4 the paper names "
        "three modes; fewer can do here, because the check asks for the smallest group.",
    )  # fmt: skip


def stable_without_normal_motion(mode: str) -> bool:
    """Return whether a mode of `class158` is stable in Case 3 when its normal displacement is set to zero."""
    wheel, rail = find_wheel("class158"), find_rail("modal")
    law = linear_contact({"falling_ratio": 0.0, **wheel.contact})
    changed = without_normal_motion(_known(wheel.modes), mode, law)
    poles = exact_poles(changed, _known(rail.modes), law).unstable()
    natural = read_paper_table().natural_frequency_hz[CELL_MODES.index(mode)]
    return not (np.abs(poles.frequency_hz / natural - 1) < _NEAR).any()


def straight_web_instabilities(contact_angle_deg: float, hertz_stiffness: float) -> int:
    """Return the number of growing modes of the straight-webbed wheel under Case 3's conditions below 4.5 kHz."""
    wheel, rail = read_wheelset(DATA / "straight840.toml").modes, find_rail("modal")
    law = linear_contact({
        "falling_ratio": 0.0, "contact_angle": float(np.radians(contact_angle_deg)), "hertz_stiffness": hertz_stiffness,
    })  # fmt: skip
    poles = exact_poles(wheel, _known(rail.modes), law).unstable().below(REPORTED_BELOW_HZ)
    return int(poles.frequency_hz.size)


def _known(modes: Modes | None) -> Modes:
    if modes is None:
        raise InputError("the modes of a structure are not known")
    return modes
