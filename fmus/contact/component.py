"""The contact component."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..component import Component, Variable
from ..interface import CHANGE, ENERGY_ADDED, contact_inputs, contact_outputs, operating_point_inputs
from .layout import DERIVED_SIZE, STATE_SIZE
from .parameters import MEMORY_ROOM, PARAMETERS

_ACCOUNT = (("lon", "longitudinal"), ("lat", "lateral, contact axes"), ("spin", "spin"), ("normal", "contact normal"))
"""Directions of the account of energy in the order of the state, and their words."""

FAILURE = (
    "the outputs are not finite; an input or parameter is too large, a parameter and its change together are out of "
    "the parameter's range, or the friction table is none: it needs 2 points or more, each farther than the one "
    "before, with friction above 0; or the grid of a contact with memory has more "
    f"than {MEMORY_ROOM} cells"
)
"""What a contact says whose forces are no numbers."""


def operating_point_changes() -> tuple[Variable, ...]:
    """Return the inputs that are added to the parameters of the steady state; 0 changes nothing."""
    declared = {p.name: p for p in PARAMETERS}
    variables = []
    for port in operating_point_inputs():
        whole = declared[port.name.removesuffix(CHANGE)]
        reach = whole.maximum - whole.minimum
        variables.append(
            Variable(port.name, "input", port.unit, port.description,
                     start=0.0, minimum=-reach, maximum=reach, nominal=port.nominal)
        )  # fmt: skip
    return tuple(variables)


def contact(mobility: Mapping[str, float] | None = None) -> Component:
    """Return the contact component with the parameters of the paper's Case 1.

    Parameters
    ----------
    mobility : start values of the interface mobility of the structures, by parameter name; default 0, which makes the
        creep forces explicit
    """
    parameters = tuple(replace(p, start=(mobility or {}).get(p.name, p.start)) for p in PARAMETERS)
    inputs = tuple(
        Variable(p.name, "input", p.unit, p.description, start=0.0, nominal=p.nominal) for p in contact_inputs()
    )
    changes = operating_point_changes()
    names = tuple(v.name for v in (*inputs, *changes))
    settings = tuple(p.name for p in parameters if not p.name.startswith("mobility"))
    outputs = tuple(
        Variable(
            p.name, "output", p.unit, p.description, nominal=p.nominal,
            depends_on=names, initially_depends_on=names + settings,
        )
        for p in contact_outputs()
    )  # fmt: skip
    account = tuple(
        Variable(
            f"{ENERGY_ADDED}_{d}", "local", "J", f"energy that holding the forces has added so far, {word}", start=None,
            nominal=1.0,
        )
        for d, word in _ACCOUNT
    )  # fmt: skip
    return Component(
        name="contact",
        description="Wheel/rail contact: Hertz spring, FASTSIM creep forces, falling or constant friction",
        variables=(*inputs, *outputs, *parameters, *account, *changes),
        derived_size=DERIVED_SIZE,
        state_size=STATE_SIZE,
        kernels="contact.kernels",
        failure=FAILURE,
    )
