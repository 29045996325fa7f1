"""The proof that Table 4, the friction data and the track of the paper exclude each other, as an item of the page."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..published.table4 import read_paper_table
from ..stability.cases import find_rail
from ..stability.loop import linear_contact
from .consistency import consistency
from .figures import RAIL_HZ, draw_consistency
from .page import Item, Row

_PROOF = """\
For one wheel mode on its own, D the mobility of everything else in the normal direction (other modes, rail, contact
spring), g the falling slope, m1 and m0 the falling and the constant friction coefficient, the loop gains at the
crossings are

    L2 = g psi2^2 / (2 zeta w0)                       Case 2, no rail
    L3 = m0 psi2 psi3 / (psi3^2 + 2 zeta w0 r)        Case 3, constant friction
    L1 = (m1/m0) L3 + L2 q                            Case 1

with r = |D|^2 / Re D and q = 2 zeta w0 r / (psi3^2 + 2 zeta w0 r). Amplitudes and damping drop out:

    q = (L1 - (m1/m0) L3) / L2,    r = q (1 - q) m0^2 L2 / (g L3^2).

Every part of D is passive and |D| >= Re D, so r >= Re Y33 of the rail, whatever wheel and spring. Where the table's r
is smaller, the printed gains of Cases 1 to 3, the friction law of Tables 1 and 3 and a track with the peaks of Fig. 3
cannot all be met."""


def proof(figures: Path) -> Item:
    """Return the item, writing its picture into `figures`."""
    rail = find_rail("analytic").mobility
    falling, constant = linear_contact(), linear_contact({"falling_ratio": 0.0})
    result = consistency(read_paper_table(), rail, falling, constant)
    Y = falling.turn @ rail(2 * np.pi * RAIL_HZ) @ falling.turn.T
    path = figures / "consistency.png"
    draw_consistency(result, RAIL_HZ, Y[:, 2, 2].real).savefig(
        path, dpi=90, metadata={"Software": None}, pil_kwargs={"optimize": True}
    )
    rows: list[Row] = []
    for mode, r, y in zip(result.modes, result.r, result.rail, strict=True):
        verdict = "excluded" if r < y else "possible"
        rows.append((f"{mode}: r of Table 4; Re Y33 of the track", "m/s/N", float(r), float(y), verdict))
    slope, largest = float(falling.H1[1, 1]), float(result.largest_slope.min())
    rows.append(("falling slope: largest that Table 4 allows; of Tables 1 and 3", "N s/m", largest, slope, None))
    excluded = [mode for mode, r, y in zip(result.modes, result.r, result.rail, strict=True) if r < y]
    return Item(
        "Consistency", "what the printed gains say about the rail", tuple(rows),
        f"{_PROOF} It fails at {' and '.join(excluded)}. With this track the table would allow a slope of at most "
        f"{largest:.0f} N s/m, where the friction law has {slope:.0f}. (0,0) is coupled to the axle modes, so it is a "
        "hint only; (3,0) is on its own.",
        (path,),
    )  # fmt: skip
