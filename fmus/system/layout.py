"""Where the system's kernels find what: the arrays of wheel, rail and contact inside the arrays of the system."""

from __future__ import annotations

from ..compile import positions
from ..contact.layout import DERIVED_SIZE as CONTACT_DERIVED
from ..contact.layout import IN, OUT
from ..contact.layout import STATE_SIZE as CONTACT_STATE
from ..contact.parameters import PARAMETERS as CONTACT_PARAMETERS
from ..interface import (
    connections,
    contact_inputs,
    contact_outputs,
    operating_point_inputs,
    structure_inputs,
    structure_outputs,
)

OWN = ("wheel_modes", "rail_modes", "micro_step")
"""Parameters of the system itself; the first two are sizes and fixed."""

HANDED_DOWN = tuple(p for p in CONTACT_PARAMETERS if not p.name.startswith("mobility_"))
"""Parameters of the contact that are parameters of the system; it works out the mobilities itself."""

P = positions("P", (*OWN, *(p.name for p in HANDED_DOWN)))
"""Layout of the first parameters; those of the wheel's modes and of the rail's modes follow."""

_contact_names = [p.name for p in CONTACT_PARAMETERS]
FIRST_HANDED_DOWN = len(OWN)
HANDED_DOWN_TO = tuple(_contact_names.index(p.name) for p in HANDED_DOWN)
"""Position among the contact's parameters of each one that is handed down."""

TUNED_FROM = tuple(FIRST_HANDED_DOWN + i for i, p in enumerate(HANDED_DOWN) if p.tunable)
TUNED_TO = tuple(_contact_names.index(p.name) for p in HANDED_DOWN if p.tunable)
"""The same of those that may change during the run, and where they are."""

MOBILITY = _contact_names.index("mobility_lon_lon")

N_CONTACT_PARAMETERS = len(CONTACT_PARAMETERS)
N_CONTACT_DERIVED = CONTACT_DERIVED
N_CONTACT_STATE = CONTACT_STATE
N_MOTIONS = len(contact_inputs())
N_CHANGES = len(operating_point_inputs())
N_CONTACT_INPUTS = N_MOTIONS + N_CHANGES
N_CONTACT_OUTPUTS = len(contact_outputs())
N_STRUCTURE_INPUTS = len(structure_inputs())
N_STRUCTURE_OUTPUTS = len(structure_outputs())


def _wires(start: str, end: str) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return positions of the outputs of `start` and of the inputs of `end` that they feed."""
    outputs = [p.name for p in structure_outputs()]
    inputs = [p.name for p in structure_inputs()]
    pairs = []
    for c in connections():
        if (c.start_element, c.end_element) == (start, end):
            source = getattr(OUT, c.start_connector) if start == "contact" else outputs.index(c.start_connector)
            target = getattr(IN, c.end_connector) if end == "contact" else inputs.index(c.end_connector)
            pairs.append((source, target))
    return tuple(p[0] for p in pairs), tuple(p[1] for p in pairs)


WHEEL_OUT, WHEEL_TO_CONTACT = _wires("wheel", "contact")
RAIL_OUT, RAIL_TO_CONTACT = _wires("rail", "contact")
CONTACT_OUT_TO_WHEEL, WHEEL_IN = _wires("contact", "wheel")
CONTACT_OUT_TO_RAIL, RAIL_IN = _wires("contact", "rail")
"""The connections of the contract, as positions: which output feeds which input."""
