"""The parameters of the contact, declared once, in the order in which the kernels find them."""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..compile import positions
from ..component import Variable
from ..errors import DataError
from ..interface import CHANGE, OPERATING_POINT, mobility_ports
from .friction_parameters import FRICTION_PARAMETERS, TABLE_OF_CREEPAGE

MAX_GRID = 200

FASTSIM, BLENDED, WITH_MEMORY = 0, 1, 2
"""Values of the parameter `creep_law`."""

MEMORY_ROOM = 400
"""Most cells, along times across, of the contact with memory: its state has two tractions for each."""


def _parameter(name: str, unit: str, start: float, low: float, high: float, description: str) -> Variable:
    """Declare a fixed real parameter."""
    nominal = abs(start) or 1.0
    return Variable(name, "parameter", unit, description, start=start, minimum=low, maximum=high, nominal=nominal)


def _tunable(name: str, unit: str, start: float, low: float, high: float, description: str) -> Variable:
    """Declare a real parameter that may change during the run."""
    nominal = abs(start) or 1e-2
    return Variable(
        name, "parameter", unit, description, start=start, minimum=low, maximum=high, nominal=nominal, tunable=True
    )


def _whole(name: str, start: int, description: str) -> Variable:
    """Declare a number of grid elements."""
    return Variable(
        name, "parameter", "1", description, kind="Integer", start=start, minimum=1, maximum=MAX_GRID, nominal=10
    )


def _switch(name: str, start: bool, description: str) -> Variable:
    """Declare a switch."""
    return Variable(name, "parameter", "1", description, kind="Boolean", start=start, minimum=0, maximum=1)


PARAMETERS = (
    # Table 3 of the paper
    _parameter("normal_load", "N", 60e3, 1.0, 1e7, "steady normal force"),
    _tunable("rolling_velocity", "m/s", 10.0, 0.1, 200.0, "rolling velocity V0"),
    _tunable("steady_creepage_lon", "1", 0.0, -0.5, 0.5, "steady longitudinal creepage gamma1"),
    _tunable("steady_creepage_lat", "1", 0.02, -0.5, 0.5, "steady lateral creepage gamma2"),
    _tunable("steady_creepage_spin", "rad/m", 0.0, -50.0, 50.0, "steady spin creepage gamma6"),
    # Table 1
    _tunable("mu0", "1", 0.3, 0.0, 2.0, "Coulomb friction coefficient; a table has its own"),
    _tunable("falling_ratio", "1", 0.1, 0.0, 1.0, "falling ratio lambda of eq. (11); 0: constant friction"),
    _tunable("saturation_coefficient", "1", 0.005, 1e-9, 10.0, "saturation coefficient kappa of eq. (11)"),
    _parameter("semi_axis_lon", "m", 0.010, 1e-5, 0.1, "semi-axis a of the contact ellipse, rolling direction"),
    _parameter("semi_axis_lat", "m", 0.005, 1e-5, 0.1, "semi-axis b of the contact ellipse, lateral"),
    # section 5.1 of the paper
    _parameter("contact_angle", "rad", math.radians(2.0), -1.2, 1.2, "contact angle"),
    # not in the paper
    _parameter("hertz_stiffness", "N/m", 1.2e9, 1.0, 1e12, "stiffness of the contact spring at the steady load"),
    _switch("linear_spring", False, "contact spring: false, Hertz's law of power 3/2; true, linear"),
    _parameter("shear_modulus", "Pa", 80e9, 1e6, 1e12, "shear modulus of wheel and rail"),
    _parameter("poisson_ratio", "1", 0.3, 0.0, 0.5, "Poisson's ratio of wheel and rail"),
    _whole("grid_cells", 10, "grid of the creep law: cells along the rolling direction"),
    _whole("grid_strips", 10, "grid of the creep law: strips across"),
    Variable("creep_law", "parameter", "1",
             "creep law: 0, FASTSIM, the paper's; 1, with a blended bound, which is right with spin too; 2, FASTSIM "
             f"with memory, tractions travel with the particles, on at most {MEMORY_ROOM} cells",
             kind="Integer", start=FASTSIM, minimum=FASTSIM, maximum=WITH_MEMORY),
    _switch("use_displacements", True, "true: take displacements as inputs; false: integrate the velocities"),
    _switch("integrate_wheel", False, "true: integrate the wheel's velocities; it gives no displacements"),
    _switch("integrate_rail", False, "true: integrate the rail's velocities; it gives no displacements"),
    _parameter("pulse_force", "N", 0.0, -1e6, 1e6, "lateral half-sine force pulse at the start, on wheel and rail"),
    _parameter("pulse_duration", "s", 1e-3, 1e-6, 10.0, "duration of the force pulse"),
    *(
        Variable(p.name, "parameter", p.unit, "sum of wheel and rail: " + p.description,
                 start=0.0, minimum=-1e3, maximum=1e3, nominal=p.nominal)
        for p in mobility_ports("mobility")
    ),
    Variable("host_delay_steps", "parameter", "1",
             "steps by which the host's inputs are late: 0; 1 for a host that steps all components at once (Jacobi)",
             kind="Integer", start=0, minimum=0, maximum=1),
    *FRICTION_PARAMETERS,
)  # fmt: skip

_STEADY_STATE = tuple(next(v for v in PARAMETERS if v.name == port.name) for port in OPERATING_POINT)
LOWEST = tuple(v.minimum for v in _STEADY_STATE)
HIGHEST = tuple(v.maximum for v in _STEADY_STATE)
"""Range of each number of the steady state, parameter and input together."""

P = positions("P", (p.name for p in PARAMETERS))
"""Position of each parameter in the parameter array."""


def with_changes(values: Mapping[str, float]) -> dict[str, float]:
    """Return parameters of the contact with what inputs add to them, which stands beside them under its own names.

    Raises
    ------
    DataError
        If a friction table is moved: no parameter has the friction without sliding.
    """
    result = dict(values)
    changes = {port.name: result.pop(port.name + CHANGE, 0.0) for port in OPERATING_POINT}
    if changes["mu0"] != 0.0 and result["friction_law"] >= TABLE_OF_CREEPAGE:
        raise DataError(f"mu0{CHANGE} = {changes['mu0']:g} moves a friction table; change the table instead")
    if changes["normal_load"] != 0.0:  # the elastic constant of the Hertzian contact stays
        result["hertz_stiffness"] *= (1.0 + changes["normal_load"] / result["normal_load"]) ** (1.0 / 3.0)
    for name, change in changes.items():
        if change != 0.0:
            result[name] += change
    return result
