"""Which Python files a module of this package needs: its own and all that it imports of the package."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parent

RELATIVE_IMPORT = re.compile(r"^[ \t]*from (\.+)([\w.]*) import (?:\(([^)]*)\)|([^\n]*))", re.MULTILINE)
"""Dots, module, names in parentheses or up to the end of the line; a syntax tree of every file costs 0.1 s a start."""


def files_of(module: str) -> list[str]:
    """Return the file of a module of this package and of all that it imports of it, relative to the package, sorted.

    >>> files_of("interface")
    ['interface.py']
    """
    found: set[str] = set()
    waiting = [module.replace(".", "/") + ".py"]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += _imported(name)
    folders = {folder for name in found for folder in Path(name).parents} - {Path()}
    return sorted(found | {f"{folder.as_posix()}/__init__.py" for folder in folders})


@cache
def _imported(name: str) -> list[str]:
    """Return the files of this package that a file imports, by relative imports, which is all it has."""
    files = []
    for dots, module, several, one in RELATIVE_IMPORT.findall((PACKAGE / name).read_text(encoding="utf-8")):
        folder = Path(name).parents[len(dots) - 1]
        found = folder.joinpath(*module.split(".")) if module else folder
        names = [part.split()[0] for part in (several or one.partition("#")[0]).split(",") if part.split()]
        for candidate in (found.with_suffix(".py"), *(found / f"{each}.py" for each in names)):
            if (PACKAGE / candidate).is_file():
                files.append(candidate.as_posix())
    return files
