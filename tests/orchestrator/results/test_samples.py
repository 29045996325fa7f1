"""Results as plain arrays are the results that xarray opens."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.results.file import Column, ResultsFile, open_results
from orchestrator.results.samples import read_samples

KINDS = {"f": np.float64, "g": np.float32, "i": np.int32, "w": np.int64, "b": np.bool_}


@pytest.mark.parametrize("names", ["f", "fgib", "fwb"])
@pytest.mark.parametrize("rows", [0, 1, 7])
def test_both_readers_say_the_same(tmp_path: Path, names: str, rows: int) -> None:
    """Of files with and without 64-bit whole numbers, and of a run that was stopped before its first row."""
    values = np.zeros((rows, len(names)))
    values[:] = np.random.default_rng(rows).integers(0, 2, values.shape)
    for k, name in enumerate(names):
        if name == "w":
            values.view(np.int64)[:, k] = 2**62 + np.arange(rows)
    columns = [Column(f"a.{name}", "m/s", "", np.dtype(KINDS[name])) for name in names]
    with ResultsFile(tmp_path / "r.nc", columns, {"title": "t", "step_s": 0.5}) as file:
        file.append(0.5 * np.arange(float(rows)), values)
    found = read_samples(tmp_path / "r.nc")
    with open_results(tmp_path / "r.nc") as expected:
        assert set(found) == {str(name) for name in expected.variables}
        assert (found.sizes, dict(found.attrs)) == (dict(expected.sizes), expected.attrs)
        for name in found:
            np.testing.assert_array_equal(found[name], expected[name])
        np.testing.assert_array_equal(found.isel(slice(1, None))["a.f"], expected["a.f"].isel(time=slice(1, None)))
