"""The compiled co-simulation loop: index arrays and function addresses in, outputs out. No files, no FMPy, no names.

Numba calls the FMI functions by address, so a step costs no Python. What happens in a step is data: a list of stages,
each a list of components. In a stage every component first gets its inputs from the latest outputs, then all make
their step, then all give their outputs. One stage with everybody is the Jacobi scheme; structures first and the
contact second is the staggered scheme.
"""

from __future__ import annotations

from collections import namedtuple
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

OK, SET, STEP, GET, NOT_FINITE = range(5)
"""What `advance` was doing when it stopped: nothing wrong, setting inputs, stepping, getting outputs, checking."""

Plan = namedtuple(
    "Plan",
    [
        "stage_begin",  # (stages + 1,) positions in `order`
        "order",  # (components,) components, stage by stage
        "handle",  # (components,) fmi2Component pointers
        "set_real",  # (components,) addresses of fmi2SetReal
        "get_real",  # (components,) addresses of fmi2GetReal
        "do_step",  # (components,) addresses of fmi2DoStep
        "input_begin",  # (components + 1,) positions in `u`
        "output_begin",  # (components + 1,) positions in `y`
        "input_reference",  # (inputs,) value references, uint32
        "output_reference",  # (outputs,) value references, uint32
        "u",  # (inputs,) values that the components hold
        "y",  # (outputs,) latest outputs
        "source",  # (inputs,) position in `y` of what feeds an input
        "gain",  # (inputs,) factor of the connection
        "offset",  # (inputs,) offset of the connection
        "bond_force",  # (bonds,) positions in `u` of forces on structures
        "bond_velocity",  # (bonds,) positions in `y` of the velocities that belong to them
        "bond_row",  # (bonds,) row of `energy` that a bond counts in
        "energy",  # (rows, 2) energy residual and energy into the structures [J]
    ],
)
"""Everything that the loop reads and writes, resolved to indices before the run."""


@intrinsic
def _call_reals(typing_context, address, handle, references, count, values):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call fmi2SetReal or fmi2GetReal at `address`; return its status."""
    signature = types.int32(types.intp, types.intp, types.intp, types.intp, types.intp)

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:  # noqa: ARG001
        word = cgutils.intp_t
        function_type = ir.FunctionType(ir.IntType(32), [word, word, word, word])
        pointer = builder.inttoptr(arguments[0], function_type.as_pointer())
        return builder.call(pointer, list(arguments[1:]))

    return signature, generate


@intrinsic
def _call_step(typing_context, address, handle, time, step):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call fmi2DoStep at `address`; return its status."""
    signature = types.int32(types.intp, types.intp, types.float64, types.float64)

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:  # noqa: ARG001
        word = cgutils.intp_t
        function_type = ir.FunctionType(ir.IntType(32), [word, ir.DoubleType(), ir.DoubleType(), ir.IntType(32)])
        pointer = builder.inttoptr(arguments[0], function_type.as_pointer())
        return builder.call(pointer, [*arguments[1:], ir.Constant(ir.IntType(32), 1)])

    return signature, generate


@njit(cache=True)
def _set_inputs(plan, c):  # type: ignore[no-untyped-def]
    """Bring the inputs of component `c` up to date with the latest outputs and set them; return the FMI status."""
    begin = plan.input_begin[c]
    end = plan.input_begin[c + 1]
    if begin == end:
        return 0
    for i in range(begin, end):
        plan.u[i] = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
    references = plan.input_reference.ctypes.data + 4 * begin
    values = plan.u.ctypes.data + 8 * begin
    return _call_reals(plan.set_real[c], plan.handle[c], references, end - begin, values)  # type: ignore[call-arg]


@njit(cache=True)
def _get_outputs(plan, c):  # type: ignore[no-untyped-def]
    """Get the outputs of component `c`; return the FMI status."""
    begin = plan.output_begin[c]
    end = plan.output_begin[c + 1]
    if begin == end:
        return 0
    references = plan.output_reference.ctypes.data + 4 * begin
    values = plan.y.ctypes.data + 8 * begin
    return _call_reals(plan.get_real[c], plan.handle[c], references, end - begin, values)  # type: ignore[call-arg]


@njit(cache=True)
def _step(plan, time, h):  # type: ignore[no-untyped-def]
    """Advance all components by one step; return what was done last, by which component, and the FMI status."""
    for s in range(plan.stage_begin.size - 1):
        begin = plan.stage_begin[s]
        end = plan.stage_begin[s + 1]
        for k in range(begin, end):
            c = plan.order[k]
            status = _set_inputs(plan, c)
            if status > 1:
                return SET, c, status
        for k in range(begin, end):
            c = plan.order[k]
            status = _call_step(plan.do_step[c], plan.handle[c], time, h)  # type: ignore[call-arg]
            if status > 1:
                return STEP, c, status
        for k in range(begin, end):
            c = plan.order[k]
            status = _get_outputs(plan, c)
            if status > 1:
                return GET, c, status
    return OK, 0, 0


@njit(cache=True)
def _count_energy(plan, h):  # type: ignore[no-untyped-def]
    """Add the step's energy: residual h (F_new - F_held) v, and h F_held v into the structure."""
    for b in range(plan.bond_force.size):
        i = plan.bond_force[b]
        velocity = plan.y[plan.bond_velocity[b]]
        new = plan.gain[i] * plan.y[plan.source[i]] + plan.offset[i]
        plan.energy[plan.bond_row[b], 0] += h * (new - plan.u[i]) * velocity
        plan.energy[plan.bond_row[b], 1] += h * plan.u[i] * velocity


@njit(cache=True)
def advance(plan, clock, steps, every, record):  # type: ignore[no-untyped-def]
    """Make `steps` steps and record every `every`-th.

    Parameters
    ----------
    plan : Plan
    clock : (start time of the run [s], step [s], number of steps made before)
    steps : number of steps to make
    every : record after each step whose number is a multiple of this
    record : (rows, outputs + energy rows) array that takes the outputs and the energy residuals

    Returns
    -------
    done, rows : numbers of steps made and of rows recorded
    what, component, status : what went wrong (OK, SET, STEP, GET, NOT_FINITE), where (a component, or for NOT_FINITE
        the position in `y`), FMI status
    """
    start, h, first = clock
    rows = 0
    outputs = plan.y.size
    for k in range(steps):
        what, component, status = _step(plan, start + (first + k) * h, h)
        if what != OK:
            return k, rows, what, component, status
        _count_energy(plan, h)
        for j in range(outputs):
            if not np.isfinite(plan.y[j]):
                return k, rows, NOT_FINITE, j, 0
        if (first + k + 1) % every == 0:
            record[rows, :outputs] = plan.y
            for e in range(plan.energy.shape[0]):
                record[rows, outputs + e] = plan.energy[e, 0]
            rows += 1
    return steps, rows, OK, 0, 0
