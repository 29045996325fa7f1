"""Where the contact's kernels find what: names of the positions in their arrays."""

from ..compile import positions
from ..interface import contact_inputs, contact_outputs

IN = positions("IN", (port.name for port in contact_inputs()))
OUT = positions("OUT", (port.name for port in contact_outputs()))
"""Layout of inputs and outputs."""

S = positions(
    "S",
    (
        *("f_lon", "f_lat", "f_spin", "f_normal"),  # forces that are held now: fluctuations, contact axes
        *("d_lon", "d_lat", "d_spin", "d_normal"),  # how much they changed the last time
        *("v_lon", "v_lat", "v_spin"),  # relative velocities at the end of the step before
        *("w_lon", "w_lat", "w_spin"),  # relative velocities that the law was solved at
        *("elapsed", "deflection", "newton"),  # time, integrated deflection, Newton matrix (3 x 3)
    ),
)
"""Layout of the state."""

D = positions(
    "D", ("f_lon", "f_lat", "f_spin", "approach", "cos", "sin", "L1", "L2", "L3", "spin_arm", "volume", "mobility")
)
"""Layout of the derived quantities: steady creep forces, steady approach, geometry, contact-axes mobility (3 x 4)."""

STATE_SIZE = S.newton + 9
DERIVED_SIZE = D.mobility + 12
