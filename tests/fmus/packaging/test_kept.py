"""Compiled files kept between builds: the same bytes or a new compilation, never something else."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.packaging.native.kept import NOTHING_KEPT, keep, kept, key_of


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path / "compiled"


def test_what_is_kept_comes_back() -> None:
    assert kept("0" * 64) is None
    keep("0" * 64, b"machine code")
    assert kept("0" * 64) == b"machine code"


@pytest.mark.parametrize("damage", [lambda b: b[:-1], lambda b: b[:0], lambda b: b[:40] + b"?" + b[41:]])
def test_a_damaged_file_is_not_used(folder: Path, damage: object) -> None:
    keep("a", b"machine code of some length")
    (folder / "a").write_bytes(damage((folder / "a").read_bytes()))  # type: ignore[operator]
    assert kept("a") is None


def test_a_temporary_folder_serves_where_nothing_can_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_bytes(b"")
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "file"))
    keep("a", b"machine code")
    assert kept("a") == b"machine code"
    assert [path.parent.name for path in tmp_path.glob("curvesqueal*/compiled/a")] == ["compiled"]


def test_a_build_anew_reads_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    keep("a", b"machine code")
    monkeypatch.setenv(NOTHING_KEPT, "1")
    assert kept("a") is None


def test_the_border_between_parts_counts() -> None:
    assert key_of([b"ab", b"c"]) != key_of([b"a", b"bc"]) != key_of([b"abc"])
