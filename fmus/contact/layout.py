"""Where the contact's kernels find what: names of the positions in their arrays."""

from ..compile import positions
from ..creep.strips import SCRATCH_SIZE
from ..interface import contact_inputs, contact_outputs, operating_point_inputs
from .friction_parameters import TABLE_POINTS
from .parameters import MEMORY_ROOM

IN = positions("IN", (port.name for port in (*contact_inputs(), *operating_point_inputs())))
OUT = positions("OUT", (port.name for port in contact_outputs()))
"""Layout of inputs and outputs."""

S = positions(
    "S",
    (
        *("energy_added_lon", "energy_added_lat", "energy_added_spin", "energy_added_normal"),  # local variables
        *("f_lon", "f_lat", "f_spin", "f_normal"),  # forces that are held now: fluctuations, contact axes
        *("d_lon", "d_lat", "d_spin", "d_normal"),  # how much they changed the last time
        *("v_lon", "v_lat", "v_spin", "v_normal"),  # relative velocities that came in before
        *("w_lon", "w_lat", "w_spin"),  # relative velocities that the law was solved at
        *("was_lon", "was_lat", "was_spin"),  # those of the forces before
        *("place", "way_integrated", "v_integrated"),  # normal displacement, its integrated part and that's velocity
        *("held_lon", "held_lat", "held_spin", "held_normal"),  # Y F of the held forces; this and what follows: delay
        *("known_lon", "known_lat", "known_spin", "known_normal"),  # change of the velocities by known forces
        *("rest_lon", "rest_lat", "rest_spin", "rest_normal"),  # the rest of their last change
        *("older_rest_lon", "older_rest_lat", "older_rest_spin", "older_rest_normal"),  # of the change before
        *("steps", "part", "part_normal"),  # steps made, part of the parabola in the extrapolation
        *("elapsed", "deflection", "newton"),  # time, integrated deflection, Newton matrix (3 x 3)
        *(f"newton_{i}" for i in range(1, 9)),
        *("step", "t_lon", "t_lat", "t_lon_before", "t_lat_before"),  # with memory: last step, total tangential forces
        "tractions",  # of the particles, one step before those of these forces
    ),
)
"""Layout of the state."""

D = positions(
    "D",
    (
        *("f_lon", "f_lat", "f_spin"),  # steady creep forces
        *("steady_lon", "steady_lat", "steady_spin", "load", "mu0"),  # the steady state that they belong to
        *("velocity", "falling_ratio", "saturation"),  # and the other parameters that may change during the run
        *("approach", "stiffness", "cos", "sin", "spin_arm"),  # steady approach and its stiffness, geometry
        *("L1", "L2", "L3", "L4", "volume", "elliptic_volume", "parabolic_volume"),  # of the creep law
        *("series_lon", "series_lat"),  # compliances that all strips share, with memory
        "mobility",  # contact axes (4 x 4)
    ),
)
"""Layout of the derived quantities."""

STATE_SIZE = S.tractions + 2 * MEMORY_ROOM
SCRATCH = D.mobility + 16
"""Position of the scratch space of FASTSIM in the derived quantities."""

FRICTION = SCRATCH + SCRATCH_SIZE
FRICTION_SLOPES = FRICTION + 1
FRICTION_WORK = FRICTION_SLOPES + TABLE_POINTS
"""Of a friction table: friction without sliding, the slopes at its points, and space to solve for them."""

DERIVED_SIZE = FRICTION_WORK + TABLE_POINTS
