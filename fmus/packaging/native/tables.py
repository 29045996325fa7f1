"""A component's declaration in, the C header with its tables out."""

from __future__ import annotations

import json

from ...component import Component, Instance, Variable
from ..description.arrays import arrays, scalars

CAUSALITY = {
    "parameter": "PARAMETER",
    "calculatedParameter": "CALCULATED",
    "local": "LOCAL",
    "input": "INPUT",
    "output": "OUTPUT",
}


def component_header(component: Component, fmi: int, token: str, only_scalars: bool = False) -> str:
    """Return component.h, which instance.h includes.

    Parameters
    ----------
    component : Component
    fmi : major FMI version; in 3, value references count arrays from 1 on and the time is a variable
    token : guid or instantiation token
    only_scalars : whether there are no arrays in FMI 3
    """
    instance = Instance(component)
    rows = [_row(v, place) for v, place in zip(component.variables, instance.places(), strict=True)]
    if fmi == 2:
        first = list(range(len(rows) + 1))
    else:
        groups = scalars(component) if only_scalars else arrays(component)
        first = [*(group.first for group in groups), len(rows), len(rows) + 1]
        rows.append('{"time", "s", 0.0, 0.0, 0.0, MEMORY_SIZE, INDEPENDENT, REAL, 0}')
    sizes = [a.size for a in (instance.parameters, instance.derived, instance.state)]
    numbers = {
        "MEMORY_SIZE": sum(sizes) + instance.inputs.size + instance.outputs.size,
        "N_INPUTS": instance.inputs.size,
        "INPUTS_PLACE": sum(sizes),
        "N_OUTPUTS": instance.outputs.size,
        "OUTPUTS_PLACE": sum(sizes) + instance.inputs.size,
        "N_VARIABLES": len(rows),
        "N_REFERENCES": len(first) - 1,
        "FIRST_REFERENCE": int(fmi > 2),
        "HAS_DERIVATIVES": int(component.differentiable),
    }
    lines = [
        "/* Generated from the declaration of the component. */",
        f"#define TOKEN {json.dumps(token)}",
        *(f"#define {name} {number}" for name, number in numbers.items()),
        *_failure(component, sum(sizes[:2])),
        "static const Variable variables[N_VARIABLES] = {",
        *(f"    {row}," for row in rows),
        "};",
        "/* Position of the first variable of each value reference, and the end. */",
        "static const uint32_t first_variable[N_REFERENCES + 1] = {" + ", ".join(map(str, first)) + "};",
    ]
    return "\n".join(lines) + "\n"


def _failure(component: Component, state: int) -> list[str]:
    """Return what a component says that finds no solution; `state` is the place of its first local variable."""
    if not component.failure:
        return []
    place = state + len(component.of("local")) - 1
    return [f"#define FAILURE {json.dumps(component.failure)}", f"#define FAILURE_PLACE {place}"]


def _row(variable: Variable, place: int) -> str:
    """Return the initialiser of one variable."""
    start = 0.0 if variable.start is None else variable.start
    limits = [_number(x) for x in (start, variable.minimum, variable.maximum)]
    names = [json.dumps(variable.name), json.dumps("" if variable.unit == "1" else variable.unit)]
    kinds = [CAUSALITY[variable.causality], variable.kind.upper(), str(int(variable.tunable))]
    return "{" + ", ".join([*names, *limits, str(place), *kinds]) + "}"


def _number(value: float) -> str:
    """Return a number as C has it, without loss."""
    if value in (float("inf"), float("-inf")):
        return "HUGE_VAL" if value > 0 else "-HUGE_VAL"
    return repr(float(value))
