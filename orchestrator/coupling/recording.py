"""What a run records besides all outputs: glob patterns in, columns of local variables out.

The outputs are fetched at every step, because the coupling needs them; these only when a row is recorded.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Mapping, Sequence

import numpy as np
from numba import njit

from ..errors import InputError
from ..fmi.file import NUMERIC, Fmu
from ..results.columns import MODAL_VELOCITIES, matches
from . import loop


def recorded(fmus: Mapping[str, Fmu], wanted: Sequence[str] | None) -> list[tuple[str, str]]:
    """Return component and name of the local variables that match a pattern, component by component, in call order.

    Parameters
    ----------
    fmus : FMUs by component name
    wanted : patterns such as 'wheel.modal_velocity_*'; None for `MODAL_VELOCITIES`, where the wheel has them

    Raises
    ------
    InputError
        If a pattern matches no variable that can be recorded, or nothing but texts: a row of results has a fixed size.
    """
    local = [(c, v) for c, fmu in fmus.items() for v in fmu.names("local") if fmu.variables[v].type in NUMERIC]
    outputs = [(c, v) for c, fmu in fmus.items() for v in fmu.names("output") if fmu.variables[v].type in NUMERIC]
    texts = [f"{c}.{name}" for c, fmu in fmus.items() for name, v in fmu.variables.items() if v.type == "String"]
    for pattern in wanted or ():
        found = [name for name in texts if matches(name, pattern)]
        if found and not any(matches(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"record {pattern}: {found[0]} is a text; results hold numbers only, a text can be connected but not "
                "recorded"
            )
        if not any(matches(f"{c}.{v}", pattern) for c, v in local + outputs):
            raise InputError(
                f"record {pattern}: matches no output and no local variable that is a number; "
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


Further = namedtuple("Further", ["transfers", "real", "word", "wide", "whole"])
"""Variables that are fetched when a row is recorded: the calls that get them, their latest values, the positions of
whole numbers of 64 bits among them, and whether any of them is a whole number."""


@njit(cache=True)
def _fetch(plan, more, row, words):  # type: ignore[no-untyped-def]
    """Get the further variables into the end of a row; return component and FMI status of a call that failed."""
    values = loop.Values(more.real, more.word)
    for c in range(more.transfers.begin.size - 1):
        for t in range(more.transfers.begin[c], more.transfers.begin[c + 1]):
            status = loop._exchange(plan, more.transfers, t, c, values, False)
            if status > 1:
                return c, status
    before = row.size - more.real.size
    loop.put(row, words, before, values, more.wide)
    return 0, 0


@njit(cache=True)
def snapshot(plan, more, record):  # type: ignore[no-untyped-def]
    """Record the outputs as they are, and the further variables; return component and FMI status of a failed call."""
    loop._record(plan, record[0][0], record[1][0])
    return _fetch(plan, more, record[0][0], record[1][0])


@njit(cache=True, nogil=True)
def advance(plan, more, clock, first, steps, every, record):  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    """Do what `loop.advance` does, and fetch the further variables whenever a row is recorded.

    They are not known any more for the step before a fault: the components have gone on from there. Doubles are then no
    numbers; whole numbers, which cannot say so, are fetched at every step.

    Parameters
    ----------
    more : Further
    record : (rows, outputs + energy rows + further variables) array that takes what is recorded, and the same memory
        as integers

    Returns
    -------
    As `loop.advance`.
    """
    if more.real.size == 0:
        return loop.advance(plan, clock, first, steps, every, record)
    done = rows = kept = 0  # `kept`: as in `loop.advance`
    while done < steps:
        size = 1 if more.whole else min(every - (first + done) % every, steps - done)
        part = (record[0][rows:], record[1][rows:])
        made, count, what, where, status = loop.advance(plan, clock, first + done, size, every, part)
        done += made
        fault = what != loop.OK and plan.ending[0] < 0
        if (count or more.whole) and not fault:
            failed, bad = _fetch(plan, more, part[0][0], part[1][0])
            if bad > 1:
                return done, rows, loop.GET, failed, bad
        elif count:
            part[0][0][part[0].shape[1] - more.real.size :] = np.nan
        if fault:
            return done, rows + max(count, kept), what, where, status
        rows, kept = rows + count, 1 - count
        if what != loop.OK:
            return done, rows, what, where, status
    return done, rows, loop.OK, 0, 0
