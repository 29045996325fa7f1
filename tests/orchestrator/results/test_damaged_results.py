"""Damaged results: read up to the last whole row with a notice, or refused in a sentence; never other numbers."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from orchestrator.errors import DamageWarning, InputError
from orchestrator.results.file import Column, ResultsFile, open_results

COLUMNS = [Column("a.y", "m", ""), Column("b/n ", "", "", np.dtype(np.int32)), Column("c.b", "", "", np.dtype(bool))]
WIDE = [*COLUMNS, Column("d.n", "", "", np.dtype(np.int64))]


def written(path: Path, columns: list[Column]) -> tuple[Path, int]:
    """Return a file of ten rows and the size of its header."""
    with ResultsFile(path, columns, {"title": "damage"}) as file:
        begin = file.path.stat().st_size
        file.append(np.arange(10.0), np.arange(10.0 * len(columns)).reshape(10, -1))
    return path, begin


@pytest.fixture(params=[COLUMNS, WIDE], ids=["classic", "64-bit"])
def file(tmp_path: Path, request: pytest.FixtureRequest) -> tuple[Path, int]:
    return written(tmp_path / "r.nc", request.param)


def test_xarray_opens_it_in_one_line(file: tuple[Path, int]) -> None:
    with xr.open_dataset(file[0]) as data:
        assert data["a.y"].to_numpy().tolist() == open_results(file[0])["a.y"].to_numpy().tolist()
        assert data["b_n_"].attrs["variable"] == "b/n "


@pytest.mark.parametrize("how", ["cut", "hole", "flip"])
def test_whole_rows_are_read_with_a_notice(file: tuple[Path, int], how: str) -> None:
    """Rows that were cut off, zeros where a power cut left a hole, one bit: the seven rows before are the same."""
    path, begin = file
    data = bytearray(path.read_bytes())
    row = (len(data) - begin) // 10
    at = begin + 7 * row
    if how == "cut":
        del data[at + 5 :]
    elif how == "hole":
        data[at:] = bytes(len(data) - at)
    else:
        data[at + 9] ^= 4
    path.write_bytes(data)
    with (
        pytest.warns(DamageWarning, match=r"the first 7 to t = 6 s are whole"),
        open_results(path) as left,
    ):
        assert left["time"].to_numpy().tolist() == list(range(7))


def test_no_row_is_lost_by_a_count_that_is_too_small(file: tuple[Path, int]) -> None:
    path, _ = file
    data = bytearray(path.read_bytes())
    data[4:12] = bytes(12 if data[3] == 5 else 8)[:4] + data[8:12] if data[3] != 5 else bytes(8)
    path.write_bytes(data)
    with open_results(path) as left:
        assert left.sizes["time"] == 10


def test_every_flip_of_the_header_is_seen(tmp_path: Path) -> None:
    """Every third byte of the header: a sentence, or the same numbers, units and attributes as before."""
    path, begin = written(tmp_path / "r.nc", COLUMNS)
    whole, bad = path.read_bytes(), tmp_path / "bad.nc"
    before = open_results(path).load()
    refused = 0
    for place in range(0, begin, 3):
        bad.write_bytes(whole[:place] + bytes([whole[place] ^ (1 << place % 8)]) + whole[place + 1 :])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", DamageWarning)
            try:
                with open_results(bad) as data:
                    assert data.drop_attrs().identical(before.drop_attrs()), place
                    assert {n: v.attrs for n, v in data.variables.items()} == {
                        n: v.attrs for n, v in before.variables.items()
                    }, place
            except InputError:
                refused += 1
    assert refused > 0.8 * begin / 3  # what passes are the count of rows and the names of the checksums
