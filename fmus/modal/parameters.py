"""The names of a structure's modal parameters, in one place: values by name in, modes out, and the way back.

An FMU of FMI 2.0 has a variable for each mode, `frequency_001`; one of FMI 3.0 an array, `frequency[1]`. Whoever asks
for modes by name asks here, so that both spellings mean the same everywhere.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import DataError
from ..interface import MODAL_VELOCITY
from .layout import DAMPING_RATIO, FREQUENCY, SHAPES
from .modes import Modes

_NUMBERED = re.compile(r"(.+?)(?:_(\d{3,})|\[(\d+)\])")


def name_of(block: str, mode: int) -> str:
    """Return the name of a quantity of a mode, counted from 1, as a component declares it.

    >>> name_of("frequency", 12)
    'frequency_012'
    """
    return f"{block}_{mode:03d}"


def numbered(name: str) -> tuple[str, int] | None:
    """Return the block and the number of a mode's variable in either spelling; None for any other name.

    >>> numbered("frequency_012"), numbered("shape_lat[3]"), numbered("v_lat")
    (('frequency', 12), ('shape_lat', 3), None)
    """
    match = _NUMBERED.fullmatch(name)
    return (match[1], int(match[2] or match[3])) if match else None


def as_declared(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values under the names that a component declares, whatever the spelling of the FMU.

    >>> as_declared({"friction_abscissa[2]": 0.01, "mu0": 0.3})
    {'friction_abscissa_002': 0.01, 'mu0': 0.3}
    """
    return {name_of(*key) if (key := numbered(name)) else name: value for name, value in values.items()}


def as_spelled(values: Mapping[str, Any], among: Container[str]) -> dict[str, Any]:
    """Return values under the names that an FMU has for what a component declares; what it does not have stays.

    >>> as_spelled({"friction_abscissa_002": 0.01, "mu0": 0.3}, {"friction_abscissa[2]", "mu0"})
    {'friction_abscissa[2]': 0.01, 'mu0': 0.3}
    """
    result = {}
    for name, value in values.items():
        key = numbered(name)
        element = f"{key[0]}[{key[1]}]" if key else name
        result[element if name not in among and element in among else name] = value
    return result


def names_of(block: str, among: Iterable[str]) -> dict[int, str]:
    """Return the names that belong to a block, by number of the mode, in order.

    >>> names_of("frequency", ["frequency[2]", "frequency[1]", "shape_lat[1]"])
    {1: 'frequency[1]', 2: 'frequency[2]'}
    """
    found = ((key[1], name) for name in among if (key := numbered(name)) and key[0] == block)
    return dict(sorted(found))


def modal_velocities(component: str, among: Iterable[object]) -> list[str]:
    """Return the names of a component's modal velocities among the columns of a record, in the order of the modes.

    >>> modal_velocities("wheel", ["wheel.v_lat", "wheel.modal_velocity[2]", "wheel.modal_velocity[1]"])
    ['wheel.modal_velocity[1]', 'wheel.modal_velocity[2]']
    """
    return list(names_of(f"{component}.{MODAL_VELOCITY}", map(str, among)).values())


def block_of(block: str, values: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return a quantity of all modes, in order; empty where the values do not tell it."""
    return np.array([float(values[name]) for name in names_of(block, values).values()])


def moving_modes(values: Mapping[str, Any], prefix: str = "") -> list[int]:
    """Return the numbers of the modes that move the contact point, in order: those that `modes_of` returns."""
    shapes = [names_of(prefix + block, values) for block in SHAPES]
    return [n for n in names_of(prefix + FREQUENCY, values) if any(float(values[s[n]]) for s in shapes if n in s)]


def modes_of(values: Mapping[str, Any], prefix: str = "") -> Modes | None:
    """Return the modes that the parameters of a structure say; None if it shows none.

    Parameters
    ----------
    values : parameter values by name
    prefix : in front of the names, such as "wheel_" in the FMU of the whole system

    Returns
    -------
    The modes that move; empty for a structure that shows modes and moves in none of them. None is another thing: a
    structure that does not show its modes may move in any way.

    Raises
    ------
    DataError
        If a mode is not told completely, or is none.
    """
    modes = names_of(prefix + FREQUENCY, values)
    if not modes:
        return None
    table = np.empty((len(modes), 2 + len(SHAPES)))
    for j, block in enumerate((FREQUENCY, DAMPING_RATIO, *SHAPES)):
        names = names_of(prefix + block, values)
        missing = sorted(modes.keys() - names.keys())
        if missing:
            raise DataError(f"mode {missing[0]} has no {prefix + block}")
        for i, mode in enumerate(modes):
            table[i, j] = float(values[names[mode]])
    moving = [list(modes).index(n) for n in moving_modes(values, prefix)]
    table = table[moving]
    return Modes(2 * np.pi * table[:, 0], table[:, 1], table[:, 2:])
