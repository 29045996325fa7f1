"""What Table 4 says of the paper's friction data and track, as items of the page: they exclude each other."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np

from fmus.wheel.inferred import IDENTIFICATION

from ..published.table4 import read_paper_table
from ..stability.cases import find_rail
from ..stability.loop import linear_contact
from .consistency import consistency
from .figures import RAIL_HZ, draw_consistency, draw_slope
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

And since q (1 - q) <= 1/4, whatever the falling coefficient and the gain of Case 1,

    r <= m0^2 L2 / (4 g L3^2).

Every part of D is passive and |D| >= Re D, so r >= Re Y33 of the rail, whatever wheel and spring. Where the table's r
is smaller, the printed gains of Cases 1 to 3, the friction law of Tables 1 and 3 and a track with the peaks of Fig. 3
cannot all be met."""


SLOPE_FIGURE = "slope.png"


def slope(figures: Path) -> Item:
    """Return the item of the falling slope that Table 4 tells, writing its picture into `figures`."""
    identification = tomllib.loads(IDENTIFICATION.read_text(encoding="utf-8"))
    profile, free = identification["profile"], identification["free"]["slope_factor"]
    path = figures / SLOPE_FIGURE
    draw_slope(profile, free["value"], free["deviation"]).savefig(
        path, dpi=90, metadata={"Software": None}, pil_kwargs={"optimize": True}
    )
    rows: list[Row] = [
        (f"rms of ln(gain/paper gain) of the best fit at s = {p['slope_factor']:g}", "-", None, p["rms_ln_gain"], None)
        for p in profile
    ]
    rows.append(("s, everything free", "-", None, free["value"], f"+- {100 * free['deviation']:.0f} %"))
    return Item(
        "Consistency", "the falling slope that the printed gains say", tuple(rows),
        "s is g/m0^2 over what eq. (11) and Table 1 give; amplitudes, damping, friction coefficient and mass are free "
        "at each s. No slope is printed as a number, and the sign in eq. (11) is a misprint, so its reading is an "
        "interpretation (docs/stability.md).",
        (path,),
    )  # fmt: skip


def _verdict(excluded: bool) -> str:
    return "excluded" if excluded else "possible"


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
    for mode, r, y, most in zip(result.modes, result.r, result.rail, result.largest_r, strict=True):
        rows.append((f"{mode}: r of Table 4; Re Y33 of the track", "m/s/N", float(r), float(y), _verdict(r < y)))
        bound = f"{mode}: largest r, whatever the falling coefficient; Re Y33 of the track"
        rows.append((bound, "m/s/N", float(most), float(y), _verdict(most < y)))
    slope, largest = float(falling.H1[1, 1]), float(result.largest_slope.min())
    rows.append(("falling slope: largest that Table 4 allows; of Tables 1 and 3", "N s/m", largest, slope, None))
    excluded = [mode for mode, r, y in zip(result.modes, result.r, result.rail, strict=True) if r < y]
    return Item(
        "Consistency", "what the printed gains say about the rail", tuple(rows),
        f"{_PROOF} It fails at {' and '.join(excluded)}, there even for the largest r. With this "
        "track the table would allow a slope of at most "
        f"{largest:.0f} N s/m, where the friction law has {slope:.0f}. (0,0) is coupled to the axle modes, so it is a "
        "hint only; (3,0) is on its own.",
        (path,),
    )  # fmt: skip
