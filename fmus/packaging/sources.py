"""Which Python files the kernels of a component come from: their module and all that it imports of this package."""

from __future__ import annotations

import ast
from pathlib import Path

from ..component import Component

PACKAGE = Path(__file__).parents[1]


def kernel_files(component: Component) -> list[str]:
    """Return the files, relative to the package, sorted."""
    found: set[str] = set()
    waiting = [component.kernels.replace(".", "/") + ".py"]
    while waiting:
        name = waiting.pop()
        if name not in found:
            found.add(name)
            waiting += _imported(name)
    folders = {Path(name).parent for name in found} - {Path()}
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
