"""The commands `stability` and `table4`: what the user asks for in, tables, JSON and pictures out."""

from __future__ import annotations

import json as json_format
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from fmus.packaging.system_structure import read_cases

from .command_tools import Json
from .errors import InputError
from .stability_case import REPORTED_BELOW_HZ, Stability, analyse
from .stability_inputs import CLASS158, RIGID_RAIL, case_inputs, find_case, find_rail, find_wheel, system_inputs
from .table4 import Cell, Table4, compare

screen = Console()

RailOption = Annotated[
    str | None, typer.Option(help="analytic (default for a case), modal, or an .fmu file; a rigid rail stays rigid.")
]
WheelOption = Annotated[
    str | None, typer.Option(help="class158 (default for a case), generic840, straight840, a .toml or an .fmu file.")
]


def stability(
    case: Annotated[str, typer.Argument(metavar="CASE|FILE", help="case1 to case4, an .ssp or an .ssd file.")],
    rail: RailOption = None,
    wheel: WheelOption = None,
    json: Json = False,
    out: Annotated[Path | None, typer.Option(help="Picture to write: Nyquist and Bode diagram of the loop.")] = None,
) -> None:
    """Find the unstable frequencies of a case of the paper or of a system of FMUs.

    Eigenloci of the self-excited vibration loop: crossings beyond +1 with loop gain and the wheel modes involved;
    poles of the closed loop where wheel and rail are modal.
    """
    result = find_stability(case, rail, wheel)
    if out is not None:
        from .report_stability import draw_stability  # noqa: PLC0415 - pictures are not always wanted

        out.parent.mkdir(parents=True, exist_ok=True)
        draw_stability(result, case).savefig(out, dpi=200)
    if json:
        typer.echo(json_format.dumps(as_json(result), indent=2))
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


def table4(json: Json = False, rail: RailOption = None, wheel: WheelOption = None) -> None:
    """Print Table 4 of the paper next to ours: frequency and loop gain, cell by cell."""
    result = find_table4(rail, wheel)
    if json:
        typer.echo(json_format.dumps(result.as_json(), indent=2))
        return
    table = Table(
        title=f"Table 4: {result.right} of {len(result.cells)} cells right, rms ln(gain) error {result.log_error:.3f}",
        title_justify="left",
    )
    for heading in ("case", "mode", "paper [Hz]", "ours [Hz]", "paper gain", "our gain", ""):
        table.add_column(heading, justify="right")
    for cell in result.cells:
        table.add_row(*_row(cell))
    screen.print(table)
    for case, crossing in result.extra:
        screen.print(f"case {case}: further crossing at {crossing.frequency_hz:.1f} Hz with gain {crossing.gain:.3f}")


def find_stability(case: str, rail: str | None = None, wheel: str | None = None) -> Stability:
    """Return the stability of a case or a system file.

    Raises
    ------
    InputError
        For names and files that mean nothing, or a rail FMU for a case whose rail is rigid.
    """
    known = find_case(case)
    if known is None:
        return analyse(*system_inputs(case, wheel, rail))
    if known.rail == RIGID_RAIL and rail not in {None, "analytic", "modal"}:
        raise InputError(f"--rail {rail}: {case} has a rigid rail; take case1 or case3")
    return analyse(*case_inputs(known, find_wheel(wheel or CLASS158), find_rail(rail or "analytic")))


def find_table4(rail: str | None = None, wheel: str | None = None) -> Table4:
    """Return Table 4 for a wheel and a rail; Cases 2 and 4 have a rigid rail always."""
    the_wheel, the_rail = find_wheel(wheel or CLASS158), find_rail(rail or "analytic")
    cases = sorted(read_cases(), key=lambda case: case.name)
    return compare({n: analyse(*case_inputs(case, the_wheel, the_rail)) for n, case in enumerate(cases, start=1)})


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


def _row(cell: Cell) -> tuple[str, ...]:
    """Return a cell as a row of text."""
    numbers = (
        ("-" if value is None else f"{value:.{digits}f}")
        for value, digits in (
            (cell.paper_frequency_hz, 1), (cell.frequency_hz, 1), (cell.paper_gain, 3), (cell.gain, 3),
        )
    )  # fmt: skip
    return (str(cell.case), cell.mode, *numbers, "" if cell.agrees else "!")
