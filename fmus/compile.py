"""The one decorator that turns a plain Python function into a compiled kernel.

A kernel reads and writes flat float arrays and calls only `math` and other kernels, so that the same text runs in
plain Python, is compiled by Numba in this process, and can be lowered to an object file for a native FMU.
"""

from collections.abc import Callable
from typing import Any

try:
    import numba
except ImportError:  # an FMU in a host without Numba: slower, same numbers
    numba = None

Kernel = Callable[..., Any]


def kernel(function: Kernel) -> Kernel:
    """Compile `function` with Numba if it is installed, else return it as it is."""
    if numba is None:
        return function
    compiled: Kernel = numba.njit(cache=True, error_model="numpy")(function)
    return compiled
