"""The one decorator that turns a plain Python function into a compiled kernel.

A kernel reads and writes flat float arrays and calls only `math` and other kernels, so that the same text runs in
plain Python, is compiled by Numba in this process, and can be lowered to an object file for a native FMU.
"""

from __future__ import annotations

import hashlib
from collections import namedtuple
from collections.abc import Callable, Iterable
from functools import cache
from importlib.util import find_spec
from typing import Any

Kernel = Callable[..., Any]

HAS_NUMBA = find_spec("numba") is not None


def kernel(function: Kernel) -> Kernel:
    """Compile `function` with Numba if it is installed; else (a host without Numba) return it as it is."""
    if not HAS_NUMBA:
        return function
    import numba  # noqa: PLC0415 - optional

    config: Any = numba.config
    before = config.CACHE_DIR
    compiled: Kernel
    try:
        config.CACHE_DIR = _cache_folder(function.__module__)
        compiled = numba.njit(cache=True, error_model="numpy")(function)
    except RuntimeError:  # nowhere to keep the compiled code, such as an FMU unpacked to a read-only place
        compiled = numba.njit(error_model="numpy")(function)
    finally:
        config.CACHE_DIR = before
    return compiled


@cache
def _cache_folder(module: str) -> str:
    """Return where the compiled kernels of a module are kept; "" for Numba's default, beside the source.

    Numba looks for changes in the file of a kernel only, not in those of the kernels that it calls. So the name of the
    folder carries a hash of all that the module imports of this package. An FMU has such a name already.
    """
    if __package__ != "fmus":
        return ""
    from platformdirs import user_cache_path  # noqa: PLC0415 - not there in an FMU

    from fmus.sources import PACKAGE, files_of  # noqa: PLC0415 - not there in an FMU

    own = module.startswith("fmus.")
    files = files_of(module.removeprefix("fmus.")) if own else sorted(map(str, PACKAGE.rglob("*.py")))
    digest = hashlib.sha256()
    for name in files:
        digest.update((PACKAGE / name).read_bytes())
    return str(user_cache_path("curvesqueal") / "kernels" / digest.hexdigest()[:16])


def positions(title: str, names: Iterable[str]) -> Any:
    """Return a named tuple that maps each name to its position, as kernels read it: a compile-time constant.

    >>> positions("Example", ["mass", "stiffness"]).stiffness
    1
    """
    fields = tuple(names)
    return namedtuple(title, fields)(*range(len(fields)))
