"""The store: rows stay, nothing is overwritten, xarray opens it at any moment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from plans import plan_of

from orchestrator.campaigns.plan import Plan
from orchestrator.campaigns.prepared import Campaign, pack
from orchestrator.campaigns.results.export import write_rows
from orchestrator.campaigns.rows import DONE, FAILED, Row
from orchestrator.campaigns.sampling import points
from orchestrator.campaigns.stages import quantities
from orchestrator.campaigns.store import Store, claimed, open_store
from orchestrator.errors import InputError

VARY = '"contact.mu0" = { from = 0.1, to = 0.5, n = 600 }\ntreatment = { choices = { none = {}, damped = {} } }'
VALUES = {"growth_rate": 3.5, "growth_frequency": 1100.0, "unstable_modes": 2.0}


@pytest.fixture(scope="module")
def plan() -> Plan:
    return plan_of(VARY)


@pytest.fixture(scope="module")
def campaign(plan: Plan) -> Campaign:
    return pack(plan)[0]


def opened(path: Path, campaign: Campaign) -> Store:
    return open_store(path, campaign, points(campaign.plan), quantities(campaign.plan))


def test_rows_are_where_their_points_are(tmp_path: Path, campaign: Campaign) -> None:
    store = opened(tmp_path / "s.zarr", campaign)
    store.write([Row(700, DONE, "abc", values=VALUES, seconds=0.5), Row(3, FAILED, "", "it fails")])
    store.write([Row(701, DONE, "abd", values={**VALUES, "growth_rate": 4.5})])
    data = xr.open_zarr(tmp_path / "s.zarr").load()
    assert data.sizes["run"] == 1200
    assert {"contact.mu0", "treatment"} <= set(data.coords)
    assert data["growth_rate"].attrs["units"] == "s-1"
    assert np.flatnonzero(data["status"]).tolist() == [3, 700, 701]
    assert [data["growth_rate"][i].item() for i in (700, 701)] == [3.5, 4.5]
    assert data["message"][3].item() == "it fails"
    assert np.isnan(data["growth_rate"][3].item())
    assert '"treatment"' in data.attrs["plan"]
    assert "numba" in data.attrs["versions"]


def test_the_same_plan_finds_its_rows(tmp_path: Path, campaign: Campaign) -> None:
    opened(tmp_path / "s.zarr", campaign).write([Row(1, DONE, values=VALUES)])
    assert np.flatnonzero(opened(tmp_path / "s.zarr", campaign).status()).tolist() == [1]


def test_other_stores_are_refused_and_left_alone(tmp_path: Path, campaign: Campaign) -> None:
    path = tmp_path / "s.zarr"
    opened(path, campaign).write([Row(1, DONE, values=VALUES)])
    other, _ = pack(plan_of(VARY.replace("600", "500")))
    with pytest.raises(InputError, match="is the store of another plan; keep the rows in another store"):
        opened(path, other)
    element = replace(campaign.system.elements["wheel"], source=Path("0" * 64))
    system = replace(campaign.system, elements={**campaign.system.elements, "wheel": element})
    changed = replace(campaign, system=system, names={**campaign.names, "0" * 64: "wheel.fmu"})
    with pytest.raises(InputError, match=r"is the store of other FMUs; keep the rows in another store \(wheel.fmu"):
        opened(path, changed)
    assert np.flatnonzero(opened(path, campaign).status()).tolist() == [1]


def test_what_is_no_store_is_refused(tmp_path: Path, campaign: Campaign) -> None:
    path = tmp_path / "notes"
    path.mkdir()
    (path / "keep.txt").write_text("mine")
    with pytest.raises(InputError, match="is no store of a campaign"):
        opened(path, campaign)
    assert (path / "keep.txt").read_text() == "mine"


def test_two_sweeps_do_not_share_a_store(tmp_path: Path) -> None:
    path = tmp_path / "s.zarr"
    with claimed(path), pytest.raises(InputError, match="another sweep is writing to it"), claimed(path):
        pass


def test_parquet_has_one_row_per_run(tmp_path: Path, campaign: Campaign) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    opened(tmp_path / "s.zarr", campaign).write([Row(5, DONE, "id", values=VALUES)])
    write_rows(tmp_path / "s.zarr", tmp_path / "s.parquet")
    table = pq.read_table(tmp_path / "s.parquet")
    assert table.num_rows == 1200
    assert table["growth_rate"][5].as_py() == 3.5
    assert table["treatment"][1].as_py() == "damped"


def test_a_hundred_thousand_rows_are_below_100_megabytes(tmp_path: Path) -> None:
    """With random numbers in every column, which nothing can pack."""
    campaign, _ = pack(plan_of("seed = { from = 0, to = 99999 }", compute='stage = ["linear", "time"]'))
    store = opened(tmp_path / "s.zarr", campaign)
    random = np.random.default_rng(0)
    sizes = {q.name: q.size for q in store.quantities if not q.text}
    rows = []
    for k in range(2000):
        values = {name: random.random(size) if size else float(random.random()) for name, size in sizes.items()}
        rows.append(Row(k, DONE, random.bytes(32).hex(), values=values))
    store.write(rows)
    size = sum(file.stat().st_size for file in (tmp_path / "s.zarr").rglob("*") if file.is_file())
    assert size * 50 < 100e6
