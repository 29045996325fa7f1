"""What several test files share: the FMUs and the SSP, built once."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import settings

from fmus.packaging.build import build

settings.register_profile("curvesqueal", deadline=None, derandomize=True)
settings.load_profile("curvesqueal")


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs and the SSP."""
    folder = tmp_path_factory.mktemp("built")
    build(folder)
    return folder
