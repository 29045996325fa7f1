"""The coupled system: wheel and rail step with the held forces, then the contact makes new ones. Kernels.

A component made of components: its arrays hold the arrays of the three, one after the other. `couple` is the order of
stepping, the same that a master needs (docs/adr/0003); whoever runs the three in one process calls it, too.
"""

import math

from ..compile import kernel
from ..contact.kernels import do_step as contact_step
from ..contact.kernels import initialise as contact_initialise
from ..contact.kernels import turn_mobility
from ..modal.kernels import do_step as structure_step
from ..modal.kernels import initialise as structure_initialise
from ..modal.kernels import tabulate
from ..modal.layout import N_BLOCKS, N_MOBILITIES, N_STATES, N_TABLES
from .layout import (
    CONTACT_OUT_TO_RAIL,
    CONTACT_OUT_TO_WHEEL,
    FIRST_HANDED_DOWN,
    HANDED_DOWN_TO,
    MOBILITY,
    N_CHANGES,
    N_CONTACT_DERIVED,
    N_CONTACT_INPUTS,
    N_CONTACT_OUTPUTS,
    N_CONTACT_PARAMETERS,
    N_CONTACT_STATE,
    N_MOTIONS,
    N_STRUCTURE_INPUTS,
    N_STRUCTURE_OUTPUTS,
    RAIL_IN,
    RAIL_OUT,
    RAIL_TO_CONTACT,
    TUNED_FROM,
    TUNED_TO,
    WHEEL_IN,
    WHEEL_OUT,
    WHEEL_TO_CONTACT,
    P,
)


@kernel
def wire(source, positions, target, places):  # type: ignore[no-untyped-def]
    """Copy values at `positions` of `source` to `places` of `target`."""
    for k in range(len(positions)):
        target[places[k]] = source[positions[k]]


@kernel
def copy(source, target, begin, place, count):  # type: ignore[no-untyped-def]
    """Copy `count` values from position `begin` to position `place`."""
    for k in range(count):
        target[place + k] = source[begin + k]


@kernel
def feed_contact(wheel, rail, contact):  # type: ignore[no-untyped-def]
    """Bring velocities and displacements to the contact.

    Each component is (parameters, derived, state, inputs, outputs).
    """
    wire(wheel[4], WHEEL_OUT, contact[3], WHEEL_TO_CONTACT)
    wire(rail[4], RAIL_OUT, contact[3], RAIL_TO_CONTACT)


@kernel
def feed_structures(wheel, rail, contact):  # type: ignore[no-untyped-def]
    """Bring the forces to wheel and rail."""
    wire(contact[4], CONTACT_OUT_TO_WHEEL, wheel[3], WHEEL_IN)
    wire(contact[4], CONTACT_OUT_TO_RAIL, rail[3], RAIL_IN)


@kernel
def couple(wheel, rail, contact, h):  # type: ignore[no-untyped-def]
    """Make one step of the coupled system: structures first, then the contact."""
    structure_step(wheel[0], wheel[1], wheel[2], wheel[3], wheel[4], h)
    structure_step(rail[0], rail[1], rail[2], rail[3], rail[4], h)
    feed_contact(wheel, rail, contact)
    contact_step(contact[0], contact[1], contact[2], contact[3], contact[4], h)
    feed_structures(wheel, rail, contact)


@kernel
def _parts(parameters, derived, state):  # type: ignore[no-untyped-def]
    """Return the arrays of wheel, rail and contact, which are pieces of the system's derived quantities and state."""
    n_wheel = int(parameters[P.wheel_modes])
    n_rail = int(parameters[P.rail_modes])
    a = N_BLOCKS * n_wheel + 1
    b = a + N_TABLES * n_wheel + N_MOBILITIES + 1
    c = b + N_BLOCKS * n_rail + 1
    d = c + N_TABLES * n_rail + N_MOBILITIES + 1
    e = d + N_CONTACT_PARAMETERS
    s = N_STATES * n_wheel
    t = s + N_STATES * n_rail
    u = t + N_CONTACT_STATE
    v = u + N_STRUCTURE_INPUTS
    w = v + N_STRUCTURE_OUTPUTS
    x = w + N_STRUCTURE_INPUTS
    y = x + N_STRUCTURE_OUTPUTS
    z = y + N_CONTACT_INPUTS
    wheel = (derived[0:a], derived[a:b], state[0:s], state[u:v], state[v:w])
    rail = (derived[b:c], derived[c:d], state[s:t], state[w:x], state[x:y])
    contact = (
        derived[d:e],
        derived[e : e + N_CONTACT_DERIVED],
        state[t:u],
        state[y:z],
        state[z : z + N_CONTACT_OUTPUTS],
    )
    return wheel, rail, contact


