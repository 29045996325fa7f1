"""FMI functions by address for compiled code, and values as the functions lay them out in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.extending import intrinsic

LAYOUTS = tuple(
    np.dtype(name)
    for name in (
        "float64", "float32", "int32", "int64", "bool", "int8", "uint8", "int16", "uint16", "uint32", "uint64",
    )
)  # fmt: skip
"""Data types of values, by the number that stands for them in a plan. Doubles, the first, are passed as they are."""

_WORD, _DOUBLE, _INT = cgutils.intp_t, ir.DoubleType(), ir.IntType(32)


def _call(builder: Any, arguments: Any, parameters: list[Any]) -> Any:
    """Call the function at address `arguments[0]` with the other arguments; it returns a status."""
    pointer = builder.inttoptr(arguments[0], ir.FunctionType(_INT, parameters).as_pointer())
    return builder.call(pointer, list(arguments[1:]))


@intrinsic
def call_values_2(typing_context, address, handle, references, count, values):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call an fmi2SetXXX or fmi2GetXXX; return its status."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments, [_WORD] * 4)

    return types.int32(*[types.intp] * 5), generate


@intrinsic
def call_values_3(typing_context, address, handle, references, count, values, size):  # type: ignore[no-untyped-def]  # noqa: ARG001, PLR0913, PLR0917
    """Call an fmi3SetXXX or fmi3GetXXX; return its status."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments, [_WORD] * 5)

    return types.int32(*[types.intp] * 6), generate


@intrinsic
def call_step_2(typing_context, address, handle, time, step, final):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call fmi2DoStep; return its status. `final`: 1 if the state before will not be set again."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments, [_WORD, _DOUBLE, _DOUBLE, _INT])

    return types.int32(types.intp, types.intp, types.float64, types.float64, types.int32), generate


@intrinsic
def call_step_3(typing_context, address, handle, time, step, final, answer):  # type: ignore[no-untyped-def]  # noqa: ARG001, PLR0913, PLR0917
    """Call fmi3DoStep; return its status. `answer`: 16 bytes for event, terminate and early return, and the time."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        *before, answer = arguments
        flags = [builder.add(answer, ir.Constant(_WORD, k)) for k in (0, 1, 2)]
        time = builder.add(answer, ir.Constant(_WORD, 8))
        return _call(builder, [*before, *flags, time], [_WORD, _DOUBLE, _DOUBLE, _INT, *[_WORD] * 4])

    return types.int32(types.intp, types.intp, types.float64, types.float64, types.int32, types.intp), generate


@intrinsic
def call_state(typing_context, address, handle, argument):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call a function that gets the state (`argument`: address of the pointer) or sets it (the pointer)."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments, [_WORD] * 2)

    return types.int32(*[types.intp] * 3), generate


@njit(cache=True)
def pack(layout, memory, values):  # type: ignore[no-untyped-def]
    """Write doubles into `memory` (uint64 words) in another layout; whole numbers are rounded to."""
    n = values.size
    if layout == 1:
        memory.view(np.float32)[:n] = values
    elif layout == 2:
        memory.view(np.int32)[:n] = np.rint(values)
    elif layout == 3:
        memory.view(np.int64)[:n] = np.rint(values)
    elif layout == 4:
        memory.view(np.uint8)[:n] = values != 0.0
    elif layout == 5:
        memory.view(np.int8)[:n] = np.rint(values)
    elif layout == 6:
        memory.view(np.uint8)[:n] = np.rint(values)
    elif layout == 7:
        memory.view(np.int16)[:n] = np.rint(values)
    elif layout == 8:
        memory.view(np.uint16)[:n] = np.rint(values)
    elif layout == 9:
        memory.view(np.uint32)[:n] = np.rint(values)
    else:
        memory[:n] = np.rint(values)


@njit(cache=True)
def unpack(layout, memory, values):  # type: ignore[no-untyped-def]
    """Read values in a layout from `memory` (uint64 words) as doubles."""
    n = values.size
    if layout == 1:
        values[:] = memory.view(np.float32)[:n]
    elif layout == 2:
        values[:] = memory.view(np.int32)[:n]
    elif layout == 3:
        values[:] = memory.view(np.int64)[:n]
    elif layout in (4, 6):
        values[:] = memory.view(np.uint8)[:n]
    elif layout == 5:
        values[:] = memory.view(np.int8)[:n]
    elif layout == 7:
        values[:] = memory.view(np.int16)[:n]
    elif layout == 8:
        values[:] = memory.view(np.uint16)[:n]
    elif layout == 9:
        values[:] = memory.view(np.uint32)[:n]
    else:
        values[:] = memory[:n]
