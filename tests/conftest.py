"""What several test files share: the FMUs and the SSP, built once."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

from fmus.packaging.build import Target, build

settings.register_profile("curvesqueal", deadline=None, derandomize=True)
settings.load_profile("curvesqueal")


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs, with a Python body, and the SSP."""
    folder = tmp_path_factory.mktemp("built")
    build(folder, Target("python"))
    return folder


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs in machine code, FMI 2, and the SSP."""
    folder = tmp_path_factory.mktemp("native")
    build(folder, Target("native"))
    return folder


@pytest.fixture(scope="session")
def native3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs in machine code, FMI 3, and the SSP."""
    folder = tmp_path_factory.mktemp("native3")
    build(folder, Target("native", 3))
    return folder
