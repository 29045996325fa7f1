"""The command `coupling`: what the master algorithms make of the growth rates of a case or system."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.table import Table

from ...errors import InputError
from ...runs.changes import Changes
from ..options import System, changes_system
from ..tools import Json, messages, screen

ADDED = 6
"""Modes that are shown of those that an algorithm has beside the reference's."""


@changes_system
def coupling(
    system: System,
    step: Annotated[float | None, typer.Option(help="Communication step [s]; default as the system: 5e-6.")] = None,
    *,
    changes: Changes,
    json: Json = False,
) -> None:
    """Show what each master algorithm does to the growth rates, mode by mode, and the largest safe step.

    Wheel, rail and contact: eigenvalues of the linearised step map against those of the coupled system, modes below
    5 kHz; a step is safe while it makes no stable mode unstable and weakly damped modes are right to 0.5 1/s. Any other
    system: modes of its free decay under each algorithm, against steps of an eighth.
    """
    from ...stability.linear_model import model_of_assembly  # noqa: PLC0415
    from ...stability.scheme import TOLERATED, as_json  # noqa: PLC0415 - keeps the start of the other commands short
    from ...stability.step_map import BELOW_HZ, WEAK  # noqa: PLC0415

    assembly, settings = changes.scenario(system, step=step).prepare()
    try:
        data = as_json(model_of_assembly(assembly, settings.step), settings.step)
    except InputError as reason:
        _measured(system, assembly, settings.step, str(reason), json)
        return
    if json:
        screen.print_json(data=data)
        return
    screen.print(_modes(data, f"{Path(system).name}: growth rates [1/s] below {BELOW_HZ:g} Hz at {settings.step:g} s"))
    screen.print(_summary(data))
    screen.print(
        f"safe: no stable mode unstable, error at most {TOLERATED:g} 1/s where the exact rate is above {WEAK:g} 1/s",
        highlight=False,
    )


def _measured(system: str, assembly: Any, step: float, reason: str, json: bool) -> None:
    """Show what free decays of a system tell, that is not a wheel on a rail for `reason`."""
    from ...stability.measured_growth import as_json, measured_growth  # noqa: PLC0415

    try:
        with messages.status("disturbing the connections") if messages.is_terminal else nullcontext():
            data = as_json(*measured_growth(assembly, step))
    except InputError as why:
        raise InputError(f"{system}: no growth rates can be given: {reason}; and by its response: {why}") from None
    if json:
        screen.print_json(data=data)
        return
    told = data["reference"]
    fine = f"{told['algorithm']}, {told['step_s']:g} s"
    screen.print(_seen(data, f"{Path(system).name}: growth rates [1/s] at {step:g} s, from free decays", fine))
    for name, each in data["algorithms"].items():
        if each["not_known"]:
            screen.print(f"{name}: not known: {each['not_known']}", highlight=False)
    if told["not_known"]:
        screen.print(f"reference ({fine}): not known: {told['not_known']}", highlight=False)


def _seen(data: dict[str, Any], title: str, fine: str) -> Table:
    """Return the table of modes that were seen, and of those that an algorithm adds."""
    known = {name: each for name, each in data["algorithms"].items() if not each["not_known"]}
    table = Table(title=title, title_justify="left")
    for heading in ("frequency [Hz]", f"reference ({fine})", *known):
        table.add_column(heading, justify="right")
    for mode in data["reference"]["modes"]:
        cells = [
            next((f"{row['growth_rate']:.4g}" for row in each["modes"] if row["reference"] == mode["growth_rate"]), "-")
            for each in known.values()
        ]
        table.add_row(f"{mode['frequency_hz']:.4g}", f"{mode['growth_rate']:.4g}", *cells)
    for name, each in known.items():
        for row in [row for row in each["modes"] if row["reference"] is None][:ADDED]:
            cells = [f"{row['growth_rate']:.4g}" if other == name else "-" for other in known]
            table.add_row(f"{row['frequency_hz']:.4g}", "-", *cells)
    fastest = (each["fastest_growth_rate"] for each in known.values())
    largest = (each["max_growth_rate_error"] for each in known.values())
    table.add_section()
    table.add_row("fastest", "", *("-" if x is None else f"{x:.4g}" for x in fastest))
    table.add_row("largest error", "", *("-" if x is None else f"{x:.3g}" for x in largest))
    return table


def _modes(data: dict[str, Any], title: str) -> Table:
    """Return the table of modes: one row each, one column per algorithm."""
    table = Table(title=title, title_justify="left")
    for heading in ("frequency [Hz]", "exact", *data):
        table.add_column(heading, justify="right")
    for rows in zip(*(data[algorithm]["modes"] for algorithm in data), strict=True):
        cells = (_marked(row) for row in rows)
        table.add_row(f"{rows[0]['frequency_hz']:.1f}", f"{rows[0]['exact']:.3f}", *cells)
    return table


def _marked(row: dict[str, float]) -> str:
    """Return a discrete growth rate, with a mark if the scheme made a stable mode unstable."""
    return f"{row['discrete']:.3f}{' !' if row['exact'] <= 0 < row['discrete'] else ''}"


def _summary(data: dict[str, Any]) -> Table:
    """Return the table of algorithms."""
    table = Table(
        "algorithm", title="algorithms (!: a stable mode that the scheme makes unstable)", title_justify="left"
    )
    for heading in ("largest error [1/s]", "weakly damped [1/s]", "made unstable", "largest safe step [s]"):
        table.add_column(heading, justify="right")
    for name, d in data.items():
        safe = d["largest_safe_step_s"]
        table.add_row(
            name,
            f"{d['max_growth_rate_error']:.3g}",
            f"{d['max_growth_rate_error_weakly_damped']:.3g}",
            str(d["stable_modes_made_unstable"]),
            "none" if safe is None else f"{safe:.2g}",
        )
    return table
