"""What several test files share: the FMUs and the SSP, built once."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from block_systems import block_fmu
from filelock import FileLock
from hypothesis import settings
from two_masses import write_masses

from fmus.packaging.build import build
from fmus.packaging.target import Target

settings.register_profile("curvesqueal", deadline=None, derandomize=True)
settings.load_profile("curvesqueal")


def build_once(factory: pytest.TempPathFactory, name: str, target: Target) -> Path:
    """Build into a folder that all processes of a test run share; who comes second waits."""
    shared = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        shared = shared.parent
    folder = shared / f"fmus-{name}"
    with FileLock(shared / f"fmus-{name}.lock"):
        if not folder.is_dir():
            build(shared / f"unfinished-{name}", target).parent.rename(folder)
    return folder


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs, with a Python body, and the SSP."""
    return build_once(tmp_path_factory, "built", Target("python"))


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs in machine code, FMI 2, and the SSP."""
    return build_once(tmp_path_factory, "native", Target("native"))


@pytest.fixture(scope="session")
def native3(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with all FMUs in machine code, FMI 3, and the SSP."""
    return build_once(tmp_path_factory, "native3", Target("native", 3))


@pytest.fixture(scope="session")
def block(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU `y = k u + b`, of which tests of systems are made."""
    return block_fmu(tmp_path_factory.mktemp("block"))


@pytest.fixture(scope="module")
def masses(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the FMUs of two oscillating masses and of the spring between them."""
    return write_masses(tmp_path_factory.mktemp("masses"))
