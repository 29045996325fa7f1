"""The system component: wheel, rail and contact in, one component out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..component import Component, Variable
from ..interface import CHANGE, DEFAULT_STEP, MODAL_VELOCITY, contact_inputs
from ..modal.layout import N_STATES, n_parameters
from .layout import (
    HANDED_DOWN,
    N_CONTACT_DERIVED,
    N_CONTACT_INPUTS,
    N_CONTACT_OUTPUTS,
    N_CONTACT_PARAMETERS,
    N_CONTACT_STATE,
    N_STRUCTURE_INPUTS,
    N_STRUCTURE_OUTPUTS,
)


def system(name: str, wheel: Component, rail: Component, contact: Component, values: Mapping[str, float]) -> Component:
    """Return the coupled system as one component.

    Parameters
    ----------
    name : model name
    wheel, rail, contact : the parts; their start values become those of the system
    values : start values of the contact that differ, by parameter name

    Notes
    -----
    Inputs are changes of the steady creepages, the steady normal load and the friction coefficient, added to the
    parameters.
    Outputs are the motion at the contact point, the forces and the contact's monitors. Parameters of wheel and rail
    have their names with "wheel_" and "rail_" in front.
    """
    declared = {v.name: v for v in contact.of("parameter")}
    declared |= {n: replace(declared[n], start=value) for n, value in values.items()}
    structures = {"wheel": wheel, "rail": rail}
    sizes = {s: component.state_size // N_STATES for s, component in structures.items()}
    own = (
        *(_size(f"{s}_modes", n, f"number of modes of the {s}; fixed") for s, n in sizes.items()),
        Variable(
            "micro_step", "parameter", "s", "longest step of the coupling inside; a longer one is divided",
            start=DEFAULT_STEP, minimum=1e-9, maximum=1e-2, nominal=DEFAULT_STEP,
        ),
    )  # fmt: skip
    changes = tuple(v for v in contact.of("input") if v.name.endswith(CHANGE))
    ports = {p.name: p for p in contact_inputs()}
    measured = [
        Variable(name, "output", port.unit, port.description, nominal=port.nominal) for name, port in ports.items()
    ]
    outputs = tuple(replace(v, depends_on=(), initially_depends_on=None) for v in (*measured, *contact.of("output")))
    parameters = (
        *own,
        *(declared[p.name] for p in HANDED_DOWN),
        *(
            replace(v, name=f"{s}_{v.name}", description=f"{s}: {v.description}")
            for s, component in structures.items()
            for v in component.of("parameter")[:-1]
        ),
    )
    velocities = tuple(
        replace(v, name=f"wheel_{v.name}", description=f"wheel: {v.description}")
        for v in wheel.of("local")
        if v.name.startswith(MODAL_VELOCITY)
    )
    return Component(
        name=name,
        description="Railway wheel, rail and contact, coupled without inventing squeal",
        variables=(*changes, *outputs, *parameters, *velocities),
        derived_size=sum(c.derived_size + n_parameters(sizes[s]) for s, c in structures.items())
        + N_CONTACT_PARAMETERS
        + N_CONTACT_DERIVED,
        state_size=sum(c.state_size + N_STRUCTURE_INPUTS + N_STRUCTURE_OUTPUTS for c in structures.values())
        + N_CONTACT_STATE
        + N_CONTACT_INPUTS
        + N_CONTACT_OUTPUTS,
        kernels="system.kernels",
        failure=contact.failure,
    )


def _size(name: str, count: int, description: str) -> Variable:
    """Declare a structural size, which only has one value."""
    return Variable(
        name, "parameter", "1", description, kind="Integer", start=count, minimum=count, maximum=count, nominal=10
    )
