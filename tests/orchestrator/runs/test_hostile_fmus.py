"""FMUs that end the process, crash, take their time or answer nonsense: which FMU, which exit code, what is kept."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command_line import curvesqueal
from fmi3_fmu import write_ssd
from foreign_fmus import U, Y, foreign_fmu
from table_fmus import COMPILER

from orchestrator.coupling.settings import Settings
from orchestrator.errors import InputError
from orchestrator.fmi.file import open_fmu
from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")


def system(folder: Path, step: str) -> Path:
    """Return an SSD of one FMU whose step does this."""
    fmu = foreign_fmu(folder / "odd.fmu", Y + U, step=step)
    return write_ssd(folder / "s.ssd", {"c": fmu}, [], stop=1.0)


def test_a_status_that_fmi_does_not_have_is_an_error(tmp_path: Path) -> None:
    """Neither taken for OK (below 0) nor for one of the master's own signs."""
    for status in (-1, 6, 17):
        folder = tmp_path / str(status)
        folder.mkdir()
        scenario = Scenario(str(system(folder, f"if(m->t>0.0105) return {status};")), step=1e-3)
        outcome = run_scenario(scenario, folder, Report(picture=False))
        assert outcome.error is not None
        assert "c: doStep returned a status that FMI does not have" in outcome.error


def test_numbers_out_of_range_are_one_sentence() -> None:
    for wrong in (
        {"duration": 1e300}, {"step": 1e-300}, {"record_every": 10**20}, {"record_every": 0}, {"timeout": 1e10},
        {"step": float("nan")}, {"timeout": -1.0},
    ):  # fmt: skip
        with pytest.raises(InputError, match=next(iter(wrong)) if "step" not in wrong else "step"):
            Settings(**{"step": 1e-3, "duration": 1.0, **wrong})  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"seed = -1: must be >= 0"):
        Scenario("case1", seed=-1).prepare()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("step", "code", "sentence"),
    [
        ("if(m->t>0.5) exit(0);", 1, "ended the process by exit(0)"),
        ("if(m->t>0.5) exit(3);", 1, "ended the process by exit(3)"),
        ("if(m->t>0.5) abort();", -signal.SIGABRT, "crashed (SIGABRT)"),
        ("if(m->t>0.5) *(volatile int *)8=1;", -signal.SIGSEGV, "crashed (SIGSEGV)"),
    ],
)
def test_who_ends_the_process_is_named(tmp_path: Path, step: str, code: int, sentence: str) -> None:
    arguments = ("run", str(system(tmp_path, step)), "--step", "1e-3", "--out", str(tmp_path / "r"), "--json")
    done = curvesqueal(*arguments)
    assert done.returncode == code, done.stderr
    assert f"the FMU {tmp_path / 'odd.fmu'} {sentence}" in done.stderr
    with open_results(tmp_path / "r" / "system.nc") as data:
        assert data.sizes["time"] >= 1


@pytest.mark.slow
@pytest.mark.parametrize("signals", [1, 2])
def test_slow_fmus_are_stopped(tmp_path: Path, signals: int) -> None:
    """0.3 s a step, recorded every 1e8 steps: Ctrl-C ends after the step; a second one in the middle of a call."""
    nap = "struct timespec p={%s,300000000};while(nanosleep(&p,&p));"  # goes on after a signal
    ssd = system(tmp_path, nap % (0 if signals == 1 else 60))
    source = [sys.executable, "-m", "orchestrator", "run", str(ssd), "--step", "1e-3", "--record-every", "100000000"]
    with subprocess.Popen(
        [*source, "--out", str(tmp_path / "r"), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        limit = time.monotonic() + 60
        while not (tmp_path / "r" / "system.nc").exists() and time.monotonic() < limit:
            time.sleep(0.1)
        time.sleep(2.0)
        begin = time.monotonic()
        for _ in range(signals):
            process.send_signal(signal.SIGINT)
            time.sleep(0.5)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    if signals == 1:
        assert json.loads(out)["completed"] is False
    else:
        assert "stopped at once" in err
        assert time.monotonic() - begin < 10.0


@pytest.mark.slow
def test_an_array_of_thirty_million_is_refused(tmp_path: Path) -> None:
    from fmi3_fmu import StateSpace, state_space_fmu  # noqa: PLC0415

    file = state_space_fmu(tmp_path, "lag", StateSpace([[-10.0]], [[5.0]], [[1.0]]))
    fmu = open_fmu(file).resized({"order": 30_000_000})
    with pytest.raises(InputError, match="variables, elements of arrays counted; refused"):
        _ = fmu.variables