@kernel
def _add_mobilities(wheel, rail, contact):  # type: ignore[no-untyped-def]
    """Give the contact the sum of the interface mobilities."""
    for k in range(N_MOBILITIES):
        contact[0][MOBILITY + k] = wheel[1][k] + rail[1][k]


MOST_STEPS = 1e7
"""Most micro steps in a step: more would not come back within a minute."""

LARGE = 1e300
"""Its square is not finite."""


@kernel
def _micro_steps(parameters, wheel, rail, contact, h):  # type: ignore[no-untyped-def]
    """Return number and size of the steps that make up `h`; everything that depends on the size follows it."""
    count = max(1, int(math.ceil(h / parameters[P.micro_step] - 1e-9)))  # noqa: RUF046 - a float when compiled
    size = h / count
    known = wheel[1][N_MOBILITIES]
    if abs(size - known) <= 1e-9 * known:
        return count, known
    tabulate(wheel[0], wheel[1], size)
    tabulate(rail[0], rail[1], size)
    _add_mobilities(wheel, rail, contact)
    turn_mobility(contact[0], contact[1])
    return count, size


@kernel
def _put_out(contact, outputs):  # type: ignore[no-untyped-def]
    """Put out what the contact sees and what it tells."""
    copy(contact[3], outputs, 0, 0, N_MOTIONS)
    copy(contact[4], outputs, 0, N_MOTIONS, N_CONTACT_OUTPUTS)


@kernel
def initialise(parameters, derived, state, inputs, outputs):  # type: ignore[no-untyped-def]
    """Start wheel and rail with their initial modal velocities, and the contact from what they do."""
    wheel, rail, contact = _parts(parameters, derived, state)
    begin = FIRST_HANDED_DOWN + len(HANDED_DOWN_TO)
    n_wheel = wheel[0].size - 1
    n_rail = rail[0].size - 1
    copy(parameters, wheel[0], begin, 0, n_wheel)
    copy(parameters, rail[0], begin + n_wheel, 0, n_rail)
    wheel[0][n_wheel] = parameters[P.micro_step]
    rail[0][n_rail] = parameters[P.micro_step]
    for k in range(len(HANDED_DOWN_TO)):
        contact[0][HANDED_DOWN_TO[k]] = parameters[FIRST_HANDED_DOWN + k]
    copy(inputs, contact[3], 0, N_MOTIONS, N_CHANGES)
    structure_initialise(wheel[0], wheel[1], wheel[2], wheel[3], wheel[4])
    structure_initialise(rail[0], rail[1], rail[2], rail[3], rail[4])
    _add_mobilities(wheel, rail, contact)
    feed_contact(wheel, rail, contact)
    contact_initialise(contact[0], contact[1], contact[2], contact[3], contact[4])
    feed_structures(wheel, rail, contact)
    _put_out(contact, outputs)


@kernel
def do_step(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Advance by as many equal micro steps as it takes for none to be longer than `micro_step`."""
    wheel, rail, contact = _parts(parameters, derived, state)
    wire(parameters, TUNED_FROM, contact[0], TUNED_TO)
    if h <= MOST_STEPS * parameters[P.micro_step]:
        copy(inputs, contact[3], 0, N_MOTIONS, N_CHANGES)
        count, size = _micro_steps(parameters, wheel, rail, contact, h)
        for _ in range(count):
            couple(wheel, rail, contact, size)
        _put_out(contact, outputs)
    else:
        for k in range(len(outputs)):
            outputs[k] = h * LARGE * LARGE  # not finite, which the FMU answers with an error
