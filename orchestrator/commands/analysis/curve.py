"""The command `curve`: a bogie in a curve in, its four contacts and what sings out."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Annotated, Any

import typer
from rich.table import Table

from fmus.curving.bogie import Curve

from ...curves.inputs import find_contact, find_tread_wheel, find_vehicle, make_bogie, make_curve
from ...curves.squeal import SingingWheel, Tone, find_rail, sing, solve
from ..tools import Json, messages, screen

RADIUS = "Radius of the curve [m]; negative in a right curve."
CANT = "Height of the outer rail above the inner one [m]; default: as much as the speed needs."
PROFILE = "Wheel profile: s1002 or a table (CSV); default: the reference vehicle's cone-and-arc wheel."
RAIL = "Rail profile with inclination, 60e1-1:40 (default with --profile), 60e1-1:20, FILE.csv-1:30."
FALLING = "Falling ratio of the contact's friction law; the vehicle's own friction is constant."


def curve(  # noqa: PLR0913, PLR0917 - one argument per option
    radius: Annotated[float, typer.Option(help=RADIUS)],
    speed: Annotated[float, typer.Option(help="Speed [m/s].")] = 10.0,
    cant: Annotated[float | None, typer.Option(help=CANT)] = None,
    mu: Annotated[float, typer.Option(help="Coulomb friction coefficient.")] = 0.3,
    vehicle: Annotated[str, typer.Option(help="reference, rigid-truck or a file (TOML).")] = "reference",
    trailing: Annotated[bool, typer.Option("--trailing", help="The trailing bogie, not the leading one.")] = False,
    wheel: Annotated[str, typer.Option(help="generic840, straight840 or a wheelset file (TOML).")] = "generic840",
    profile: Annotated[str | None, typer.Option(help=PROFILE)] = None,
    rail: Annotated[str | None, typer.Option(help=RAIL)] = None,
    track: Annotated[str, typer.Option(help="Track under the rail: analytic, modal or rigid.")] = "analytic",
    falling_ratio: Annotated[float, typer.Option(help=FALLING)] = 0.1,
    json: Json = False,
) -> None:
    """Find how a bogie runs through a curve, and which of its wheels squeals.

    Steady-state curving gives the operating point of each of the four contacts; the stability of each wheel on its rail
    there says which tones grow.
    """
    the_vehicle = find_vehicle(vehicle)
    the_wheel, the_rail = find_tread_wheel(wheel), find_rail(track)
    the_curve = make_curve(radius, speed, cant, mu, the_vehicle)
    with messages.status("contact geometry") as status:
        bogie = make_bogie(the_vehicle, find_contact(profile, rail, the_vehicle), trailing)
        state = solve(bogie, the_curve)
        wheels = sing(
            bogie, the_curve, the_wheel, the_rail, {"falling_ratio": falling_ratio},
            lambda place: status.update(f"stability of the {place.replace('_', ' ')} wheel"),
        )  # fmt: skip
    if json:
        yaw, shift = list(state.yaw), list(state.shift)
        screen.print_json(data={**as_json(the_curve, wheels), "yaw_rad": yaw, "shift_m": shift})
        return
    screen.print(_table(the_curve, wheels))
    screen.print(in_words(wheels), soft_wrap=True, highlight=False)


def as_json(curve: Curve, wheels: dict[str, SingingWheel]) -> dict[str, Any]:
    """Return what `curve --json` prints of the wheels."""
    loudest = singing(wheels)
    return {
        "curve": {"curvature": curve.curvature, "speed": curve.speed, "cant": curve.cant, "mu": curve.friction},
        "wheels": {
            place: {
                **asdict(w.state),
                "unstable": [asdict(tone) for tone in w.tones],
                "squeal": None if w.squeal is None else asdict(w.squeal),
                "velocity_guess": w.velocity_guess,
                "on_tread": w.on_tread,
            }
            for place, w in wheels.items()
        },
        "sings": loudest,
        "in_words": in_words(wheels),
    }


def singing(wheels: dict[str, SingingWheel]) -> str | None:
    """Return the wheel whose squeal grows fastest; None: no wheel squeals."""
    rates = {place: w.squeal.growth_rate for place, w in wheels.items() if w.squeal is not None}
    return max(rates, key=lambda place: rates[place], default=None)


def in_words(wheels: dict[str, SingingWheel]) -> str:
    """Return which wheel sings, in a sentence."""
    place = singing(wheels)
    tone = wheels[place].squeal if place else None
    if place is None or tone is None:
        return "No wheel squeals: nothing at or above 150 Hz grows."
    others = [p.replace("_", " ") for p, w in wheels.items() if p != place and w.squeal is not None]
    also = f"; so does the {' and the '.join(others)} wheel, more slowly" if others else ""
    return (
        f"The {place.replace('_', ' ')} wheel squeals: its mode {tone.mode} grows fastest, at "
        f"{tone.frequency_hz:.0f} Hz and {tone.growth_rate:.2g} 1/s{also}."
    )


def _table(curve: Curve, wheels: dict[str, SingingWheel]) -> Table:
    """Return the table of the wheels."""
    side = "left" if curve.curvature > 0 else "right"
    table = Table(
        title=f"{side} curve of {1 / abs(curve.curvature):g} m radius, {curve.speed:g} m/s, cant "
        f"{1e3 * curve.cant:.0f} mm, mu {curve.friction:g}",
        title_justify="left",
    )
    table.add_column("wheel")
    for place in wheels:
        table.add_column(place.replace("_", " "), justify="right")
    for heading, cell in ROWS.items():
        table.add_row(heading, *(cell(w) for w in wheels.values()))
    table.add_row("unstable", *("\n".join(_tone(t) for t in w.tones) or "-" for w in wheels.values()))
    table.caption = (
        "positions to the field side, * beyond the tread: the wheel's modes are extrapolated; unstable: frequency in "
        "Hz, mode, loop gain, growth rate in 1/s"
    )
    table.caption_justify = "left"
    return table


ROWS: dict[str, Callable[[SingingWheel], str]] = {
    "gamma1 [1e-3]": lambda w: f"{1e3 * w.state.steady_creepage_lon:.2f}",
    "gamma2 [1e-3]": lambda w: f"{1e3 * w.state.steady_creepage_lat:.2f}",
    "gamma6 [1/m]": lambda w: f"{w.state.steady_creepage_spin:.3f}",
    "load [kN]": lambda w: f"{w.state.normal_load / 1e3:.1f}",
    "angle [deg]": lambda w: f"{math.degrees(w.state.contact_angle):.1f}",
    "on wheel [mm]": lambda w: f"{1e3 * w.state.wheel_position:.1f}{'' if w.on_tread else '*'}",
    "on rail [mm]": lambda w: f"{1e3 * w.state.rail_position:.1f}",
    "semi-axes [mm]": lambda w: f"{1e3 * w.state.semi_axis_lon:.1f}, {1e3 * w.state.semi_axis_lat:.1f}",
    "stiffness [N/m]": lambda w: f"{w.state.hertz_stiffness:.3g}",
    "friction used": lambda w: f"{w.state.friction_utilisation:.2f}",
}
"""What the table says of each wheel."""


def _tone(tone: Tone) -> str:
    """Return an unstable tone in a line or two of a cell."""
    return f"{tone.frequency_hz:.0f} {tone.mode}\n{tone.loop_gain:.2f}, {tone.growth_rate:.2g}"
