"""The command `stability`: a case or system in, tables, JSON and pictures out."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ...runs.changes import Changes
from ...stability.analysis import REPORTED_BELOW_HZ, Stability
from ...stability.cases import Changed, find_stability
from ..options import System, changes_system
from ..tools import Json, screen

RailOption = Annotated[
    str | None,
    typer.Option(
        help="analytic (default for a case), modal, a track such as soft-pads or its file, or an FMU; a rigid rail "
        "stays rigid."
    ),
]


@partial(changes_system, rail=RailOption)
def stability(
    case: System,
    *,
    changes: Changes,
    json: Json = False,
    out: Annotated[Path | None, typer.Option(help="Picture to write: Nyquist and Bode diagram of the loop.")] = None,
) -> None:
    """Find the unstable frequencies of a case of the paper or of a system of FMUs.

    Eigenloci of the self-excited vibration loop: crossings beyond +1 with loop gain and the wheel modes involved;
    poles of the closed loop where wheel and rail are modal.
    """
    result = stability_of(case, changes)
    if out is not None:
        from ...figures.stability import draw_stability  # noqa: PLC0415 - pictures are not always wanted

        out.parent.mkdir(parents=True, exist_ok=True)
        draw_stability(result, case).savefig(out, dpi=200)
    if json:
        screen.print_json(data=as_json(result))
        return
    table = Table(
        title=f"{case}, below {REPORTED_BELOW_HZ:g} Hz ({result.unstable_pairs} encirclements at all frequencies)",
        title_justify="left",
    )
    for heading in ("unstable frequency [Hz]", "loop gain", "wheel modes"):
        table.add_column(heading, justify="left" if heading == "wheel modes" else "right")
    for i in result.instabilities:
        table.add_row(f"{i.crossing.frequency_hz:.1f}", f"{i.crossing.gain:.3f}", " ".join(i.modes) or "-")
    screen.print(table)


def stability_of(case: str, changes: Changes) -> Stability:
    """Return the stability of a changed case or system; structures by name while no value of theirs changes."""
    if not (changes.values or changes.sources or changes.damp):
        return find_stability(case, changes.rail, changes.wheel)
    if changes.only_contact:
        return find_stability(case, changes.rail, changes.wheel, Changed.of(case, changes.values, changes.sources))
    return find_stability(case, None, None, Changed.of(case, *changes.resolved(case)))


def as_json(result: Stability) -> dict[str, Any]:
    """Return what `stability --json` prints; poles of the closed loop up to the same frequency as crossings."""
    poles = None if result.poles is None else result.poles.below(REPORTED_BELOW_HZ)
    return {
        "unstable": [
            {"frequency_hz": i.crossing.frequency_hz, "loop_gain": i.crossing.gain, "modes": list(i.modes)}
            for i in result.instabilities
        ],
        "closed_loop": []
        if poles is None
        else [
            {"frequency_hz": float(f), "growth_rate": float(g)}
            for f, g in zip(poles.frequency_hz, poles.growth_rate, strict=True)
        ],
        "unstable_pairs": result.unstable_pairs,
    }
