"""What the values of kernels are in C: their types, and how C writes them. No Python source, no files."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, Union

import numpy as np

Type: TypeAlias = Union[str, tuple["Type", ...]]  # noqa: UP007 - refers to itself
"""One of the names below, or a tuple of types."""

TRUTH, WHOLE, REAL, ARRAY, NOTHING = "bool", "int64_t", "double", "Array", "void"
NUMBERS = (TRUTH, WHOLE, REAL)
"""Types of numbers, each one a part of the next."""

ATOM = 9
"""How tightly a name, a call or a literal binds; see `Value`."""

PRELUDE = """#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* A place in memory and a length. */
typedef struct { double *at; int64_t size; } Array;

static inline Array piece(Array a, int64_t begin, int64_t end) { return (Array){a.at + begin, end - begin}; }
static inline double min_real(double a, double b) { return b < a ? b : a; }
static inline double max_real(double a, double b) { return b > a ? b : a; }
static inline int64_t min_whole(int64_t a, int64_t b) { return b < a ? b : a; }
static inline int64_t max_whole(int64_t a, int64_t b) { return b > a ? b : a; }
static inline int64_t abs_whole(int64_t a) { return a < 0 ? -a : a; }
static inline int64_t floor_div(int64_t a, int64_t b) { return a / b - (a % b != 0 && (a < 0) != (b < 0)); }
static inline int64_t modulo(int64_t a, int64_t b) { return a - b * floor_div(a, b); }
"""


@dataclass(frozen=True)
class Value:
    """An expression in C.

    Attributes
    ----------
    type : Type
    text : the expression
    level : how tightly its outermost operator binds, `ATOM` for none
    known : its value in Python, if it is a constant
    """

    type: Type
    text: str
    level: int = ATOM
    known: Any = None

    def within(self, level: int) -> str:
        """Return the expression as an operand of an operator that binds with `level`."""
        return self.text if self.level >= level else f"({self.text})"


@dataclass(frozen=True)
class Function:
    """A kernel in C for certain types of its arguments.

    Attributes
    ----------
    name : in C
    parameters : types of the parameters
    result : type of what it returns
    text : its definition
    calls : the functions that it calls
    """

    name: str
    parameters: tuple[Type, ...]
    result: Type
    text: str
    calls: tuple[Function, ...]


def join(a: Type, b: Type) -> Type | None:
    """Return the type that holds values of both types; None if there is none."""
    if isinstance(a, tuple) and isinstance(b, tuple) and len(a) == len(b):
        parts = tuple(part for x, y in zip(a, b, strict=True) if (part := join(x, y)) is not None)
        return parts if len(parts) == len(a) else None
    if isinstance(a, str) and isinstance(b, str) and {a, b} <= set(NUMBERS):
        return max(a, b, key=NUMBERS.index)
    return a if a == b else None


def name_of(kind: Type) -> str:
    """Return what C calls a type."""
    return kind if isinstance(kind, str) else f"Tuple_{_letters(kind)}"


def _letters(kind: Type) -> str:
    if isinstance(kind, str):
        return {TRUTH: "b", WHOLE: "i", REAL: "d", ARRAY: "a"}[kind]
    return f"{_letters(kind[0])}x{len(kind)}" if is_uniform(kind) else f"o{'_'.join(map(_letters, kind))}c"


def is_uniform(kind: tuple[Type, ...]) -> bool:
    """Return whether all items have one type; such a tuple can be indexed by a variable."""
    return len(set(kind)) == 1


def definition(kind: tuple[Type, ...]) -> str:
    """Return the definition of a tuple's type."""
    if is_uniform(kind):
        body = f"{name_of(kind[0])} at[{len(kind)}];"
    else:
        body = " ".join(f"{name_of(item)} item{k};" for k, item in enumerate(kind))
    return f"typedef struct {{ {body} }} {name_of(kind)};"


def member(value: Value, k: int) -> Value:
    """Return item `k` of a tuple that is a name."""
    kind, known = value.type, value.known
    place = f"at[{k}]" if isinstance(kind, tuple) and is_uniform(kind) else f"item{k}"
    return Value(kind[k], f"{value.text}.{place}", known=known[k] if isinstance(known, tuple) else None)


def pack(items: Sequence[str], kind: tuple[Type, ...]) -> str:
    """Return a tuple of its items."""
    body = "{" + ", ".join(items) + "}"
    return f"({name_of(kind)}){{{body}}}" if is_uniform(kind) else f"({name_of(kind)}){body}"


def literal(value: Any) -> Value:
    """Return a number as C has it, without loss."""
    if isinstance(value, bool | np.bool_):
        return Value(TRUTH, str(bool(value)).lower(), known=bool(value))
    if isinstance(value, int | np.integer):
        return Value(WHOLE, str(value) if value >= 0 else f"({value})", known=int(value))
    size = repr(abs(float(value))) if math.isfinite(value) else "NAN" if math.isnan(value) else "INFINITY"
    return Value(REAL, size if math.copysign(1.0, value) > 0 else f"(-{size})", known=float(value))


def table(values: Any) -> str:
    """Return the initialiser of a constant tuple or table of numbers."""
    return "{" + ", ".join(map(table, values)) + "}" if isinstance(values, tuple | list) else literal(values).text


def type_of(value: Any) -> Type | None:
    """Return the type of a constant; None if it has none in C."""
    if isinstance(value, tuple):
        parts = tuple(part for item in value if (part := type_of(item)) is not None)
        return parts if len(parts) == len(value) > 0 else None
    return literal(value).type if isinstance(value, bool | int | float | np.number | np.bool_) else None
