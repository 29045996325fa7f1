"""Which Python files a module of this package needs: its own and all that it imports of the package."""

from __future__ import annotations

import ast
from pathlib import Path

from ..component import Component

PACKAGE = Path(__file__).parents[1]


def kernel_files(component: Component) -> list[str]:
    """Return the files of a component's kernels, relative to the package, sorted."""
    return files_of(component.kernels)


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


def _imported(name: str) -> list[str]:
    """Return the files of this package that a file imports, by relative imports, which is all it has."""
    files = []
    for node in ast.walk(ast.parse((PACKAGE / name).read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            folder = Path(name).parents[node.level - 1]
            module = folder.joinpath(*(node.module or "").split("."))
            for candidate in (module.with_suffix(".py"), *(module / f"{alias.name}.py" for alias in node.names)):
                if (PACKAGE / candidate).is_file():
                    files.append(candidate.as_posix())
    return files
