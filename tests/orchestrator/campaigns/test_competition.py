"""Competition of tones: statistics against closed forms, starts as asked for, nothing lost and nothing done twice."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from command_line import curvesqueal

from orchestrator.campaigns.competition import Starts, competition_plan
from orchestrator.campaigns.rows import DONE
from orchestrator.campaigns.sampling import points
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.runs.scenario import Scenario
from orchestrator.runs.starts import START_VELOCITY, mode_start
from orchestrator.signals.tones import tones
from orchestrator.system.reader import read_system


def test_frequencies_are_gathered_into_tones() -> None:
    found = tones([1100.2, 1979.0, None, 1983.8, 1099.6, 1978.0, None])
    assert [(t.count, t.of) for t in found] == [(3, 7), (2, 7), (2, 7)]
    assert found[0].frequency_hz == pytest.approx(1980.27, abs=0.01)
    assert None in (found[1].frequency_hz, found[2].frequency_hz)
    assert pytest.approx(1099.9) in (found[1].frequency_hz, found[2].frequency_hz)


@pytest.mark.parametrize("n", [1, 20, 24])
def test_confidence_interval_of_a_sure_thing(n: int) -> None:
    """Clopper and Pearson in closed form: n of n has the lower end (alpha/2)^(1/n) and the upper end 1."""
    tone = tones([1978.0] * n)[0]
    assert (tone.share, tone.high) == (1.0, 1.0)
    assert tone.low == pytest.approx(0.025 ** (1 / n), rel=1e-9)


def test_plan_is_every_combination() -> None:
    where = points(competition_plan(Scenario("case1"), Starts(3, 7, [1100.0, 1976.0], [1.1e9, 1.2e9])))
    assert len(where) == len({tuple(where[k].values()) for k in range(12)}) == 12
    assert set(where.columns["seed"].tolist()) == {7, 8, 9}
    assert points(competition_plan(Scenario("case1"), Starts(1)))[0] == {"seed": 0}


@pytest.mark.parametrize(
    ("how", "message"),
    [((0,), "runs = 0: must be at least 1"), ((1, -1), "seed = -1: must be >= 0"),
     ((1, 0, (), (-1.0,)), "stiffness = -1: must be > 0")],
)  # fmt: skip
def test_bad_plans_are_one_sentence(how: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        Starts(*how)


def test_a_chosen_mode_starts_at_the_given_velocity(built: Path) -> None:
    """The contact point moves at 0.1 m/s laterally at the start, and at the mode's frequency."""
    assembly = assemble(read_system(built / "curvesqueal.ssp"))
    start = mode_start(assembly.fmus["wheel"], {}, 1100.0)
    assert len(start) == 1
    assembly.parameters["wheel"].update(start)
    with Master(assembly, Settings(5e-6, 1e-5)) as master:
        lateral = master.plan.y[master.outputs.index(("wheel", "v_lat"))]
    assert abs(lateral) == pytest.approx(START_VELOCITY, rel=1e-9)


def test_a_mode_that_is_not_there_is_refused(built: Path) -> None:
    wheel = assemble(read_system(built / "curvesqueal.ssp")).fmus["wheel"]
    with pytest.raises(InputError, match=r"no lateral mode within 2 % of 700 Hz; its strong ones are at .*418, 1102"):
        mode_start(wheel, {}, 700.0)


@pytest.mark.slow
def test_runs_are_kept_and_not_made_again(tmp_path: Path) -> None:
    """Two runs, then three: the third store takes the rows of the first by their identity."""
    command = (
        "competition",
        "case1",
        "--duration",
        "0.005",
        "--jobs",
        "1",
        "--json",
        "--no-cycles",
        "--out",
        str(tmp_path),
    )
    done = curvesqueal(*command, "--runs", "2")
    assert done.returncode == 0, done.stderr
    first = xr.open_zarr(json.loads(done.stdout)["runs"]).load()
    data = json.loads(curvesqueal(*command, "--runs", "3").stdout)
    assert (data["done"], data["wanted"], data["failures"]) == (3, 3, [])
    second = xr.open_zarr(data["runs"]).load()
    for name in ("identity", "seconds", "tone"):
        assert second[name][:2].to_numpy().tolist() == first[name].to_numpy().tolist()
    shares = [tone["share"] for tone in data["starts"]["random start"]]
    assert sum(shares) == pytest.approx(1.0)
    assert (tmp_path / "competition-case1.png").stat().st_size > 5_000


@pytest.mark.slow
def test_an_interrupted_competition_keeps_its_runs(tmp_path: Path) -> None:
    """Ctrl-C after the first run: exit code 130, a sentence, and the runs that were done."""
    command = [sys.executable, "-m", "orchestrator", "competition", "case2", "--runs", "50", "--duration", "0.05",
               "--jobs", "2", "--out", str(tmp_path)]  # fmt: skip

    def done() -> int:
        stores = list(tmp_path.glob("competition-case2-*.zarr"))
        return int((xr.open_zarr(stores[0])["status"].to_numpy() == DONE).sum()) if stores else 0

    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        limit = time.monotonic() + 120
        while not done() and time.monotonic() < limit:
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        _, err = process.communicate(timeout=300)
    assert process.returncode == 130, err
    assert "of 50 runs; the same command goes on from there" in " ".join(err.split())
    assert "Traceback" not in err
    assert 0 < done() < 50
