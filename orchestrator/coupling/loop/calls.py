"""FMI functions by address for compiled code, and values as the functions lay them out in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import carray, types  # type: ignore[attr-defined]
from numba.core import cgutils
from numba.extending import intrinsic

from .compiled import kept

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


@kept()
def flag(answer, number):  # type: ignore[no-untyped-def]
    """Return a flag of the answer to a step of FMI 3.0: event, end of the simulation, early return."""
    return carray(_pointer(answer), 3, np.uint8)[number] != 0  # type: ignore[call-arg]


# A value stands in a plan as a double and, where it is a whole number, as an integer of 64 bits besides: doubles hold
# whole numbers up to 2^53 only.


_LOWEST = np.array([-(2**63)] * 2 + [np.iinfo(k).min if k.kind in "iu" else -(2**63) for k in LAYOUTS[2:]], np.int64)
_HIGHEST = np.array(
    [2**63 - 1] * 2 + [min(np.iinfo(k).max, 2**63 - 1) if k.kind in "iu" else 2**63 - 1 for k in LAYOUTS[2:]]
)
"""Whole numbers that a layout holds; those of 64 bits without sign stand in a plan bit by bit."""
_LOWEST[-1] = -(2**63)


@kept()
def pack(layout, memory, k, value, word):  # type: ignore[no-untyped-def]
    """Write a value as element `k` at address `memory` in a layout; return whether it fits in there.

    Parameters
    ----------
    value, word : the value as a double, and as a whole number for a layout of whole numbers
    """
    place = _pointer(memory)  # type: ignore[call-arg, var-annotated]
    if layout == 0:
        carray(place, k + 1, np.float64)[k] = value
    elif layout == 1:
        carray(place, k + 1, np.float32)[k] = value
    elif layout == 4:
        carray(place, k + 1, np.uint8)[k] = word != 0
    elif layout in (5, 6):
        carray(place, k + 1, np.int8)[k] = word
    elif layout in (7, 8):
        carray(place, k + 1, np.int16)[k] = word
    elif layout in (2, 9):
        carray(place, k + 1, np.int32)[k] = word
    else:
        carray(place, k + 1, np.int64)[k] = word
    if layout == 10 or (layout > 1 and word < 0 < value):  # bit by bit
        return value >= 0.0 and layout == 10
    return _LOWEST[layout] <= word <= _HIGHEST[layout]


@kept()
def unpack(layout, memory, k):  # type: ignore[no-untyped-def]
    """Return element `k` at address `memory` in a layout, as a double and as a whole number (0 if it is none)."""
    place = _pointer(memory)  # type: ignore[call-arg, var-annotated]
    if layout == 0:
        return carray(place, k + 1, np.float64)[k], np.int64(0)
    if layout == 1:
        return np.float64(carray(place, k + 1, np.float32)[k]), np.int64(0)
    word = _whole(layout, place, k)
    return np.float64(np.uint64(word)) if layout == 10 else np.float64(word), word


@kept()
def _whole(layout, place, k):  # type: ignore[no-untyped-def]
    """Return a whole number, one of 64 bits without sign bit by bit."""
    if layout == 2:
        return np.int64(carray(place, k + 1, np.int32)[k])
    if layout == 4:
        return np.int64(carray(place, k + 1, np.uint8)[k] != 0)
    if layout == 5:
        return np.int64(carray(place, k + 1, np.int8)[k])
    if layout in (6, 7, 8, 9):
        return _short(layout, place, k)
    return carray(place, k + 1, np.int64)[k]


@kept()
def _short(layout, place, k):  # type: ignore[no-untyped-def]
    if layout == 6:
        return np.int64(carray(place, k + 1, np.uint8)[k])
    if layout == 7:
        return np.int64(carray(place, k + 1, np.int16)[k])
    if layout == 8:
        return np.int64(carray(place, k + 1, np.uint16)[k])
    return np.int64(carray(place, k + 1, np.uint32)[k])
