"""FMI functions by address for compiled code, and values as the functions lay them out in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import carray, njit, types  # type: ignore[attr-defined]
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


@intrinsic
def _pointer(typing_context, address):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Return an address as a pointer."""

    def generate(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], cgutils.voidptr_t)

    return types.voidptr(types.intp), generate


# Plain addresses, not arrays: passing arrays on counts references, which costs more than a call of an FMU.


@intrinsic
def borrowed(typing_context, arrays):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Return a tuple of arrays as one that owns none of them, so that using it counts no references.

    Counting costs more than calling an FMU. The caller keeps the arrays alive.
    """

    def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        def bare(kind: Any, value: Any) -> Any:
            if isinstance(kind, types.Array):
                array = context.make_array(kind)(context, builder, value)
                array.meminfo = array.parent = ir.Constant(cgutils.voidptr_t, None)
                return array._getvalue()
            for i, each in enumerate(kind.types):
                value = builder.insert_value(value, bare(each, builder.extract_value(value, i)), i)
            return value

        return bare(arrays, arguments[0])

    return arrays(arrays), generate


@njit(cache=True)
def asks_to_end(answer):  # type: ignore[no-untyped-def]
    """Return whether the answer to a step of FMI 3.0 has the flag that asks to end the simulation."""
    return carray(_pointer(answer), 3, np.uint8)[1] != 0  # type: ignore[call-arg]


@njit(cache=True)
def pack(layout, memory, values, n):  # type: ignore[no-untyped-def]
    """Write `n` doubles at address `values` to address `memory` in another layout; whole numbers are rounded to."""
    doubles = carray(_pointer(values), n, np.float64)  # type: ignore[call-arg]
    target = _pointer(memory)
    if layout == 1:
        carray(target, n, np.float32)[:] = doubles
    elif layout == 2:
        carray(target, n, np.int32)[:] = np.rint(doubles)
    elif layout == 3:
        carray(target, n, np.int64)[:] = np.rint(doubles)
    elif layout == 4:
        carray(target, n, np.uint8)[:] = doubles != 0.0
    elif layout == 5:
        carray(target, n, np.int8)[:] = np.rint(doubles)
    elif layout == 6:
        carray(target, n, np.uint8)[:] = np.rint(doubles)
    elif layout == 7:
        carray(target, n, np.int16)[:] = np.rint(doubles)
    elif layout == 8:
        carray(target, n, np.uint16)[:] = np.rint(doubles)
    elif layout == 9:
        carray(target, n, np.uint32)[:] = np.rint(doubles)
    else:
        carray(target, n, np.uint64)[:] = np.rint(doubles)


@njit(cache=True)
def unpack(layout, memory, values, n):  # type: ignore[no-untyped-def]
    """Read `n` values in a layout at address `memory` as doubles to address `values`."""
    doubles = carray(_pointer(values), n, np.float64)  # type: ignore[call-arg]
    source = _pointer(memory)
    if layout == 1:
        doubles[:] = carray(source, n, np.float32)
    elif layout == 2:
        doubles[:] = carray(source, n, np.int32)
    elif layout == 3:
        doubles[:] = carray(source, n, np.int64)
    elif layout in (4, 6):
        doubles[:] = carray(source, n, np.uint8)
    elif layout == 5:
        doubles[:] = carray(source, n, np.int8)
    elif layout == 7:
        doubles[:] = carray(source, n, np.int16)
    elif layout == 8:
        doubles[:] = carray(source, n, np.uint16)
    elif layout == 9:
        doubles[:] = carray(source, n, np.uint32)
    else:
        doubles[:] = carray(source, n, np.uint64)
