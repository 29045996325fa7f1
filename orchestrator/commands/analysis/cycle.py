"""The command `curvesqueal cycle`: a system in, its tones with level and fate out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace as with_fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
from rich.table import Table

from ...errors import InputError
from ...runs.changes import Changes
from ..options import System, changes_system
from ..tools import Json, messages, notice, require_suffix, screen

if TYPE_CHECKING:
    from ...limit_cycles.catalogue import Catalogue, Cycle


@changes_system
def cycle(  # noqa: PLR0913 - one argument per option
    system: System,
    *,
    changes: Changes,
    tone: Annotated[float | None, typer.Option(help="Only the tone near this frequency [Hz].")] = None,
    no_stability: Annotated[bool, typer.Option("--no-stability", help="Do not ask whether the tones last.")] = False,
    torus: Annotated[
        bool, typer.Option("--torus", help="Find the two tones that one with growing sidebands breaks up into.")
    ] = False,
    down_to: Annotated[
        float, typer.Option(help="Follow stable poles, too, down to this growth rate [1/s]; all tones need -60.")
    ] = -1.0,
    against: Annotated[
        str | None,
        typer.Option(help="Follow the tones through a range, such as contact.mu0=0.01:0.6."),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Picture to write: of all tones, or of the one of --tone.")] = None,
    json: Json = False,
) -> None:
    """Find every tone that a system can squeal at, its level, and whether it lasts, without time stepping.

    Limit cycles by harmonic balance, followed from the poles; stability by the exponents of perturbations.
    """
    from ...limit_cycles.described import as_json  # noqa: PLC0415 - loads scipy
    from ...limit_cycles.search import cycles_of  # noqa: PLC0415

    if out is not None:
        require_suffix(out, (".png", ".pdf", ".svg"))
    if torus and (no_stability or against):
        other = "--no-stability" if no_stability else "--against"
        raise InputError(f"--torus asks what tones that do not last break up into; {other} does not go with it")
    assembly, settings = changes.scenario(system).prepare()
    name = Path(system).name
    try:
        with progress_bar() as report:
            found = cycles_of(
                assembly, settings.step, tone_hz=tone, with_stability=not no_stability, down_to=down_to, report=report
            )
    except InputError as reason:
        raise InputError(f"{system}: {reason}") from None
    asked = found if tone is None else with_fields(found, cycles=found.all_near(tone))
    if against is not None:
        follow_all(asked, name, against, (no_stability, json), out)
        return
    if out is not None:
        draw(found, name, tone, out)
    if json:
        tori = {"tori": tori_as_json(asked)} if torus else {}
        screen.print_json(data={**as_json(name, found), **tori})
        return
    show(found, f"{name}: tones")
    if torus:
        show_tori(asked)


def show(found: Catalogue, title: str) -> None:
    """Print the table of tones, then what becomes of each, then what could not be followed."""
    screen.print(table_of(found, title))
    for c in found.cycles:
        screen.print(f"{c.frequency_hz:8.2f} Hz  {c.fate}", highlight=False)
    for line in found.notes:
        notice(line)


def tori_as_json(found: Catalogue) -> list[dict[str, Any]]:
    """Return what each tone with growing sidebands breaks up into."""
    from ...limit_cycles.level import Radiator  # noqa: PLC0415 - loads scipy
    from ...limit_cycles.tori.described import break_up_as_json  # noqa: PLC0415
    from ...limit_cycles.tori.search import break_ups  # noqa: PLC0415

    with progress_bar() as report:
        return [break_up_as_json(b, Radiator.of(found.model.wheel)) for b in break_ups(found, report)]


def show_tori(found: Catalogue) -> None:
    """Print what each tone with growing sidebands breaks up into."""
    from ...limit_cycles.level import Radiator  # noqa: PLC0415 - loads scipy
    from ...limit_cycles.tori.described import torus_words  # noqa: PLC0415
    from ...limit_cycles.tori.search import break_ups  # noqa: PLC0415

    with progress_bar() as report:
        results = break_ups(found, report)
    if not results:
        screen.print("no tone here breaks up through sidebands", highlight=False)
    for b in results:
        screen.print(f"{b.cycle.frequency_hz:8.2f} Hz  {b.words}", highlight=False, soft_wrap=True)
        if b.torus is not None:
            words = torus_words(b.torus, Radiator.of(found.model.wheel))
            screen.print(f"             {words}", highlight=False, soft_wrap=True)


def follow_all(found: Catalogue, name: str, against: str, how: tuple[bool, bool], out: Path | None) -> None:
    """Follow all tones that were found through a range of a parameter; print, and draw if a picture is wanted."""
    from ...figures.cycles import draw_branches  # noqa: PLC0415
    from ...limit_cycles.bifurcations.diagram import branch_as_json, follow  # noqa: PLC0415
    from ...limit_cycles.bifurcations.parameter import find_parameter  # noqa: PLC0415

    parameter_name, span = parse_range(against)
    parameter = find_parameter(found.model, parameter_name)
    no_stability, json = how
    with progress_bar() as report:
        branches = [follow(c, parameter, span, not no_stability, report) for c in found.cycles]
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        draw_branches(branches, name).savefig(out, dpi=200)
    if json:
        data = {"case": name, "branches": [branch_as_json(b) for b in branches]}
        screen.print_json(data=data)
        return
    for c, branch in zip(found.cycles, branches, strict=True):
        screen.print(f"{c.frequency_hz:.2f} Hz against {parameter_name}: {branch.words}", highlight=False)
        for mark in branch.marks:
            screen.print(f"  {mark.kind:16} at {mark.value:.5g}, {mark.amplitude:.4f} m/s", highlight=False)
        for value, end in zip(branch.value[[0, -1]], branch.ends, strict=True):
            screen.print(f"  at {value:.5g} the branch {end}", highlight=False)


def parse_range(text: str) -> tuple[str, tuple[float, float]]:
    """Return parameter and range of a text such as 'contact.mu0=0.01:0.6'."""
    name, _, span = text.partition("=")
    try:
        low, high = (float(part) for part in span.split(":"))
    except ValueError:
        raise InputError(
            f"--against {text}: must be COMPONENT.PARAMETER=LOW:HIGH, such as contact.mu0=0.01:0.6"
        ) from None
    return (name if "." in name else f"contact.{name}"), (low, high)


def draw(found: Catalogue, name: str, tone: float | None, out: Path) -> None:
    """Write the picture that belongs to what was asked for."""
    from ...figures.cycles import draw_cycle, draw_cycles  # noqa: PLC0415 - pictures are not always wanted

    out.parent.mkdir(parents=True, exist_ok=True)
    figure = draw_cycles(found, name) if tone is None else draw_cycle(found.near(tone), name)
    figure.savefig(out, dpi=200)


@contextmanager
def progress_bar() -> Iterator[Callable[[str, int, int], None]]:
    """Show on the error stream what is done."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=messages, transient=True, disable=not messages.is_terminal) as bar:
        task = bar.add_task("loading", total=None)
        yield lambda what, done, total: bar.update(task, description=what, completed=done, total=total)


