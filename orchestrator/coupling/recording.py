"""What a run records besides all outputs: glob patterns in, columns of local variables out.

The outputs are fetched at every step, because the coupling needs them; these only when a row is recorded.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from numba import njit

from ..errors import InputError
from ..fmi.file import Fmu
from ..results.columns import MODAL_VELOCITIES, matches
from . import loop

_DOUBLE = ("Real", "Float64")


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
    local = [(c, v) for c, fmu in fmus.items() for v in fmu.names("local") if fmu.variables[v].fmi_type in _DOUBLE]
    outputs = [(c, v) for c, fmu in fmus.items() for v in fmu.names("output")]
    for pattern in wanted or ():
        if not any(matches(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"record {pattern}: matches no output and no real local variable; "
                f"a pattern looks like {MODAL_VELOCITIES}"
            )
    chosen = (MODAL_VELOCITIES,) if wanted is None else wanted
    return [(c, v) for c, v in local if any(matches(f"{c}.{v}", pattern) for pattern in chosen)]


def patterns(texts: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the patterns of a repeatable option; 'none' stands for no pattern at all.

    >>> patterns(["none"]), patterns([]), patterns(["rail.*"])
    ((), None, ('rail.*',))
    """
    if not texts:
        return None
    return () if list(texts) == ["none"] else tuple(texts)


@njit(cache=True)
def _fetch(plan, more, row):  # type: ignore[no-untyped-def]
    """Get the further variables into the end of a row; return component and FMI status of a call that failed."""
    values = row[row.size - more.value_begin[-1] :]
    for c in range(more.begin.size - 1):
        for t in range(more.begin[c], more.begin[c + 1]):
            status = loop._exchange(plan, more, t, c, values, False)
            if status > 1:
                return c, status
    return 0, 0


@njit(cache=True)
def advance(plan, more, clock, steps, every, record):  # type: ignore[no-untyped-def]
    """Do what `loop.advance` does, and fetch the further variables whenever a row is recorded.

    Parameters
    ----------
    more : Transfers of the further variables, see `plan.transfers`
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
