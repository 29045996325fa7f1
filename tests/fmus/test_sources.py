"""Which files a kernel depends on: the import system's own answer."""

from __future__ import annotations

import subprocess
import sys

import pytest

from fmus.sources import PACKAGE, files_of

IMPORTED = """
import sys, {module}, pathlib
for m in sorted(sys.modules):
    if m.split('.')[0] == 'fmus' and getattr(sys.modules[m], '__file__', None):
        print(pathlib.Path(sys.modules[m].__file__).relative_to({package!r}).as_posix())
"""


@pytest.mark.parametrize("module", ["contact.kernels", "modal.kernels"])
def test_the_files_are_those_that_python_imports(module: str) -> None:
    code = IMPORTED.format(module=f"fmus.{module}", package=str(PACKAGE))
    done = subprocess.run([sys.executable, "-c", code], cwd=PACKAGE.parent, capture_output=True, text=True, check=True)
    imported = set(done.stdout.split()) - {"__init__.py", "sources.py", "cache.py"}  # asked by the keeper of kernels
    assert set(files_of(module)) - {"__init__.py"} == imported
