"""What the doctests of this package use."""

from pathlib import Path
from typing import Any

import pytest


@pytest.fixture(autouse=True)
def _folder(doctest_namespace: dict[str, Any], tmp_path: Path) -> None:
    """Give doctests a scratch folder under the name `folder`."""
    doctest_namespace["folder"] = tmp_path
