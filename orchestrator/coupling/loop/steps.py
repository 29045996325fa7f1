"""The compiled co-simulation loop: index arrays and function addresses in, outputs out. No files, no FMPy, no names.

Numba calls the FMI functions by address, so a step costs no Python. What happens in a step is data: a list of stages,
each a list of components. In a stage every component first gets its inputs from the latest outputs, then all make
their step, then all give their outputs. One stage with everybody is the Jacobi scheme; structures first and the
contact second is the staggered scheme. An iteration repeats the stages from the state before the step.

All is compiled into one function over borrowed arrays: references that are counted at each call cost 20 times as much
as the loop does without (three small C FMUs: 10 us per step against 0.4).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from .calls import (
    borrowed,
    call_state,
    call_step_2,
    call_step_3,
    call_values_2,
    call_values_3,
    flag,
    pack,
    unpack,
)
from .compiled import kept
from .data import (
    ENDED,
    GET,
    LAST_STATUS,
    NOT_CONVERGED,
    NOT_FINITE,
    OK,
    OUTSIDE,
    RESTORE,
    SAVE,
    SET,
    STEP,
    STOOD,
    TOO_LARGE,
    Values,
)
from .energy import count_energy, remember_motion


@njit(inline="always")
def _known(status):  # type: ignore[no-untyped-def]
    """Return an FMI status, or `OUTSIDE` for what is none."""
    return status if 0 <= status <= LAST_STATUS else OUTSIDE


@njit(inline="always")
def exchange_values(plan, transfers, t, c, values, setting):  # type: ignore[no-untyped-def]
    """Set or get the variables of transfer `t` of component `c`; return the FMI status."""
    first = transfers.reference_begin[t]
    count = transfers.reference_begin[t + 1] - first
    references = transfers.reference.ctypes.data + 4 * first
    begin, end = transfers.value_begin[t], transfers.value_begin[t + 1]
    layout, size, direct = transfers.layout[t], transfers.size[t], transfers.direct[t]
    address = plan.scratch.ctypes.data
    if direct:
        address = values.real.ctypes.data + 8 * transfers.place[begin]
    elif setting:
        for i in range(begin, end):
            k = transfers.place[i]
            if not pack(layout, address, transfers.slot[i], values.real[k], values.word[k]):
                return TOO_LARGE
    function = transfers.function[t]
    status: int
    if plan.version[c] == 2:
        status = call_values_2(function, plan.handle[c], references, count, address)  # type: ignore[call-arg]
    else:
        status = call_values_3(function, plan.handle[c], references, count, address, size)  # type: ignore[call-arg]
    if not direct and not setting:
        for i in range(begin, end):
            k = transfers.place[i]
            values.real[k], values.word[k] = unpack(layout, address, transfers.slot[i])
    return _known(status)


@njit(inline="always")
def _set_inputs(plan, c):  # type: ignore[no-untyped-def]
    """Bring the inputs of component `c` up to date with the latest outputs and set them; return the FMI status."""
    transfers = plan.inputs
    worst = 0
    for t in range(transfers.begin[c], transfers.begin[c + 1]):
        for k in range(transfers.value_begin[t], transfers.value_begin[t + 1]):
            i = transfers.place[k]
            latest = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
            share = plan.share[i]
            plan.u[i] = latest if share == 1.0 else (1.0 - share) * plan.u_before[i] + share * latest
            plan.u_word[i] = plan.y_word[plan.source[i]] if plan.exact[i] else np.int64(np.rint(plan.u[i]))
        worst = max(worst, exchange_values(plan, transfers, t, c, Values(plan.u, plan.u_word), True))
    return worst


@njit(inline="always")
def _get_outputs(plan, c):  # type: ignore[no-untyped-def]
    """Get the outputs of component `c`; return the FMI status."""
    transfers = plan.outputs
    worst = 0
    for t in range(transfers.begin[c], transfers.begin[c + 1]):
        worst = max(worst, exchange_values(plan, transfers, t, c, Values(plan.y, plan.y_word), False))
    return worst


@kept()
def exchange(plan, c, setting):  # type: ignore[no-untyped-def]
    """Bring the inputs of component `c` up to date, or get its outputs, between steps; return the FMI status."""
    if not setting:
        return _get_outputs(plan, c)
    transfers = plan.inputs
    for k in range(transfers.value_begin[transfers.begin[c]], transfers.value_begin[transfers.begin[c + 1]]):
        i = transfers.place[k]
        plan.u_before[i] = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
    return _set_inputs(plan, c)


@njit(inline="always")
def _do_step(plan, c, number, clock):  # type: ignore[no-untyped-def]
    """Let component `c` make the step that ends with step `number`; return the FMI status, or `ENDED` or `STOOD`.

    The last step ends at the stop time, to the bit, where the component takes any step.
    """
    start, h, total, stop = clock
    begin = start + (number + 1 - plan.period[c]) * h
    step = plan.period[c] * h
    if number + 1 == total and plan.flexible[c] and begin + step > stop:
        step = stop - begin
    final = 1 if plan.sweeps[0] == 1 else 0  # whether the state before the step will not be asked for again
    if plan.version[c] == 2:
        made: int = call_step_2(plan.do_step[c], plan.handle[c], begin, step, final)  # type: ignore[call-arg]
        return _known(made)
    answer = plan.answer.ctypes.data + 16 * c
    end = begin + step
    while True:
        status: int = call_step_3(plan.do_step[c], plan.handle[c], begin, step, final, answer)  # type: ignore[call-arg]
        status = _known(status)
        ends, early, reached = flag(answer, 1), flag(answer, 2), plan.answer[c, 1]
        if status > 2 or not (ends or early):
            return status
        if ends and (early or status == 2):
            return ENDED
        if ends:
            plan.ending[0] = c
            return status
        if status == 2 or reached >= end:
            return status
        if not reached > begin:
            return STOOD
        begin, step = reached, end - reached


@njit(inline="always")
def _sweep(plan, number, clock):  # type: ignore[no-untyped-def]
    """Let all components make step `number`; return what was done last, by which component, and the FMI status."""
    for s in range(plan.stage_begin.size - 1):
        for what in (SET, STEP, GET):
            for k in range(plan.stage_begin[s], plan.stage_begin[s + 1]):
                c = plan.order[k]
                if (number + 1) % plan.period[c] != 0:
                    continue
                if what == SET:
                    status = _set_inputs(plan, c)
                elif what == STEP:
                    status = _do_step(plan, c, number, clock)
                else:
                    status = _get_outputs(plan, c)
                if status > 1:
                    return what, c, status
    return OK, 0, 0


@njit(inline="always")
def _states(plan, functions, saving):  # type: ignore[no-untyped-def]
    """Get or set the states of all components; return what was done last, by which component, and the FMI status."""
    for c in range(plan.handle.size):
        argument = plan.state.ctypes.data + 8 * c if saving else plan.state[c]
        status: int = call_state(functions[c], plan.handle[c], argument)  # type: ignore[call-arg]
        status = _known(status)
        if status > 1:
            return (SAVE if saving else RESTORE), c, status
    return OK, 0, 0


@njit(inline="always")
def _change(plan):  # type: ignore[no-untyped-def]
    """Return the largest change of an input since the last sweep, as a share of the tolerance; remember the values."""
    largest = 0.0
    for i in range(plan.u.size):
        value = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
        size = max(plan.u_scale[i, 1], abs(value))
        plan.u_scale[i, 1] = size
        change = abs(value - plan.u_last[i])
        allowed = plan.tolerance[0] * (plan.u_scale[i, 0] + size)
        if change > largest * allowed:
            largest = change / allowed
            plan.sweeps[3] = i
        plan.u_last[i] = value
    return largest


@njit(inline="always")
def _step(plan, number, clock):  # type: ignore[no-untyped-def]
    """Make step `number`, in as many sweeps as the algorithm wants; return as `_sweep` does."""
    if plan.sweeps[0] == 1:
        return _sweep(plan, number, clock)
    for i in range(plan.u.size):
        plan.u_before[i] = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
        plan.u_last[i] = plan.u_before[i]
    what, c, status = _states(plan, plan.get_state, True)
    if what != OK:
        return what, c, status
    for sweep in range(1, plan.sweeps[0] + 1):
        if sweep > 1:
            what, c, status = _states(plan, plan.set_state, False)
            if what != OK:
                return what, c, status
        what, c, status = _sweep(plan, number, clock)
        if what != OK:
            return what, c, status
        if _change(plan) <= 1.0:
            plan.sweeps[1] += sweep
            plan.sweeps[2] = max(plan.sweeps[2], sweep)
            return OK, 0, 0
    return NOT_CONVERGED, plan.sweeps[3], 0


@njit(inline="always")
def put(row, words, begin, values, wide):  # type: ignore[no-untyped-def]
    """Record values from column `begin` of a row of doubles, or of the same memory as whole numbers of 64 bits."""
    for k in range(values.real.size):
        row[begin + k] = values.real[k]
    for i in range(wide.size):
        words[begin + wide[i]] = values.word[wide[i]]


@njit(inline="always")
def record_outputs(plan, row, words):  # type: ignore[no-untyped-def]
    """Record outputs and the energies into the structures."""
    put(row, words, 0, Values(plan.y, plan.y_word), plan.wide)
    for e in range(plan.energy.shape[0]):
        row[plan.y.size + e] = plan.energy[e, 1]


@kept()
def advance(plan, clock, first, steps, every, record):  # type: ignore[no-untyped-def]
    """Make `steps` steps and record every `every`-th and the last of all, also the last that was made before a fault.

    Parameters
    ----------
    plan : Plan
    clock : (start time of the run [s], step [s], number of steps of the run, its stop time [s])
    first : number of steps made before
    steps : number of steps to make
    every : record after each step whose number is a multiple of this, and after the last one
    record : (rows, outputs + bonds) array that takes the outputs and the energies into the structures, and the same
        memory as integers, which takes the whole numbers of 64 bits

    Returns
    -------
    done, rows : numbers of steps made and of rows recorded
    what, where, status : what went wrong (OK, SET, STEP, ...), where (a component; for NOT_FINITE the position in `y`,
        for NOT_CONVERGED that in `u`), FMI status
    """
    plan = borrowed(plan)  # type: ignore[call-arg]
    rows = kept = 0  # `kept`: 1 if the row after those recorded holds the latest step, in case that the next one fails
    remember_motion(plan)
    for k in range(steps):
        what, component, status = _step(plan, first + k, clock)
        if what != OK:
            return k, rows + kept, what, component, status
        count_energy(plan, first + k, clock[1])
        for j in range(plan.y.size):
            if not np.isfinite(plan.y[j]):
                return k, rows + kept, NOT_FINITE, j, 0
        number = first + k + 1
        record_outputs(plan, record[0][rows], record[1][rows])
        kept = 1
        if number % every == 0 or number == clock[2] or plan.ending[0] >= 0:
            rows, kept = rows + 1, 0
        if plan.ending[0] >= 0:
            return k + 1, rows, STEP, plan.ending[0], ENDED
    return steps, rows, OK, 0, 0
