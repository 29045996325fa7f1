"""The cache: private, whole, not growing without end, and not needed."""

from __future__ import annotations

import os
import time
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from orchestrator.archive import unpack
from orchestrator.cache import UNUSED, _root, cache_folder, prune


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    _root.cache_clear()
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
