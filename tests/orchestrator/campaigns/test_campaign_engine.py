"""The engine: a plan from start to end, failures as rows, going on where it was."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from distributed import Client
from plans import plan_of

from orchestrator.campaigns import sweep as sweeping
from orchestrator.campaigns.cluster import remote
from orchestrator.campaigns.prepared import Workshop, prepare
from orchestrator.campaigns.rows import DONE, FAILED
from orchestrator.campaigns.stages import run_point
from orchestrator.campaigns.sweep import How, checked, estimate, sweep
from orchestrator.errors import InputError
from orchestrator.limit_cycles.search import cycles_of
from orchestrator.runs.identity import identity
from orchestrator.runs.scenario import Scenario
from orchestrator.stability.linear_model import model_of_assembly

VARY = '"contact.mu0" = { from = 0.1, to = 0.5, n = 3 }\n"contact.contact_angle" = { from = 0.0, to = 0.07, n = 2 }'


@pytest.fixture(scope="module")
def scheduler() -> Iterator[str]:
    """Start a scheduler with one worker in this process; give its address."""
    with Client(processes=False, n_workers=1, threads_per_worker=1, dashboard_address=None, protocol="tcp") as client:
        yield str(client.scheduler.address)


def test_a_plan_gives_one_row_per_run(tmp_path: Path, scheduler: str) -> None:
    """The growth rates are those of the eigenvalues, the identities those of the scenarios by themselves."""
    path = tmp_path / "s.zarr"
    ended = sweep(plan_of(VARY), path, How(scheduler))
    assert (ended.wanted, ended.done, ended.failed) == (6, 6, 0)
    data = xr.open_zarr(path).load()
    assert np.unique(data["identity"]).size == data.sizes["run"] == 6
    for row in (0, 5):
        point = {name: data[f"contact.{name}"][row].item() for name in ("mu0", "contact_angle")}
        assembly, settings = Scenario("case3", values={"contact": point}).prepare()
        exact = model_of_assembly(assembly, settings.step).poles.growth_rate.max()
        assert data["growth_rate"][row].item() == pytest.approx(exact, rel=1e-8, abs=1e-8)
        assert data["identity"][row].item() == identity(assembly, settings)


def test_the_same_plan_goes_on_where_it_was(tmp_path: Path, scheduler: str) -> None:
    """Stopped after the first rows; what was done is not made again, what is missing is."""
    path, seen = tmp_path / "s.zarr", [0]

    def report(now: sweeping.Progress) -> None:
        seen[0] = now.done

    first = sweep(plan_of(VARY), path, How(scheduler, report=report, stop_requested=lambda: seen[0] > 0))
    assert 0 < first.done < 6
    seconds = xr.open_zarr(path).load()["seconds"].to_numpy()
    second = sweep(plan_of(VARY), path, How(scheduler))
    assert second.done == 6
    before = np.isfinite(seconds)
    assert (xr.open_zarr(path).load()["seconds"].to_numpy()[before] == seconds[before]).all()


def test_a_run_that_fails_is_a_row_and_can_be_made_again(tmp_path: Path, scheduler: str) -> None:
    """A spring of 1e12 N/m is too stiff for the iteration at this step: that point fails, its neighbour does not."""
    bad = plan_of('"contact.hertz_stiffness" = [2.35e9, 1e12]', compute='stage = "time"',
                  system='case = "case3"\nalgorithm = "iterative"\nduration = 0.001')  # fmt: skip
    path = tmp_path / "s.zarr"
    ended = sweep(bad, path, How(scheduler))
    data = xr.open_zarr(path).load()
    assert (ended.done, ended.failed) == (1, 1), data["message"].to_numpy()
    assert data["status"].to_numpy().tolist() == [DONE, FAILED]
    assert "still changes after" in data["message"][1].item()
    again = sweep(bad, path, How(scheduler))
    assert (again.done, again.failed) == (1, 1)
    retried = sweep(bad, path, How(scheduler, retry_failed=True))
    assert (retried.done, retried.failed) == (1, 1)


def test_a_staged_plan_simulates_only_what_is_unstable(tmp_path: Path, scheduler: str) -> None:
    plan = plan_of('"contact.mu0" = [0.01, 0.3]', compute='stage = ["linear", "time"]',
                   system='case = "case3"\nduration = 0.02')  # fmt: skip
    sweep(plan, tmp_path / "s.zarr", How(scheduler))
    data = xr.open_zarr(tmp_path / "s.zarr").load()
    assert (data["growth_rate"].to_numpy() > 0).tolist() == [False, True]
    assert np.isfinite(data["lateral_rms"].to_numpy()).tolist() == [False, True]
    assert (data["status"].to_numpy() == DONE).all()


def test_a_choice_sets_several_things_at_once() -> None:
    """A treatment by name is the same system as its values set by hand."""
    plan = plan_of("treatment = { choices = { none = {}, low = { contact.mu0 = 0.2, contact.falling_ratio = 0.0 } } }")
    campaign, _, where = checked(plan)
    by_hand = Scenario("case3", values={"contact": {"mu0": 0.2, "falling_ratio": 0.0}}).prepare()
    assert identity(prepare(campaign, Workshop(), where[1]), campaign.settings) == identity(*by_hand)


@pytest.mark.slow
def test_limit_cycles_of_a_point_are_those_of_the_catalogue() -> None:
    campaign, _, where = checked(plan_of('"contact.mu0" = [0.3]', compute='stage = "cycles"'))
    row = run_point(campaign, Workshop(), 0, where[0])
    assert row.status == DONE, row.message
    found = cycles_of(Scenario("case3").prepare()[0], campaign.settings.step).cycles
    assert row.values["cycles"] == len(found)
    assert row.values["cycle_tone"] in [c.frequency_hz for c in found if c.stable]


@pytest.mark.slow
def test_a_wheel_by_name_takes_its_place() -> None:
    campaign, _, where = checked(plan_of('wheel = ["wheel", "wheel-generic840"]'))
    workshop = Workshop()
    rows = [run_point(campaign, workshop, k, where[k]) for k in range(2)]
    assert [row.status for row in rows] == [DONE, DONE], [row.message for row in rows]
    assert rows[0].values["growth_rate"] != rows[1].values["growth_rate"]


def test_seeds_are_those_of_scenarios() -> None:
    campaign, _, where = checked(plan_of("seed = { from = 3, to = 4 }"))
    assembly = prepare(campaign, Workshop(), where[1])
    assert identity(assembly, campaign.settings) == identity(*Scenario("case3", seed=4).prepare())


@pytest.mark.parametrize(
    ("vary", "message"),
    [
        ('"contact.mu" = [0.1]', "has no variable 'mu'; did you mean 'mu0'"),
        ('"kontakt.mu0" = [0.1]', "the system has no component 'kontakt'; it has"),
        ('"contact.mu0" = [0.3, -0.1]', r"contact.mu0 = -0.1: must be in the range"),
        ('rail = ["rail-of-wood"]', "rail-of-wood: neither an .fmu file nor one of"),
        ("start_hz = [700.0]", "no lateral mode within 2 % of 700 Hz"),
    ],
)
def test_what_does_not_fit_the_system_is_refused_before_anything_runs(vary: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        checked(plan_of(vary))


def test_a_scheduler_that_is_not_there_is_one_sentence() -> None:
    message = r"scheduler tcp://127\.0\.0\.1:1: no Dask scheduler answers there"
    with pytest.raises(InputError, match=message), remote("tcp://127.0.0.1:1", patience=1.0):
        pass


def test_a_dry_run_says_runs_time_and_size() -> None:
    found = estimate(plan_of(VARY), 2)
    assert found.runs == 6
    assert found.seconds == pytest.approx(6 * found.seconds_per_run / 2)
    assert 0 < found.bytes < 10_000


def test_unstable_modes_fall_from_case_3_to_case_4() -> None:
    """Six modes below 4.5 kHz on the rail, two on the rigid one (tables 3 and 4 of the paper's setting)."""
    counts = []
    for case in ("case3", "case4"):
        campaign, _, where = checked(plan_of('"contact.mu0" = [0.3]', system=f'case = "{case}"'))
        row = run_point(campaign, Workshop(), 0, where[0])
        counts.append(row.values["unstable_modes"])
    assert counts == [6.0, 2.0]
