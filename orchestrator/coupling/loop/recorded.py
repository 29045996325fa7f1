"""The loop with further variables, which are fetched only when a row is recorded."""

from __future__ import annotations

from collections import namedtuple

import numpy as np

from .compiled import kept
from .data import GET, OK, Values
from .steps import advance as steps_alone
from .steps import exchange_values, put, record_outputs

Further = namedtuple("Further", ["transfers", "real", "word", "wide", "whole"])
"""Variables that are fetched when a row is recorded: the calls that get them, their latest values, the positions of
whole numbers of 64 bits among them, and whether any of them is a whole number."""


@kept()
def _fetch(plan, more, row, words):  # type: ignore[no-untyped-def]
    """Get the further variables into the end of a row; return component and FMI status of a call that failed."""
    values = Values(more.real, more.word)
    for c in range(more.transfers.begin.size - 1):
        for t in range(more.transfers.begin[c], more.transfers.begin[c + 1]):
            status = exchange_values(plan, more.transfers, t, c, values, False)
            if status > 1:
                return c, status
    before = row.size - more.real.size
    put(row, words, before, values, more.wide)
    return 0, 0


@kept()
def snapshot(plan, more, record):  # type: ignore[no-untyped-def]
    """Record the outputs as they are, and the further variables; return component and FMI status of a failed call."""
    record_outputs(plan, record[0][0], record[1][0])
    return _fetch(plan, more, record[0][0], record[1][0])


@kept(nogil=True)
def advance(plan, more, clock, first, steps, every, record):  # type: ignore[no-untyped-def]  # noqa: PLR0913, PLR0917
    """Do what `steps.advance` does, and fetch the further variables whenever a row is recorded.

    They are not known any more for the step before a fault: the components have gone on from there. Doubles are then no
    numbers; whole numbers, which cannot say so, are fetched at every step.

    Parameters
    ----------
    more : Further
    record : (rows, outputs + energy rows + further variables) array that takes what is recorded, and the same memory
        as integers

    Returns
    -------
    As `steps.advance`.
    """
    if more.real.size == 0:
        return steps_alone(plan, clock, first, steps, every, record)
    done = rows = kept = 0  # `kept`: as in `steps.advance`
    while done < steps:
        size = 1 if more.whole else min(every - (first + done) % every, steps - done)
        part = (record[0][rows:], record[1][rows:])
        made, count, what, where, status = steps_alone(plan, clock, first + done, size, every, part)
        done += made
        fault = what != OK and plan.ending[0] < 0
        if (count or more.whole) and not fault:
            failed, bad = _fetch(plan, more, part[0][0], part[1][0])
            if bad > 1:
                return done, rows, GET, failed, bad
        elif count:
            part[0][0][part[0].shape[1] - more.real.size :] = np.nan
        if fault:
            return done, rows + max(count, kept), what, where, status
        rows, kept = rows + count, 1 - count
        if what != OK:
            return done, rows, what, where, status
    return done, rows, OK, 0, 0
