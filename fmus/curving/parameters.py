"""The parameters of the vehicle, declared once, in the order in which the kernels find them.

Start values are those of the reference vehicle, `data/vehicles/reference.toml`, on the cone-and-arc wheel.
"""

from __future__ import annotations

import math

from ..compile import positions
from ..component import Variable

MAX_GRID = 100


def _real(name: str, unit: str, start: float, low: float, high: float, description: str) -> Variable:
    """Declare a fixed real parameter."""
    nominal = abs(start) or 1.0
    return Variable(name, "parameter", unit, description, start=start, minimum=low, maximum=high, nominal=nominal)


def _switch(name: str, description: str) -> Variable:
    """Declare a switch that is off."""
    return Variable(name, "parameter", "1", description, kind="Boolean", start=0, minimum=0, maximum=1)


def _cells(name: str, description: str) -> Variable:
    """Declare a number of grid elements."""
    return Variable(
        name, "parameter", "1", description, kind="Integer", start=30, minimum=1, maximum=MAX_GRID, nominal=10
    )


VEHICLE = (
    _real("wheel_radius", "m", 0.42, 0.05, 2.0, "rolling radius r0 on the tape circle"),
    _real("half_tape_distance", "m", 0.75, 0.1, 2.0, "lever l0: half the distance of the tape circles"),
    _real("half_wheelbase", "m", 1.3, 0.1, 20.0, "half the wheelbase of the bogie, a"),
    _real("axle_load", "N", 120e3, 1e3, 1e6, "load on each axle"),
    _real("primary_yaw_stiffness", "N.m/rad", 10e6, 0.0, 1e12, "yaw stiffness between wheelset and frame, k_psi"),
    _real("primary_lateral_stiffness", "N/m", 8e6, 1.0, 1e12, "lateral stiffness between wheelset and frame, k_y"),
    _real("secondary_yaw_stiffness", "N.m/rad", 0.2e6, 0.0, 1e12, "yaw stiffness between frame and body, k_sec"),
    _real("secondary_friction_moment", "N.m", 0.0, 0.0, 1e6, "friction moment between frame and body"),
    _real("half_bogie_spacing", "m", 8.0, 0.0, 20.0, "half the distance of the vehicle's two bogies, c"),
    _real("load_height", "m", 1.5, 0.0, 5.0, "height at which lateral acceleration acts, h"),
)
"""Numbers of a vehicle, as in its file."""

PARAMETERS = (
    *VEHICLE,
    _switch("trailing_bogie", "false: the leading bogie of a vehicle; true: the trailing one"),
    _real("shear_modulus", "Pa", 210e9 / 2.6, 1e6, 1e12, "shear modulus of wheel and rail"),
    _real("poisson_ratio", "1", 0.3, 0.0, 0.5, "Poisson's ratio of wheel and rail"),
    _real("falling_ratio", "1", 0.0, 0.0, 1.0, "falling ratio lambda of the friction law; 0: constant friction"),
    _real("saturation_coefficient", "1", 0.005, 1e-9, 10.0, "saturation coefficient kappa of the friction law"),
    _switch("use_fastsim", "creep law: false, the closed form of Shen, Hedrick and Elkins; true, FASTSIM"),
    _cells("grid_cells", "FASTSIM grid: cells along the rolling direction"),
    _cells("grid_strips", "FASTSIM grid: strips across"),
    # cone and arc
    _real("conicity", "1", 0.05, 0.0, 0.5, "slope of the tread"),
    _real("flange_clearance", "m", 5e-3, 0.0, 0.02, "shift towards the flange at which the tread ends"),
    _real("flange_arc_radius", "m", 5e-3, 1e-4, 0.1, "radius of the arc from tread to flange"),
    _real("flange_angle", "rad", math.radians(70.0), 0.1, 1.5, "steepest angle of the flange"),
    _real("patch_load", "N", 60e3, 1.0, 1e7, "normal force that semi-axes and stiffness are given for"),
    _real("semi_axis_lon", "m", 5.777675428510385e-3, 1e-5, 0.1, "semi-axis a of the patch at patch_load"),
    _real("semi_axis_lat", "m", 4.61727000598374e-3, 1e-5, 0.1, "semi-axis b of the patch at patch_load"),
    _real("hertz_stiffness", "N/m", 1195665454.8300748, 1.0, 1e12, "stiffness of the contact spring at patch_load"),
    _real("c11", "1", 4.538597, 1e-3, 100.0, "Kalker's coefficient C11 of the patch"),
    _real("c22", "1", 4.066682, 1e-3, 100.0, "Kalker's coefficient C22 of the patch"),
    _real("c23", "1", 1.788108, 1e-3, 100.0, "Kalker's coefficient C23 of the patch"),
    # a table of contact geometry takes the place of cone and arc, where there is one
    _real("table_start", "m", 0.0, -0.1, 0.1, "first shift towards the flange in the table of contact geometry"),
    _real("table_spacing", "m", 1e-4, 1e-6, 0.1, "spacing of the table of contact geometry"),
)  # fmt: skip

P = positions("P", (p.name for p in PARAMETERS))
"""Position of each parameter in the parameter array; the table's blocks follow."""

N_FIXED = len(PARAMETERS)

TABLE = (
    ("radius_change", "m", "change of the rolling radius", -0.1, 0.1),
    ("contact_angle", "rad", "contact angle with the wheelset's roll", -1.55, 1.55),
    ("wheel_position", "m", "contact on the wheel from the tape circle, to the field side", -0.1, 0.1),
    ("rail_position", "m", "contact on the rail from its crown, to the field side", -0.1, 0.1),
    ("semi_axis_lon", "m", "semi-axis a at patch_load", 1e-5, 0.1),
    ("semi_axis_lat", "m", "semi-axis b at patch_load", 1e-5, 0.1),
    ("hertz_stiffness", "N/m", "stiffness of the contact spring at patch_load", 1.0, 1e12),
)
"""Columns of the table of contact geometry: name, unit, description, range."""