def table_of(found: Catalogue, title: str) -> Table:
    """Return the table of tones."""
    table = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0), pad_edge=False)
    headings = ("tone", "pole", "1/s", "wheel", "rail", "normal", "stick", "lost", "level", "exponent")
    units = ("Hz", "Hz", "", "lat m/s", "lat m/s", "kN", "%", "%", "dB(A)", "1/s @ Hz")
    for heading, unit in zip(headings, units, strict=True):
        table.add_column(f"{heading}\n{unit}", justify="right", no_wrap=True)
    for c in found.cycles:
        table.add_row(*_row(c))
    return table


def _row(c: Cycle) -> tuple[str, ...]:
    """Return a tone as a row of text."""
    low, high = c.normal_force
    exponent = "-"
    if c.stability is not None:
        largest = c.stability.largest
        exponent = f"{largest.real:+.2f}" + (f" @ {c.stability.largest_hz:.1f}" if largest.imag else "")
    return (
        f"{c.frequency_hz:.2f}",
        f"{c.pole.frequency_hz:.1f}",
        f"{c.pole.growth_rate:+.1f}",
        f"{c.wheel_velocity_rms['lat']:.4f}",
        f"{c.rail_velocity_rms['lat']:.4f}",
        f"{low / 1e3:.1f}-{high / 1e3:.1f}",
        f"{100 * c.contact.stick:.0f}",
        f"{100 * c.contact.lost:.0f}",
        "-" if c.level_dba is None else f"{c.level_dba:.1f}",
        exponent,
    )
