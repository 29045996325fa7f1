"""THE CONTRACT between wheel, rail and contact: names, units, causality, axes, signs and connections.

Nothing else repeats it: model descriptions, the system structure, tables and tests are generated from here.

Axes
----
All ports speak *track axes*, SI units: `lon` along the track in the rolling direction, `lat` to the gauge side (so that
the paper's steady lateral creepage is positive), `ver` upwards, `spin` about the vertical axis. The contact alone knows
the contact angle and rotates. Forces are fluctuations about the steady state; each acts *on* the structure it is
connected to, so `rail_f = -wheel_f`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

DIRECTIONS = ("lon", "lat", "ver", "spin")
"""The paper's directions 1, 2, 3, 6, in the order of every vector and matrix of this project."""

CONTACT_DIRECTIONS = ("lon", "lat", "normal", "spin")
"""The same in contact axes, which are the track's turned about the longitudinal axis by the contact angle."""

STRUCTURES = ("wheel", "rail")
"""The two places that a modal structure can take; the contact's ports carry these names as prefixes."""

DEFAULT_STEP = 5e-6
"""Communication step that the published interface mobilities are given for by default [s]."""

DISPLACEMENT_DIRECTIONS = ("lat", "ver")
"""Displacements that the contact takes: they make the deflection along the contact normal."""

STEP_SIZE = "step_size"
"""Parameter of a structure: the communication step that its interface mobilities are given for."""

INITIAL_VELOCITY = "initial_velocity"
"""Parameters of a structure that begin with this are initial modal velocities."""

INITIAL_DISPLACEMENT = "initial_displacement"
"""Parameters of a structure that begin with this are initial modal displacements."""

MODAL_VELOCITY = "modal_velocity"
"""Local variables of a structure that begin with this are its modal velocities: what a radiation model needs."""

ENERGY_ADDED = "energy_added"
"""Local variables of the contact that begin with this: the energy that holding its forces has added so far."""

PULSE_FORCE = "pulse_force"
"""Parameter of the contact: amplitude of the lateral force pulse that starts the vibration."""

CHANGE = "_change"
"""Inputs that end with this are added to the parameter of the name before it; 0 leaves the parameter as it is."""

PAIRS = tuple(combinations_with_replacement(DIRECTIONS, 2))
"""The upper triangle of a symmetric 4 x 4 matrix, row by row, as pairs of directions."""

FORCE_UNIT = {"lon": "N", "lat": "N", "ver": "N", "spin": "N.m"}
VELOCITY_UNIT = {"lon": "m/s", "lat": "m/s", "ver": "m/s", "spin": "rad/s"}
DISPLACEMENT_UNIT = {"lon": "m", "lat": "m", "ver": "m", "spin": "rad"}
SHAPE_UNIT = {"lon": "kg^(-1/2)", "lat": "kg^(-1/2)", "ver": "kg^(-1/2)", "spin": "kg^(-1/2)/m"}
MODAL_VELOCITY_UNIT = "kg^(1/2).m/s"
MODAL_DISPLACEMENT_UNIT = "kg^(1/2).m"

