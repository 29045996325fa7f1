"""The vehicle component: a bogie in a curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..component import Component, Variable
from ..errors import DataError
from .contact_table import ContactTable
from .layout import STATE_SIZE, WHEELS, derived_size
from .parameters import PARAMETERS, TABLE

INPUTS = (
    ("curvature", "1/m", 0.0, -0.1, 0.1, "curvature of the track, positive in a left curve", 1e-2),
    ("velocity", "m/s", 10.0, 0.1, 200.0, "speed", 10.0),
    ("cant", "m", 0.0, -0.3, 0.3, "height of the right rail above the left one", 0.1),
    ("mu0", "1", 0.3, 0.01, 2.0, "friction coefficient", 0.3),
)

OUTPUTS = (
    ("steady_creepage_lon", "1", "steady longitudinal creepage gamma1", 1e-3),
    ("steady_creepage_lat", "1", "steady lateral creepage gamma2", 1e-2),
    ("steady_creepage_spin", "rad/m", "steady spin creepage gamma6", 0.1),
    ("normal_load", "N", "steady normal force", 6e4),
    ("contact_angle", "rad", "contact angle", 0.1),
    ("wheel_position", "m", "contact on the wheel from the tape circle, to the field side", 1e-2),
    ("rail_position", "m", "contact on the rail from its crown, to the field side", 1e-2),
    ("semi_axis_lon", "m", "semi-axis a of the contact ellipse, rolling direction", 5e-3),
    ("semi_axis_lat", "m", "semi-axis b of the contact ellipse, lateral", 5e-3),
    ("hertz_stiffness", "N/m", "stiffness of the contact spring", 1e9),
    ("creep_force_lon", "N", "longitudinal creep force on the wheel", 1e4),
    ("creep_force_lat", "N", "lateral creep force on the wheel, in the contact plane", 1e4),
    ("friction_utilisation", "1", "creep force over friction coefficient times normal force", 1.0),
    ("lateral_force", "N", "lateral force on the wheel, to the gauge side", 1e4),
)
"""Outputs of each contact, in the order of `layout.W`; names as the contact component takes them."""


def vehicle(
    name: str = "vehicle", parameters: Mapping[str, float] | None = None, table: ContactTable | None = None
) -> Component:
    """Return the component of a bogie in a curve.

    Parameters
    ----------
    parameters : start values that differ from those of the reference vehicle
    table : contact geometry of wheel and rail; None: the cone-and-arc wheel of the parameters

    Raises
    ------
    DataError
        For an unknown parameter or a value out of range.
    """
    starts = dict(parameters or {})
    declared = PARAMETERS if table is None else (*PARAMETERS, *_table_variables(table))
    if table is not None:
        starts |= table.parameters
    unknown = sorted(set(starts) - {v.name for v in declared})
    if unknown:
        raise DataError(f"{name} has no parameter {unknown[0]!r}")
    declared = tuple(replace(v, start=starts.get(v.name, v.start)) for v in declared)
    inputs = tuple(
        Variable(n, "input", unit, text, start=start, minimum=low, maximum=high, nominal=nominal)
        for n, unit, start, low, high, text, nominal in INPUTS
    )
    return Component(
        name=name,
        description="A two-axle bogie in a curve: operating point of each of its four contacts",
        variables=(*inputs, *_outputs(tuple(v.name for v in (*inputs, *declared))), *declared, *_locals()),
        derived_size=derived_size(0 if table is None else table.shift.size),
        state_size=STATE_SIZE,
        kernels="curving.kernels",
        failure="no steady state in this curve; found down to a radius of %g m",
    )


def _outputs(everything: tuple[str, ...]) -> tuple[Variable, ...]:
    """Return the output variables: values of the wheels, then monitors."""
    inputs = tuple(n for n, *_ in INPUTS)
    wheels = [
        (f"{wheel}_{n}", unit, f"{wheel.replace('_', ' ')} wheel: {text}", nominal)
        for wheel in WHEELS
        for n, unit, text, nominal in OUTPUTS
    ]
    axles = [
        (f"{axle}_{n}", unit, f"{axle} axle: {text}", nominal)
        for axle in ("leading", "trailing")
        for n, unit, text, nominal in (("y", "m", "shift to the left", 1e-3), ("yaw", "rad", "yaw to the left", 1e-3))
    ]
    solver = [
        ("iterations", "1", "Newton iterations of the last step", 1.0),
        ("residual", "1", "largest residual of the equations, relative to the axle load", 1e-12),
    ]
    return tuple(
        Variable(n, "output", unit, text, nominal=nominal, depends_on=inputs, initially_depends_on=everything)
        for n, unit, text, nominal in (*wheels, *axles, *solver)
    )


def _locals() -> tuple[Variable, ...]:
    """Return the local variables, the head of the state."""
    return (
        Variable(
            "failed",
            "local",
            "1",
            "0; why there is no steady state: 1 no solution, 2 a wheel lifts, 3 a flange is climbed",
        ),
        Variable("reached_radius", "local", "m", "radius down to which a steady state was found", nominal=100.0),
    )


def _table_variables(table: ContactTable) -> tuple[Variable, ...]:
    """Return the columns of the table as parameters."""
    return tuple(
        Variable(
            f"table_{n}_{i + 1:03d}", "parameter", unit, f"table, node {i + 1}: {text}", start=float(value),
            minimum=low, maximum=high, nominal=float(abs(column).max()) or 1.0,
        )
        for n, unit, text, low, high in TABLE
        for column in [getattr(table, n)]
        for i, value in enumerate(column)
    )  # fmt: skip
