"""Wheel and sdist as a user gets them: installed into empty environments elsewhere, they build FMUs, run and test."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
OWN_TESTS = (
    "tests/layout",
    "tests/fmus/contract",
    "tests/fmus/wheel/test_wheelset.py",
    "tests/fmus/rail/test_track_data.py",
)
"""Tests of the sdist that read its data: cases, contract, wheel and track files."""

pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Environment:
    """An environment of its own, and the folder in which it is used."""

    python: Path
    folder: Path

    def run(self, *arguments: str, folder: Path | None = None) -> str:
        """Run a module in it with nothing of this project on the path; return what it prints."""
        clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST", "VIRTUAL_ENV"))}
        cache = {"CURVESQUEAL_CACHE": str(self.folder / "cache")}
        done = subprocess.run(
            [str(self.python), "-m", *arguments], cwd=folder or self.folder, env={**clean, **cache},
            capture_output=True, text=True, check=False, timeout=900,
        )  # fmt: skip
        assert done.returncode == 0, f"{arguments}: {done.stdout[-2000:]}{done.stderr[-3000:]}"
        return done.stdout


def environment(python: str, folder: Path) -> Environment:
    """Return an empty environment of a Python."""
    subprocess.run([python, "-m", "venv", str(folder / "env")], check=True, timeout=300)
    return Environment(folder / "env" / ("Scripts" if os.name == "nt" else "bin") / "python", folder)


@pytest.fixture(scope="module")
def distributions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the wheel and the sdist."""
    folder = tmp_path_factory.mktemp("dist")
    builder = environment(sys.executable, folder)
    try:
        builder.run("pip", "install", "--quiet", "hatchling>=1.27")
    except AssertionError as error:
        pytest.skip(f"no package index to install the build backend from: {str(error)[-200:]}")
    builder.run("hatchling", "build", "-d", str(folder / "files"), folder=ROOT)
    return folder / "files"


def test_the_wheel_holds_licences_types_and_data(distributions: Path) -> None:
    with zipfile.ZipFile(next(distributions.glob("*.whl"))) as wheel:
        names = wheel.namelist()
        metadata = wheel.read(next(n for n in names if n.endswith("METADATA"))).decode()
    vendored = sorted(path.name for path in (ROOT / "orchestrator/report/templates").glob("*.LICENSE"))
    stated = [line.partition(": ")[2] for line in metadata.splitlines() if line.startswith("License-File: ")]
    assert vendored
    assert sorted(Path(s).name for s in stated) == sorted(["LICENSE", *vendored])
    for name in ("fmus/py.typed", "orchestrator/py.typed", "ssp/cases.toml", "fmus/packaging/native/c/fmi3.c"):
        assert name in names, name
    assert not [n for n in names if n.startswith(("tests/", "docs/"))]


@pytest.mark.parametrize("version", PYTHONS)
def test_installed_elsewhere_it_builds_and_runs(distributions: Path, tmp_path: Path, version: str) -> None:
    """The wheel builds FMUs with this project's licence and runs a case; the sdist passes tests that need its data."""
    python = sys.executable if sys.version.startswith(f"{version}.") else shutil.which(f"python{version}")
    if python is None or subprocess.run([python, "--version"], capture_output=True, check=False).returncode:
        pytest.skip(f"there is no python{version} on this machine")  # or a launcher that finds none
    env = environment(python, tmp_path)
    env.run("pip", "install", "--quiet", str(next(distributions.glob("*.whl"))), "pytest>=8.3", "hypothesis>=6.100")
    assert env.run("orchestrator", "--version").startswith("curvesqueal ")
    env.run("orchestrator", "build", "--out", "built")
    with zipfile.ZipFile(tmp_path / "built" / "rail.fmu") as fmu:
        licence = next(n for n in fmu.namelist() if Path(n).name.lower().startswith("license"))
        assert fmu.read(licence).decode() == (ROOT / "LICENSE").read_text(encoding="utf-8")
    told = json.loads(env.run("orchestrator", "run", "built/curvesqueal.ssp", "--duration", "0.002", "--json"))
    assert told["completed"] is True
    with tarfile.open(next(distributions.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path / "source", filter="data")
    source = next((tmp_path / "source").iterdir())
    env.run("pytest", "-q", "-x", "-p", "no:cacheprovider", *OWN_TESTS, folder=source)
