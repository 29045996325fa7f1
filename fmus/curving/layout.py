"""Where the kernels of the vehicle find what: names of the positions in their arrays."""

from ..compile import positions
from ..creep.strips import SCRATCH_SIZE
from .parameters import TABLE

WHEELS = ("leading_left", "leading_right", "trailing_left", "trailing_right")

X = positions("X", ("y", "yaw", "omega", "load_left", "load_right"))
"""Unknowns of an axle: shift, yaw, relative change of the rolling speed, normal forces; twice, then the frame's."""

PER_AXLE = 5
FRAME_Y = 10
FRAME_YAW = 11
N = 12
"""Unknowns and equations."""

G = positions("G", (*(name for name, *_ in TABLE), "c11", "c22", "c23"))
"""Contact geometry at a shift: the columns of the table and Kalker's coefficients."""

N_COLUMNS = 7
N_GEOMETRY = 10

W = positions(
    "W",
    (
        *("steady_creepage_lon", "steady_creepage_lat", "steady_creepage_spin"),
        *("normal_load", "contact_angle", "wheel_position", "rail_position"),
        *("semi_axis_lon", "semi_axis_lat", "hertz_stiffness"),
        *("creep_force_lon", "creep_force_lat", "friction_utilisation", "lateral_force", "vertical_force"),
        *("radius", "lead", "arm"),  # rolling radius; xi and x of the equations
    ),
)
"""What is known of a wheel, contact axes as the contact component has them."""

N_WHEEL = len(W)

C = positions("C", ("curvature", "velocity", "cant", "mu0"))
"""The curve: the inputs in their order."""

_FIELDS = (*("geometry", "wheels", "residual", "trial", "kept", "residual_trial", "jacobian", "scratch", "table"),)

_BLOCKS = (4 * N_GEOMETRY, 4 * N_WHEEL, N, N, N, N, N * (N + 1), SCRATCH_SIZE)

D = positions("D", _FIELDS)._make(sum(_BLOCKS[:i]) for i in range(len(_BLOCKS) + 1))
"""Position of each block in the derived quantities; the table is last and as long as it needs."""


def derived_size(nodes: int) -> int:
    """Return the length of the derived quantities for a table of so many nodes."""
    return int(D.table) + 2 * N_GEOMETRY * nodes


S = positions(
    "S",
    (
        *("failed", "reached"),  # why no solution was found, and the radius that was reached
        *("curvature", "load", "mu0"),  # of the last solution
        *("velocity", "cant"),  # of the last inputs
        "unknowns",
    ),
)
"""Layout of the state; the first two are local variables."""

STATE_SIZE = S.unknowns + N

WHEEL_OUTPUTS = W.lateral_force + 1
"""How many of a wheel's values are outputs: the first ones; four wheels, then shifts, yaws, iterations, residual."""
