"""The one decorator that turns a plain Python function into a compiled kernel.

A kernel reads and writes flat float arrays and calls only `math` and other kernels, so that the same text runs in
plain Python, is compiled by Numba in this process, and can be lowered to an object file for a native FMU.
"""

from collections import namedtuple
from collections.abc import Callable, Iterable
from importlib.util import find_spec
from typing import Any

Kernel = Callable[..., Any]

HAS_NUMBA = find_spec("numba") is not None


def kernel(function: Kernel) -> Kernel:
    """Compile `function` with Numba if it is installed; else (a host without Numba) return it as it is."""
    if not HAS_NUMBA:
        return function
    import numba  # noqa: PLC0415 - optional

    compiled: Kernel
    try:
        compiled = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # nowhere to keep the compiled code, such as an FMU unpacked to a read-only place
        compiled = numba.njit(error_model="numpy")(function)
    return compiled


def positions(title: str, names: Iterable[str]) -> Any:
    """Return a named tuple that maps each name to its position, as kernels read it: a compile-time constant.

    >>> positions("Example", ["mass", "stiffness"]).stiffness
    1
    """
    fields = tuple(names)
    return namedtuple(title, fields)(*range(len(fields)))
