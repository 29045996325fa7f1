"""Maps and Sobol indices: closed forms, and the function of Ishigami."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from plans import plan_of
from scipy.stats import qmc

from orchestrator.campaigns.results.maps import ended_tones, make_map
from orchestrator.campaigns.results.page import write_page
from orchestrator.campaigns.results.sobol import indices, of_values
from orchestrator.campaigns.rows import DONE, FAILED
from orchestrator.campaigns.sampling import points
from orchestrator.errors import InputError
from orchestrator.figures.campaign import Grid, Share, draw_grid, draw_indices


def store_of(columns: dict[str, list[float]], values: dict[str, list[float]], method: str = "grid") -> xr.Dataset:
    """Return a dataset as a store gives it, all runs done."""
    n = len(next(iter(columns.values())))
    data = {name: ("run", np.array(v, dtype=float)) for name, v in values.items()}
    about = {"factors": list(columns), "plan": json.dumps({"sample": {"method": method}}), "title": "campaign"}
    status = {"status": ("run", np.full(n, DONE, dtype=np.uint8))}
    return xr.Dataset({**data, **status}, {name: ("run", np.array(v)) for name, v in columns.items()}, about)


def test_a_map_has_each_run_in_its_cell() -> None:
    x, y = [0.1, 0.1, 0.2, 0.2, 0.3, 0.3], [1.0, 2.0, 1.0, 2.0, 1.0, 2.0]
    data = store_of({"a.x": x, "a.y": y}, {"growth_rate": [10 * a + b for a, b in zip(x, y, strict=True)]})
    data["status"][3] = FAILED
    found = make_map(data, "a.x", "a.y", "growth_rate")
    np.testing.assert_allclose(found.value, np.array([[2, 3, 4], [3, np.nan, 5]]))
    assert found.runs.tolist() == [[1, 1, 1], [1, 0, 1]]
    assert found.as_json()["value"][1][1] is None


def test_several_runs_of_a_cell_give_their_median() -> None:
    data = store_of({"a.x": [1, 1, 1, 2], "a.y": [5, 5, 5, 5], "seed": [0, 1, 2, 0]}, {"tone": [100, 900, 200, 300]})
    assert make_map(data, "a.x", "a.y", "tone").value.tolist() == [[200, 300]]


@pytest.mark.parametrize("n", [1, 20, 24])
def test_probability_of_a_sure_thing(n: int) -> None:
    """Clopper and Pearson in closed form: n of n has the lower end (alpha/2)^(1/n) and the upper end 1."""
    data = store_of({"a.x": [1] * n, "a.y": [1] * n, "seed": list(range(n))}, {"squeals": [1.0] * n})
    found = make_map(data, "a.x", "a.y", "probability")
    assert found.low is not None
    assert found.high is not None
    assert (found.value[0, 0], found.high[0, 0]) == (1.0, 1.0)
    assert found.low[0, 0] == pytest.approx(0.025 ** (1 / n), rel=1e-9)


def test_the_last_stage_decides_whether_a_run_squeals() -> None:
    """Unstable but quiet in time is quiet; stable was not simulated and is quiet."""
    values = {"growth_rate": [5.0, 5.0, -1.0], "squeals": [1.0, 0.0, np.nan]}
    data = store_of({"a.x": [1, 2, 3], "a.y": [1, 1, 1]}, values)
    assert make_map(data, "a.x", "a.y", "probability").value.tolist() == [[1.0, 0.0, 0.0]]


def test_random_points_are_gathered_in_bins() -> None:
    random = np.random.default_rng(0)
    x, y = random.uniform(0, 1, 3000).tolist(), random.uniform(0, 2, 3000).tolist()
    found = make_map(store_of({"a.x": x, "a.y": y}, {"growth_rate": x}), "a.x", "a.y", "growth_rate")
    assert found.x.binned
    assert found.runs.sum() == 3000
    spread = np.abs(found.value - found.x.values).max()
    assert spread < 0.5 / 12  # the median of a bin lies within it


@pytest.mark.parametrize(
    ("x", "y", "colour", "message"),
    [
        ("a.z", "a.y", "tone", "a.z: the campaign does not vary it; it varies a.x, a.y"),
        ("a.x", "a.x", "tone", "the two axes of a map must differ"),
        ("a.x", "a.y", "level", "level: the store has no such quantity; it has probability, tone"),
    ],
)
def test_bad_maps_are_one_sentence(x: str, y: str, colour: str, message: str) -> None:
    data = store_of({"a.x": [1.0], "a.y": [1.0]}, {"tone": [1.0]})
    with pytest.raises(InputError, match=message):
        make_map(data, x, y, colour)


def test_tones_of_a_campaign() -> None:
    data = store_of({"seed": [0, 1, 2]}, {"tone": [1100.0, 1101.0, np.nan]})
    assert [(t.count, t.frequency_hz) for t in ended_tones(data)] == [(2, 1100.5), (1, None)]


def ishigami(x: np.ndarray) -> np.ndarray:
    return np.asarray(np.sin(x[..., 0]) + 7 * np.sin(x[..., 1]) ** 2 + 0.1 * x[..., 2] ** 4 * np.sin(x[..., 0]))


ISHIGAMI_FIRST, ISHIGAMI_TOTAL = (0.3139, 0.4424, 0.0), (0.5576, 0.4424, 0.2437)
"""Closed form: V = a^2/8 + b pi^4/5 + b^2 pi^8/18 + 1/2 with a = 7, b = 0.1."""


def test_sobol_indices_of_the_ishigami_function() -> None:
    """1024 points of a Sobol sequence: the largest error of ten seeds is 0.031."""
    vary = "\n".join(f'"f.x{k}" = {{ from = {-np.pi!r}, to = {np.pi!r} }}' for k in range(3))
    where = points(plan_of(vary, 'method = "saltelli"\nn = 1024'))
    x = np.array(list(where.columns.values())).T
    columns = {name: column.tolist() for name, column in where.columns.items()}
    found = indices(store_of(columns, {"growth_rate": ishigami(x).tolist()}, "saltelli"), "growth_rate")
    np.testing.assert_allclose([i.first for i in found], ISHIGAMI_FIRST, atol=0.05)
    np.testing.assert_allclose([i.total for i in found], ISHIGAMI_TOTAL, atol=0.05)
    for i, first, total in zip(found, ISHIGAMI_FIRST, ISHIGAMI_TOTAL, strict=True):
        assert i.first_low - 0.01 < first < i.first_high + 0.01
        assert i.total_low - 0.01 < total < i.total_high + 0.01


def test_indices_of_a_sum_are_its_shares() -> None:
    """F = x1 + 2 x2 with independent uniform x: the shares of the variance are 1/5 and 4/5, first order and total."""
    both = qmc.Sobol(4, rng=np.random.default_rng(1)).random(1024)
    A, B = both[:, :2], both[:, 2:]
    weights = np.array([1.0, 2.0])
    mixed = [np.where(np.arange(2) == k, B, A) @ weights for k in range(2)]
    found = of_values(np.array([A @ weights, B @ weights, *mixed]), ["x1", "x2"])
    for i, share in zip(found, (0.2, 0.8), strict=True):
        assert (i.first, i.total) == pytest.approx((share, share), abs=0.02)


def test_indices_are_refused_where_they_mean_nothing() -> None:
    data = store_of({"a.x": [1.0, 2.0, 3.0]}, {"tone": [1.0, 2.0, np.nan]}, "saltelli")
    with pytest.raises(InputError, match="1 of 3 have no number"):
        indices(data, "tone")
    with pytest.raises(InputError, match=r'need .sample. method = "saltelli"'):
        indices(store_of({"a.x": [1.0]}, {"tone": [1.0]}), "tone")


def test_pictures_and_page(tmp_path: Path) -> None:
    data = store_of({"a.x": [1, 1, 2, 2], "a.<y>": [1, 2, 1, 2]}, {"growth_rate": [-1.0, 2.0, 3.0, 4.0]})
    found = make_map(data, "a.x", "a.<y>", "growth_rate")
    write_page(found, "<script>title</script>", data.attrs["plan"], tmp_path / "map.html")
    page = (tmp_path / "map.html").read_text()
    assert "<script>title" not in page
    assert "a.\\u003cy>" in page
    grid = Grid("t", "x", "y", "v", found.x.values, found.y.values, (), (), found.value, True)
    draw_grid(grid, tmp_path / "map.png")
    draw_indices("t", ["a"], [Share(0.2, 0.1, 0.3)], [Share(0.4, 0.3, 0.5)], tmp_path / "indices.png")
    assert all((tmp_path / name).stat().st_size > 5_000 for name in ("map.png", "indices.png"))
