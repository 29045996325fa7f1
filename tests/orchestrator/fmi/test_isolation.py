"""Each FMU in a process of its own: the same numbers, and an FMU that crashes or hangs is an error with a sentence."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import StateSpace, needs_compiler, state_space_fmu, write_ssd
from numpy.typing import NDArray
from toy_fmus import toy_fmu, toy_ssd

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.fmi.isolation_answers import Answer, pack, unpack
from orchestrator.results.file import open_results
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

LAG = StateSpace([[-10.0]], [[5.0]], [[1.0]])


def two_lags(folder: Path, fault: int = 0) -> System:
    """Return two first-order lags in a ring; the second misbehaves from its fourth step on."""
    file = state_space_fmu(folder, "lag", LAG)
    ssd = write_ssd(folder / "ring.ssd", {"a": file, "b": file}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])
    return read_system(ssd).with_parameters({"a": {"x0": "1"}, "b": {"fault": fault, "fault_step": 4}})


def last_outputs(system: System, settings: Settings) -> NDArray[np.float64]:
    """Run and return the outputs at the end."""
    with Master(assemble(system), settings) as master:
        master.run()
        return np.array(master.plan.y)


@needs_compiler
@pytest.mark.parametrize("algorithm", ["staggered", "iterative"])
def test_isolated_run_is_the_same_run(tmp_path: Path, algorithm: str) -> None:
    """FMI 3.0, states included: to the bit."""
    system = two_lags(tmp_path)
    here = last_outputs(system, Settings(0.01, 0.2, algorithm))
    there = last_outputs(system, Settings(0.01, 0.2, algorithm, timeout=30.0))
    np.testing.assert_array_equal(there, here)


@pytest.mark.slow
def test_isolated_fmi_2_run_is_the_same_run(built: Path) -> None:
    """The three components of Case 1, mobilities from scratch instances in processes, too."""
    system = read_system(built / "curvesqueal.ssp")
    here = last_outputs(system, Settings(5e-6, 2e-4))
    there = last_outputs(system, Settings(5e-6, 2e-4, timeout=60.0))
    np.testing.assert_array_equal(there, here)


@needs_compiler
def test_a_crash_is_an_error(tmp_path: Path) -> None:
    with (
        Master(assemble(two_lags(tmp_path, fault=6)), Settings(0.01, 1.0, timeout=30.0)) as master,
        pytest.raises(SimulationError, match=r"b: doStep returned fatal at t = 0.03 s: its process died of SIGSEGV"),
    ):
        master.run()
    assert master.progress.steps == 3


@needs_compiler
def test_a_hang_is_an_error_after_the_time_limit(tmp_path: Path) -> None:
    with Master(assemble(two_lags(tmp_path, fault=7)), Settings(0.01, 1.0, timeout=2.0)) as master:
        begin = time.monotonic()
        with pytest.raises(SimulationError, match=r"b: doStep returned fatal at t = 0.03 s: did not answer within 2 s"):
            master.run()
    assert time.monotonic() - begin < 15


@needs_compiler
@pytest.mark.parametrize(
    ("fault", "sentence"),
    [
        (1, r"b: doStep returned discard at t = 0.03 s: fault on demand"),
        (3, r"b: doStep returned fatal at t = 0.03 s: fault on demand"),
        (4, r"b: output y\[1\] = nan at t = 0.03 s"),
    ],
)
def test_faults_are_told_as_without_isolation(tmp_path: Path, fault: int, sentence: str) -> None:
    with (
        Master(assemble(two_lags(tmp_path, fault)), Settings(0.01, 1.0, timeout=30.0)) as master,
        pytest.raises(SimulationError, match=sentence),
    ):
        master.run()


def test_an_fmu_that_ends_its_process_is_an_error(tmp_path: Path) -> None:
    first = toy_fmu(tmp_path, "Good", "self.y = 0.0")
    second = toy_fmu(tmp_path, "Dying", "import os; os._exit(7)")
    system = read_system(toy_ssd(tmp_path, first, second))
    with (
        Master(assemble(system), Settings(1e-3, 0.1, "jacobi", timeout=30.0)) as master,
        pytest.raises(
            SimulationError, match=r"b: doStep returned fatal .*its process ended by itself with exit code 7"
        ),
    ):
        master.run()


@needs_compiler
def test_on_the_command_line(tmp_path: Path) -> None:
    """A crash with --isolate: one sentence, exit code 1, results up to then."""
    two_lags(tmp_path)
    command = [sys.executable, "-m", "orchestrator", "run", str(tmp_path / "ring.ssd"), "--step", "0.01", "--isolate"]
    command += ["--duration", "0.2", "--set", "b.fault=6", "--set", "b.fault_step=9", "--record-every", "1", "--json"]
    command += ["--timeout", "30", "--out", str(tmp_path / "r")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=180)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "b: doStep returned fatal at t = 0.08 s: its process died of SIGSEGV; results up to" in done.stderr
    with open_results(Path(json.loads(done.stdout)["results"])) as data:
        assert data.sizes["time"] == 9


def test_time_limit_must_be_positive() -> None:
    with pytest.raises(InputError, match="timeout = -1 s: must be > 0"):
        Settings(1e-3, 1.0, timeout=-1.0)


EVIL = """
import gc
import os
from multiprocessing.connection import Connection


class Evil:
    def __reduce__(self):
        return os.mkdir, ({path!r},)


for each in gc.get_objects():
    if isinstance(each, Connection):
        each.{send}
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("send", "sentence"),
    [
        ("send(Evil())", "its process gave no answer to do_step that can be read"),
        ("send_bytes(b'fmu1' + bytes(4) + b'[0, null, []]')", "its process gave no answer to do_step that can be read"),
    ],
)
def test_what_the_process_of_an_fmu_answers_is_not_run(tmp_path: Path, send: str, sentence: str) -> None:
    """The FMU speaks for its process: with a pickle that makes a folder, and with an answer that is cut."""
    made = tmp_path / "made"
    first = toy_fmu(tmp_path, "Plain", "self.y = 0.0")
    second = toy_fmu(tmp_path, f"Evil{len(send)}", EVIL.format(path=str(made), send=send))
    system = read_system(toy_ssd(tmp_path, first, second))
    with (
        Master(assemble(system), Settings(1e-3, 0.1, "jacobi", timeout=30.0)) as master,
        pytest.raises(SimulationError, match=sentence),
    ):
        master.run()
    assert not made.exists()


@pytest.mark.parametrize(
    ("call", "answer"),
    [
        ("get", [0, None, []]), ("get", [0, [[1.0]], []]), ("get_state", [0, -1, []]), ("get_state", [0, True, []]),
        ("do_step", [0, [True, True, True], []]), ("set", [0, [1.0], []]), ("ended", [0, 1, []]), ("set", [0, None]),
        ("set", [0.0, None, []]), ("set", [0, None, [1]]), ("set", {}), ("set", 0),
    ],
)  # fmt: skip
def test_an_answer_of_another_kind_is_none(call: str, answer: object) -> None:
    text = json.dumps(answer).encode()
    with pytest.raises(ValueError, match="answer"):
        unpack(b"fmu1" + len(text).to_bytes(4, "little") + text, call)


def test_bytes_that_are_no_answer_are_none() -> None:
    whole = pack(Answer(0, [1.0, float("nan"), -0.0, 5e-324, True, "ä"], ["said"]))
    found = unpack(whole, "get").result
    assert repr(found) == repr([1.0, float("nan"), -0.0, 5e-324, True, "ä"])
    for k in range(len(whole)):
        with pytest.raises(ValueError, match=r"."):
            unpack(whole[:k], "get")
