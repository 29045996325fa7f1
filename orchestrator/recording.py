"""What a run records besides all outputs: glob patterns in, columns of local variables out.

The outputs are fetched at every step, because the coupling needs them; these only when a row is recorded.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from typing import Any

import numpy as np
from numba import njit

from fmus.interface import MODAL_VELOCITY

from . import loop
from .errors import InputError
from .fmu import Fmu

MODAL_VELOCITIES = f"wheel.{MODAL_VELOCITY}_*"
"""What is recorded unless something else is asked for: the sound of the wheel is made of these."""

Further = namedtuple(
    "Further",
    [
        "component",  # (groups,) positions of components in the plan
        "begin",  # (groups + 1,) positions in `reference`
        "reference",  # (variables,) value references, uint32
    ],
)
"""Variables to fetch when a row is recorded, component by component."""


def recorded(fmus: Mapping[str, Fmu], wanted: Sequence[str] | None) -> list[tuple[str, str]]:
    """Return component and name of the real local variables that match a pattern, component by component.

    Parameters
    ----------
    fmus : FMUs by component name
    wanted : patterns such as 'wheel.modal_velocity_*'; None for `MODAL_VELOCITIES`, where the wheel has them

    Raises
    ------
    InputError
        If a pattern matches no variable that can be recorded.
    """
    local = [(c, v) for c, fmu in fmus.items() for v in fmu.names("local") if fmu.variables[v].type == "Real"]
    outputs = [(c, v) for c, fmu in fmus.items() for v in fmu.names("output")]
    for pattern in wanted or ():
        if not any(fnmatchcase(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"--record {pattern}: matches no output and no real local variable; "
                f"a pattern looks like {MODAL_VELOCITIES}"
            )
    chosen = (MODAL_VELOCITIES,) if wanted is None else wanted
    return [(c, v) for c, v in local if any(fnmatchcase(f"{c}.{v}", pattern) for pattern in chosen)]


def patterns(texts: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the patterns of a repeatable option; 'none' stands for no pattern at all.

    >>> patterns(["none"]), patterns([]), patterns(["rail.*"])
    ((), None, ('rail.*',))
    """
    if not texts:
        return None
    return () if list(texts) == ["none"] else tuple(texts)


def further(names: Sequence[str], variables: Sequence[tuple[str, str]], fmus: Mapping[str, Fmu]) -> Further:
    """Resolve variables to value references; `names` are the components in the order of the plan."""
    groups = [name for name in names if any(c == name for c, _ in variables)]
    sizes = [sum(c == name for c, _ in variables) for name in groups]
    ordered = [fmus[c].variables[v].valueReference for name in groups for c, v in variables if c == name]
    return Further(
        np.array([names.index(name) for name in groups], dtype=np.int64),
        np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64),
        np.array(ordered, dtype=np.uint32),
    )


@njit(cache=True)
def _fetch(plan, more, row):  # type: ignore[no-untyped-def]
    """Get the further variables into the end of a row; return component and FMI status."""
    first = row.size - more.reference.size
    for g in range(more.component.size):
        c = more.component[g]
        begin, end = more.begin[g], more.begin[g + 1]
        references = more.reference.ctypes.data + 4 * begin
        values = row.ctypes.data + 8 * (first + begin)
        status = loop._call_reals(plan.get_real[c], plan.handle[c], references, end - begin, values)  # type: ignore[call-arg, var-annotated]
        if status > 1:
            return c, status
    return 0, 0


@njit(cache=True)
def advance(plan, more, clock, steps, every, record):  # type: ignore[no-untyped-def]
    """Do what `loop.advance` does, and fetch the further variables whenever a row is recorded.

    Parameters
    ----------
    more : Further
    record : (rows, outputs + energy rows + further variables) array that takes what is recorded

    Returns
    -------
    As `loop.advance`.
    """
    start, h, first = clock
    if more.reference.size == 0:
        return loop.advance(plan, clock, steps, every, record)
    done = rows = 0
    while done < steps:
        size = min(every - (first + done) % every, steps - done)
        made, count, what, where, status = loop.advance(plan, (start, h, first + done), size, every, record[rows:])
        done += made
        if count and what == loop.OK:
            where, status = _fetch(plan, more, record[rows])
            if status > 1:
                return done, rows, loop.GET, where, status
        rows += count
        if what != loop.OK:
            return done, rows, what, where, status
    return done, rows, loop.OK, 0, 0


def columns(component: str, variables: Sequence[Any]) -> list[str]:
    """Return the names of a component's modal velocities among the variables of a results file, in order.

    >>> columns("wheel", ["wheel.v_lat", "wheel.modal_velocity_001"])
    ['wheel.modal_velocity_001']
    """
    return sorted(str(name) for name in variables if fnmatchcase(str(name), f"{component}.{MODAL_VELOCITY}_*"))
