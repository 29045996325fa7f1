"""The command `wheel treat`: a wheel with more damping, or with tuned absorbers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...errors import InputError
from ..tools import Force, Json, require_free, require_suffix, screen, user_mistakes
from .wheel_files import read_wheel, write_wheel


def treat(  # noqa: PLR0913, PLR0917 - one argument per option
    wheel: Annotated[str, typer.Argument(metavar="WHEEL", help="class158, or modal data: CSV or TOML.")],
    absorber: Annotated[str | None, typer.Option(help="Label of the mode that absorbers are tuned to: (3,0).")] = None,
    mass: Annotated[float | None, typer.Option(help="Mass of the absorbers on one wheel [kg].")] = None,
    loss: Annotated[float, typer.Option(help="Loss factor of their springs.")] = 0.1,
    tuned: Annotated[float | None, typer.Option(help="Their own frequency [Hz]; default Den Hartog's.")] = None,
    position: Annotated[float, typer.Option(help="Axial motion where they sit over that at the tread.")] = 1.0,
    damp: Annotated[
        list[str] | None, typer.Option(help="Damping by label: '(3,0)=1e-3', '(*,0)=+1e-4', 'wheel=x2'. Repeatable.")
    ] = None,
    out: Annotated[Path, typer.Option(help="FMU (.fmu) or modal data (.toml) to write.")] = Path("wheel-treated.fmu"),
    force: Force = False,
    json: Json = False,
) -> None:
    """Write a wheel with tuned absorbers, or with rings and layers as damping of a family of modes.

    Absorbers are alike, evenly around each wheel, and move along the axle; damping comes first.
    """
    from fmus.wheel.treatment import Absorber, damped, read_rule, with_absorber  # noqa: PLC0415

    require_suffix(out, (".fmu", ".toml"))
    require_free(out, force)
    if (absorber is None) != (mass is None):
        raise InputError("--absorber and --mass go together: a label such as (3,0), and kilograms")
    data: dict[str, object] = {"file": str(out)}
    with user_mistakes():
        read = read_wheel(wheel)
        modes, areas = damped(read.modes, [read_rule(text) for text in damp or []]), read.areas
        if absorber is not None and mass is not None:
            treated = with_absorber(modes, Absorber(absorber, mass, loss, tuned, position))
            modes, areas = treated.modes, None  # of other modes than before
            split = sorted({round(f, 2) for f in treated.split_hz})
            data |= {
                "absorber_hz": treated.frequency_hz, "mass_ratio": treated.mass_ratio, "split_hz": split,
                "error_db": treated.error_db,
            }  # fmt: skip
        words = [f"{absorber} absorbers of {mass:g} kg" if absorber is not None else "", *(damp or [])]
        title = f"{Path(wheel).stem} with {', '.join(word for word in words if word) or 'nothing added'}"
        write_wheel(modes, out, title, f"{wheel}, treated (fmus.wheel.treatment)", areas)
    if json:
        screen.print_json(data={**data, "modes": len(modes)})
        return
    if absorber is not None:
        screen.print(
            f"absorbers at {data['absorber_hz']:.1f} Hz, mass ratio {data['mass_ratio']:.4f}: {absorber} becomes "
            f"{' and '.join(f'{f:g}' for f in split)} Hz; highest receptance {data['error_db']:+.1f} dB from that "
            "with the springs as they are",
            highlight=False,
        )
    screen.print(f"{out}  ({len(modes)} modes)", highlight=False)
