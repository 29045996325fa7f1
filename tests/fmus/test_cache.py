"""The cache: private, whole, not growing without end, and not needed."""

from __future__ import annotations

import os
import time
import zipfile
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from fmus.cache import UNUSED, _prune_once, _root, cache_folder, prune
from fmus.compile import compiled, kept_under
from fmus.packaging.native.kept import keep, kept
from orchestrator.archive import unpack


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    _root.cache_clear()
    _prune_once.cache_clear()
    yield tmp_path / "cache"
    _root.cache_clear()


def archive(folder: Path) -> Path:
    with zipfile.ZipFile(folder / "a.fmu", "w") as file:
        file.writestr("binaries/x.so", b"machine code")
    return folder / "a.fmu"


def test_only_its_user_may_write_there(place: Path) -> None:
    assert cache_folder("unpacked") == place / "unpacked"
    assert place.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(os.name != "posix", reason="modes of POSIX")
def test_a_folder_that_others_can_write_to_is_closed(place: Path) -> None:
    place.mkdir()
    place.chmod(0o777)
    cache_folder("unpacked")
    assert place.stat().st_mode & 0o022 == 0


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a folder away")
def test_a_folder_of_another_user_is_not_used(place: Path, tmp_path: Path) -> None:
    for taken in (place, tmp_path / f"curvesqueal-{os.getuid()}"):
        taken.mkdir()
        os.chown(taken, 12345, -1)
    folder = cache_folder("unpacked").parent
    assert folder not in (place, tmp_path / f"curvesqueal-{os.getuid()}")
    assert folder.stat().st_uid == os.getuid()
    assert folder.stat().st_mode & 0o077 == 0


def test_where_there_can_be_none_it_works_without(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "file" / "cache"))
    assert (unpack(archive(tmp_path), "FMU") / "binaries" / "x.so").read_bytes() == b"machine code"


def test_a_damaged_file_is_unpacked_again(tmp_path: Path) -> None:
    library = unpack(archive(tmp_path), "FMU") / "binaries" / "x.so"
    library.write_bytes(b"something else")
    assert (unpack(archive(tmp_path), "FMU") / "binaries" / "x.so").read_bytes() == b"machine code"
    library.unlink()
    assert (unpack(archive(tmp_path), "FMU") / "binaries" / "x.so").read_bytes() == b"machine code"


def test_what_nobody_used_for_long_goes(place: Path) -> None:
    folder = cache_folder("unpacked")
    for name, age in (("old", UNUSED + 60), ("new", UNUSED - 60)):
        (folder / name / "binaries").mkdir(parents=True)
        os.utime(folder / name, (time.time() - age,) * 2)
    prune(folder)
    assert [p.name for p in folder.iterdir()] == ["new"]


@pytest.mark.parametrize("kind", ["built", "campaigns", "compiled", "kernels", "unpacked"])
def test_every_kind_goes_once_it_is_not_used(place: Path, kind: str) -> None:
    folder = cache_folder(kind)
    for name, age in (("old", UNUSED + 60), ("new", UNUSED - 60)):
        (folder / name).mkdir()
        os.utime(folder / name, (time.time() - age,) * 2)
    _prune_once.cache_clear()
    assert [p.name for p in cache_folder(kind).iterdir()] == ["new"]


def test_kernels_and_compiled_libraries_are_there_too(place: Path, tmp_path: Path) -> None:
    """One place for all: the one that the variable of the environment names. What is used is young again."""
    file = tmp_path / "kernels.py"
    file.write_text("def double(x):\n    return 2 * x\n")
    folder = Path(kept_under([file]))
    assert folder.parent == place / "kernels"
    keep("a" * 64, b"machine code")
    stored = place / "compiled" / ("a" * 64)
    os.utime(stored, (0, 0))
    assert kept("a" * 64) == b"machine code"
    assert time.time() - stored.stat().st_mtime < 60


@pytest.mark.parametrize("damage", [lambda _: b"", lambda b: b[: len(b) // 2], lambda b: b[:-9] + b"?" + b[-8:]])
def test_damaged_machine_code_is_compiled_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: Callable[[bytes], bytes]
) -> None:
    """Empty, cut, a wrong byte; in the index, in the code, in both: the same number, and whole files afterwards."""
    monkeypatch.syspath_prepend(tmp_path)
    module = f"kernel_of_{tmp_path.name}"
    (tmp_path / f"{module}.py").write_text("def double(x):\n    return 2.0 * x\n")
    double, folder = import_module(module).double, tmp_path / "kernels"

    def hits() -> int:
        made: Any = compiled(double, str(folder))
        assert made(21.0) == 42.0
        return sum(made.stats.cache_hits.values())

    assert hits() == 0
    assert hits() == 1
    for kinds in (("nbi",), ("nbc",), ("nbi", "nbc")):
        for path in [p for p in folder.rglob("*") if p.suffix[1:] in kinds]:
            path.write_bytes(damage(path.read_bytes()))
        assert hits() == 0
        assert hits() == 1
