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
from pathlib import Path
from typing import Any

Kernel = Callable[..., Any]

HAS_NUMBA = find_spec("numba") is not None


def kernel(function: Kernel) -> Kernel:
    """Compile `function` with Numba if it is installed; else (a host without Numba) return it as it is."""
    if not HAS_NUMBA:
        return function
    return compiled(function, _cache_folder(function.__module__), error_model="numpy")


def compiled(function: Kernel, folder: str, **options: Any) -> Kernel:
    """Compile `function` with Numba and keep the machine code in `folder`, where that can be written.

    Parameters
    ----------
    folder : named by a hash of all sources that `function` is made of; "" for Numba's default, beside the source
    options : of `numba.njit`
    """
    import numba  # noqa: PLC0415 - optional

    from .machine_code import check_files  # noqa: PLC0415 - needs numba

    config: Any = numba.config
    before = config.CACHE_DIR
    made: Kernel
    try:
        config.CACHE_DIR = folder
        made = numba.njit(cache=True, **options)(function)
        check_files(made)
    except RuntimeError:  # nowhere to keep the compiled code, such as an FMU unpacked to a read-only place
        made = numba.njit(**options)(function)
    finally:
        config.CACHE_DIR = before
    return made


@cache
def _cache_folder(module: str) -> str:
    """Return where the compiled kernels of a module are kept; "" for Numba's default, beside the source.

    Numba looks for changes in the file of a kernel only, not in those of the kernels that it calls. So the name of the
    folder carries a hash of all that the module imports of this package. An FMU has such a name already.
    """
    if __package__ != "fmus":
        return ""
    from fmus.sources import PACKAGE, files_of  # noqa: PLC0415 - not there in an FMU

    if module.startswith("fmus."):
        return kept_under(PACKAGE / name for name in files_of(module.removeprefix("fmus.")))
    return kept_under(sorted(PACKAGE.rglob("*.py")))  # of another package: it may use any of this one


def kept_under(files: Iterable[Path]) -> str:
    """Return the folder for machine code that is made of these files."""
    from fmus.cache import cache_folder, mark_used  # noqa: PLC0415 - not there in an FMU

    digest = hashlib.sha256()
    for path in (*files, Path(__file__), Path(__file__).with_name("machine_code.py")):
        digest.update(path.read_bytes())
    folder = cache_folder("kernels") / digest.hexdigest()[:16]
    mark_used(folder)
    return str(folder)


def positions(title: str, names: Iterable[str]) -> Any:
    """Return a named tuple that maps each name to its position, as kernels read it: a compile-time constant.

    >>> positions("Example", ["mass", "stiffness"]).stiffness
    1
    """
    fields = tuple(names)
    return namedtuple(title, fields)(*range(len(fields)))
