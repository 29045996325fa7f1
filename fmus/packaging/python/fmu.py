"""A component in, an FMU with a Python body out: PythonFMU does the work, this module makes it portable.

PythonFMU lets all FMUs of a process share one `sys.modules`. Everything inside an FMU therefore has a name with a hash
of its content: two FMUs, or two versions of one, never see each other's modules.
"""

from __future__ import annotations

import hashlib
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from pythonfmu.builder import FmuBuilder

from ...component import Component
from ...sources import PACKAGE, files_of
from ..archive import write_archive
from ..description.documentation import documentation_files
from ..description.terminals import terminal_files

SLAVE = "packaging.python.slave"
"""The module that every FMU runs."""

SCRIPT = '''"""Entry point that PythonFMU looks for."""

from {package}.declaration import DECLARATION
from {package}.packaging.python.slave import ComponentSlave, hold

hold(globals())


class {name}(ComponentSlave):
    """The slave."""

    declaration = DECLARATION
    release = "{version}"
    content = "{content}"
'''


def build_python_fmu(component: Component, file: Path, version: str) -> Path:
    """Write the FMU `file` of a component; the same input gives the same bytes.

    Parameters
    ----------
    component : Component
    file : where the FMU goes; its folder must exist
    version : version of the project, written into the model description
    """
    sources = {
        name: (PACKAGE / name).read_bytes()
        for name in sorted({"__init__.py", *files_of(SLAVE), *files_of(component.kernels)})
    }
    sources["declaration.py"] = f"DECLARATION = {component.to_json()!r}\n".encode()
    digest = hashlib.sha256()
    for name, data in sorted(sources.items()):
        digest.update(f"{name} {len(data)} ".encode() + data)
    content = digest.hexdigest()[:16]
    package = f"curvesqueal_{component.name}_{content}"
    with tempfile.TemporaryDirectory(prefix="curvesqueal_") as folder:
        for name, data in sources.items():
            target = Path(folder) / package / name
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        script = Path(folder) / f"slave_{component.name}_{content}.py"
        text = SCRIPT.format(package=package, name=component.name, version=version, content=content)
        script.write_text(text, encoding="utf-8")
        with _own_modules(Path(folder)):
            raw = FmuBuilder.build_FMU(
                script, dest=Path(folder) / "raw.fmu", project_files=[Path(folder) / package], needsExecutionTool=False
            )
        write_archive(
            raw, file, {**documentation_files(component, version, python=True), **terminal_files(component, 2)}
        )
    return file


@contextmanager
def _own_modules(folder: Path) -> Iterator[None]:
    """Undo what PythonFMU's builder does to the import system, and leave no byte code behind."""
    path, modules, write = list(sys.path), set(sys.modules), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    try:
        yield
    finally:
        sys.dont_write_bytecode = write
        sys.path[:] = path
        for name in set(sys.modules) - modules:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(str(folder)):
                del sys.modules[name]
        for cache in folder.rglob("__pycache__"):
            shutil.rmtree(cache, ignore_errors=True)