UNITS: dict[str, dict[str, int] | None] = {
    "1": {},
    "s": {"s": 1},
    "Hz": {"s": -1},
    "m": {"m": 1},
    "rad": {"rad": 1},
    "m/s": {"m": 1, "s": -1},
    "s/m": {"m": -1, "s": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/m": {"rad": 1, "m": -1},
    "1/m": {"m": -1},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m/rad": {"kg": 1, "m": 2, "s": -2, "rad": -1},
    "N/m": {"kg": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "J": {"kg": 1, "m": 2, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3},
    "m/(N.s)": {"kg": -1, "s": 1},
    "rad/(N.s)": {"rad": 1, "kg": -1, "m": -1, "s": 1},
    "rad/(N.m.s)": {"rad": 1, "kg": -1, "m": -2, "s": 1},
    "kg^(-1/2)": None,
    "kg^(-1/2)/m": None,
    "kg^(1/2).m/s": None,
    "kg^(1/2).m": None,
}
"""Every unit in use, as exponents of SI base units; None where FMI's whole exponents cannot express it."""

_FORCE_NOMINAL = {"lon": 1e3, "lat": 1e3, "ver": 1e3, "spin": 1.0}
_VELOCITY_NOMINAL = {"lon": 1e-2, "lat": 1e-2, "ver": 1e-2, "spin": 1e-1}
_DISPLACEMENT_NOMINAL = {"lon": 1e-6, "lat": 1e-6, "ver": 1e-6, "spin": 1e-5}
_WORD = {"lon": "longitudinal", "lat": "lateral", "ver": "vertical", "spin": "spin"}


@dataclass(frozen=True)
class Port:
    """A variable of the contract: what it is called, what it means and in which unit it is given."""

    name: str
    unit: str
    description: str
    nominal: float


def mobility_unit(row: str, column: str) -> str:
    """Return the unit of velocity in direction `row` per force in direction `column`."""
    rotations = (row, column).count("spin")
    return ("m/(N.s)", "rad/(N.s)", "rad/(N.m.s)")[rotations]


def structure_inputs() -> tuple[Port, ...]:
    """Return the force inputs of a wheel or a rail: force on the structure at the contact point."""
    return tuple(
        Port(f"f_{d}", FORCE_UNIT[d], f"{_WORD[d]} force on the structure", _FORCE_NOMINAL[d]) for d in DIRECTIONS
    )


def structure_outputs() -> tuple[Port, ...]:
    """Return the outputs of a wheel or a rail: velocities, then displacements, of the contact point."""
    velocities = tuple(
        Port(f"v_{d}", VELOCITY_UNIT[d], f"{_WORD[d]} velocity of the contact point", _VELOCITY_NOMINAL[d])
        for d in DIRECTIONS
    )
    displacements = tuple(
        Port(
            f"u_{d}",
            DISPLACEMENT_UNIT[d],
            f"{_WORD[d]} displacement of the contact point",
            _DISPLACEMENT_NOMINAL[d],
        )
        for d in DIRECTIONS
    )
    return velocities + displacements


def mobility_ports(prefix: str) -> tuple[Port, ...]:
    """Return the ten entries of an interface mobility: `y` of a structure, `mobility` of the contact.

    Entry (row, column) is the velocity at the end of a communication step per force held over that step, from rest.
    """
    return tuple(
        Port(
            f"{prefix}_{row}_{column}",
            mobility_unit(row, column),
            f"interface mobility: {_WORD[row]} velocity at the end of a step per {_WORD[column]} force held over it",
            1e-6,
        )
        for row, column in PAIRS
    )


def contact_inputs() -> tuple[Port, ...]:
    """Return the contact's inputs: velocities of both structures, then the displacements it takes of both."""
    velocities = tuple(
        Port(
            f"{s}_v_{d}",
            VELOCITY_UNIT[d],
            f"{_WORD[d]} velocity of the {s} at the contact point",
            _VELOCITY_NOMINAL[d],
        )
        for s in STRUCTURES
        for d in DIRECTIONS
    )
    displacements = tuple(
        Port(
            f"{s}_u_{d}",
            DISPLACEMENT_UNIT[d],
            f"{_WORD[d]} displacement of the {s} at the contact point",
            _DISPLACEMENT_NOMINAL[d],
        )
        for s in STRUCTURES
        for d in DISPLACEMENT_DIRECTIONS
    )
    return velocities + displacements


OPERATING_POINT = (
    Port("steady_creepage_lon", "1", "steady longitudinal creepage gamma1", 1e-2),
    Port("steady_creepage_lat", "1", "steady lateral creepage gamma2", 1e-2),
    Port("steady_creepage_spin", "rad/m", "steady spin creepage gamma6", 1e-1),
    Port("normal_load", "N", "steady normal force", 6e4),
    Port("mu0", "1", "friction coefficient without sliding", 0.3),
)
"""The steady state of the contact: parameters that inputs add to."""


def operating_point_inputs() -> tuple[Port, ...]:
    """Return the inputs that move the contact's steady state: of the contact, and of the system as one FMU."""
    return tuple(
        Port(p.name + CHANGE, p.unit, f"{p.description}: change over time, added to the parameter", p.nominal)
        for p in OPERATING_POINT
    )


def contact_outputs() -> tuple[Port, ...]:
    """Return the contact's force outputs (fluctuations, track axes) and its monitors."""
    forces = tuple(
        Port(f"{s}_f_{d}", FORCE_UNIT[d], f"{_WORD[d]} force on the {s}: fluctuation", _FORCE_NOMINAL[d])
        for s in STRUCTURES
        for d in DIRECTIONS
    )
    return forces + CONTACT_MONITORS


CONTACT_MONITORS = (
    Port("normal_force", "N", "total normal force, contact axes; 0 when contact is lost", 6e4),
    Port("tangential_force_lon", "N", "total longitudinal creep force on the wheel, contact axes", 1e4),
    Port("tangential_force_lat", "N", "total lateral creep force on the wheel, contact axes", 1e4),
    Port("spin_moment", "N.m", "total spin moment on the wheel, contact axes", 1.0),
    Port("creepage_lon", "1", "total longitudinal creepage", 1e-2),
    Port("creepage_lat", "1", "total lateral creepage", 1e-2),
    Port("creepage_spin", "rad/m", "total spin creepage", 1e-1),
    Port("friction_coefficient", "1", "friction coefficient at this creepage", 0.3),
    Port("deflection", "m", "fluctuation of the compression of the contact spring", 1e-5),
    Port("power_dissipated", "W", "power that the creep forces dissipate", 1e3),
    Port("force_evaluations", "1", "creep-force evaluations that the last step took", 1.0),
)
"""What the contact tells besides the forces."""


@dataclass(frozen=True)
class Connection:
    """A wire of the system: an output of one component to an input of another."""

    start_element: str
    start_connector: str
    end_element: str
    end_connector: str


def connections() -> tuple[Connection, ...]:
    """Return every connection of the wheel/rail system."""
    wires = [Connection(s, f"v_{d}", "contact", f"{s}_v_{d}") for s in STRUCTURES for d in DIRECTIONS]
    wires += [Connection(s, f"u_{d}", "contact", f"{s}_u_{d}") for s in STRUCTURES for d in DISPLACEMENT_DIRECTIONS]
    wires += [Connection("contact", f"{s}_f_{d}", s, f"f_{d}") for s in STRUCTURES for d in DIRECTIONS]
    return tuple(wires)
