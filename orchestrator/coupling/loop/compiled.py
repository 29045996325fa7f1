"""How the functions of the loop are compiled, and where their machine code is kept.

Numba looks for changes in the file of a function only: with its own cache, a function of `recorded` would go on with
what `steps` was before. So the folder has the name of all files of the loop.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from fmus.compile import compiled, kept_under


def kept(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return the decorator that compiles a function of the loop, with options of `numba.njit`."""
    return lambda function: compiled(function, _folder(), **options)


@cache
def _folder() -> str:
    return kept_under(sorted(Path(__file__).parent.glob("*.py")))
