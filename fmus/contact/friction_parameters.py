"""The parameters of the friction laws, declared once; those of the contact include them."""

from __future__ import annotations

from ..component import Variable

FALLING, TWO_DECAYS, POLACH, TABLE_OF_CREEPAGE, TABLE_OF_VELOCITY = range(5)
"""Values of the parameter `friction_law`."""

TABLE_POINTS = 50
"""Points that a table has room for."""

ABSCISSA, ORDINATE = "friction_abscissa", "friction_ordinate"


def _real(name: str, unit: str, start: float, low: float, high: float, description: str) -> Variable:
    """Declare a fixed real parameter."""
    nominal = abs(start) or 1.0
    return Variable(name, "parameter", unit, description, start=start, minimum=low, maximum=high, nominal=nominal)


def _points(block: str, high: float, description: str) -> tuple[Variable, ...]:
    """Declare one column of the table."""
    return tuple(
        _real(f"{block}_{i:03d}", "1", 0.0, 0.0, high, f"friction table: {description} of point {i}")
        for i in range(1, TABLE_POINTS + 1)
    )


FRICTION_PARAMETERS = (
    Variable(
        "friction_law", "parameter", "1",
        "friction law: 0, eq. (11), falling with the creepage; with the sliding velocity: 1, two exponentials; 2, "
        "Polach; tables: 3, of the creepage; 4, of the sliding velocity",
        kind="Integer", start=FALLING, minimum=FALLING, maximum=TABLE_OF_VELOCITY,
    ),
    _real("decay_ratio_a", "1", 0.5, -10.0, 1.0, "law 1: share of mu0 that is lost with decay_velocity_a; < 0: gained"),
    _real("decay_velocity_a", "m/s", 0.138, 1e-9, 1e3, "law 1: sliding velocity of the first exponential"),
    _real("decay_ratio_b", "1", 0.5, -10.0, 1.0, "law 1: share of mu0 that is lost with decay_velocity_b; < 0: gained"),
    _real("decay_velocity_b", "m/s", 6.9, 1e-9, 1e3, "law 1: sliding velocity of the second exponential"),
    _real("polach_ratio", "1", 0.4, 0.0, 1.0, "law 2: friction at large sliding velocity over mu0, A"),
    _real("polach_decay", "s/m", 0.6, 0.0, 1e3, "law 2: decay with the sliding velocity, B"),
    Variable(
        "friction_points", "parameter", "1", "friction table: number of points",
        kind="Integer", start=0, minimum=0, maximum=TABLE_POINTS, nominal=10,
    ),
    *_points(ABSCISSA, 1e3, "creepage [-] (law 3) or sliding velocity [m/s] (law 4), rising,"),
    *_points(ORDINATE, 2.0, "friction coefficient, which takes the place of mu0,"),
)  # fmt: skip
