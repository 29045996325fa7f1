"""What the commands of curving are given, in words, and the vehicles, profiles and wheels that it means."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fmus.curving.bogie import Bogie, Curve
from fmus.curving.contact_table import ContactTable
from fmus.curving.profiles import Profile, rail_60e1, read_profile, s1002
from fmus.curving.rail_contact import Track, contact_table
from fmus.curving.vehicles import VEHICLES, Vehicle, read_vehicle, vehicle_names
from fmus.errors import DataError
from fmus.modal.modes import Modes
from fmus.wheel.wheelset import DATA, Wheelset, read_wheelset

from ..errors import InputError
from ..stability.cases import find_wheel

GRAVITY = 9.80665
LARGEST_CANT = 0.3
"""That the vehicle component takes [m]."""

DEFAULT_RAIL = "60e1-1:40"


@dataclass(frozen=True)
class TreadWheel:
    """A wheel that can be read at places of its tread.

    Attributes
    ----------
    name : as the user gave it
    modes : at the nominal contact point
    wheelset : with the change along the tread; None: the wheel is known at the nominal point only
    contact : parameters of the contact that go with the wheel
    """

    name: str
    modes: Modes
    wheelset: Wheelset | None
    contact: Mapping[str, float] = field(default_factory=dict)

    def at(self, position: float) -> Modes:
        """Return the modes at a distance from the tape circle to the field side [m]."""
        if self.wheelset is None:
            raise InputError(
                f"wheel {self.name}: its modes are known at the nominal contact point only, and the contact is "
                f"{1e3 * position:.1f} mm from it; a wheelset file with columns du_r_ds and so on, such as generic840, "
                "is needed"
            )
        try:
            return self.wheelset.at(position)
        except DataError as error:
            raise InputError(f"wheel {self.name}: {error}") from None


def find_vehicle(text: str) -> Vehicle:
    """Return the vehicle of a name or a file."""
    path = VEHICLES / f"{text}.toml" if text in vehicle_names() else Path(text)
    if not path.is_file():
        raise InputError(f"vehicle {text}: neither {', '.join(vehicle_names())} nor a file")
    try:
        return read_vehicle(path)
    except DataError as error:
        raise InputError(f"vehicle {error}") from None


def find_profile(text: str, option: str, named: Mapping[str, Profile]) -> Profile:
    """Return the profile of a name or a file."""
    if text.lower() in named:
        return named[text.lower()]
    if not Path(text).is_file():
        raise InputError(f"{option} {text}: neither {', '.join(named)} nor a file of lateral_mm,height_mm")
    try:
        return read_profile(Path(text))
    except DataError as error:
        raise InputError(f"{option} {error}") from None


def find_contact(profile: str | None, rail: str | None, vehicle: Vehicle) -> ContactTable | None:
    """Return the contact geometry of a wheel profile on a rail such as 60e1-1:40; None: cone and arc."""
    if profile is None:
        if rail is not None:
            raise InputError(f"rail {rail}: a rail's profile needs a wheel's, such as s1002")
        return None
    text = rail or DEFAULT_RAIL
    match = re.fullmatch(r"(.+)-1:(\d+)", text)
    if match is None:
        raise InputError(f"rail {text}: must be a profile and its inclination, such as 60e1-1:40")
    inclination = int(match[2])
    if inclination < 10:
        raise InputError(f"rail {text}: the inclination must be 1:10 or less")
    track = Track(
        1 / inclination, tape_distance=2e3 * vehicle.parameters["half_tape_distance"],
        wheel_radius=1e3 * vehicle.parameters["wheel_radius"],
    )  # fmt: skip
    wheel = find_profile(profile, "wheel profile", {"s1002": s1002()})
    head = find_profile(match[1], "rail profile", {"60e1": rail_60e1()})
    try:
        return contact_table(wheel, head, track)
    except DataError as error:
        raise InputError(f"profile {profile} on rail {text}: {error}") from None


def find_tread_wheel(text: str) -> TreadWheel:
    """Return the wheel of a name, a wheelset file or a modal data file."""
    path = DATA / f"{text}.toml" if (DATA / f"{text}.toml").is_file() else Path(text)
    if text != "class158" and path.is_file() and path.suffix == ".toml":
        try:
            if "modes" in tomllib.loads(path.read_text(encoding="utf-8")):
                wheelset = read_wheelset(path)
                return TreadWheel(text, wheelset.modes, wheelset)
        except (DataError, KeyError, OSError, tomllib.TOMLDecodeError) as error:
            raise InputError(f"wheel {text}: {error}") from None
    found = find_wheel(text)
    if found.modes is None:
        raise InputError(f"wheel {text}: an FMU is known at its contact point only; modes are needed")
    return TreadWheel(text, found.modes, None, found.contact)


def make_bogie(vehicle: Vehicle, table: ContactTable | None, trailing: bool = False) -> Bogie:
    """Return the bogie of a vehicle on its contact geometry."""
    return Bogie({**vehicle.parameters, "trailing_bogie": float(trailing)}, table)


def make_curve(radius: float, speed: float, cant: float | None, friction: float, vehicle: Vehicle) -> Curve:
    """Return the curve of a radius, positive to the left; without cant the one that leaves no lateral acceleration."""
    if radius == 0:
        raise InputError("radius 0: must be a radius in metres, negative in a right curve")
    if cant is None:
        cant = 2 * vehicle.parameters["half_tape_distance"] * speed**2 / (GRAVITY * abs(radius))
        if cant > LARGEST_CANT:
            raise InputError(
                f"cant must be given: {speed:g} m/s in a curve of {abs(radius):g} m radius would need {cant:.2f} m"
            )
    try:
        return Curve(1 / radius, speed, cant, friction)
    except DataError as error:
        raise InputError(f"curve: {error}") from None
