"""Faults around a run: full disk, a crash in this process, signals. Message, exit code, results that can be read."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import StateSpace, needs_compiler, state_space_fmu, write_ssd

from orchestrator.results.file import open_results


def ring(folder: Path) -> Path:
    """Return an SSD of two first-order lags in a ring, small and fast."""
    file = state_space_fmu(folder, "lag", StateSpace([[-10.0]], [[5.0]], [[1.0]]))
    return write_ssd(folder / "ring.ssd", {"a": file, "b": file}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])


def run(*arguments: str, prepare: Callable[[], None] | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command line in a process of its own."""
    command = [sys.executable, "-m", "orchestrator", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=180, preexec_fn=prepare)


def small_files() -> None:
    """Let no file grow beyond 200 kB: writing more fails as on a full disk."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))


def no_core() -> None:
    """Let a crash leave no core file."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


@needs_compiler
def test_a_full_disk_ends_the_run_in_order(tmp_path: Path) -> None:
    """What fits is kept and summed up; the sentence says what went wrong and where the results are."""
    arguments = ("run", str(ring(tmp_path)), "--step", "1e-3", "--duration", "100", "--record-every", "1", "--json")
    done = run(*arguments, "--out", str(tmp_path / "r"), prepare=small_files)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "cannot write results: File too large; results up to then are in" in done.stderr, done.stderr
    data = json.loads(done.stdout)
    assert data["completed"] is False
    with open_results(Path(data["results"])) as results:
        assert results.sizes["time"] > 500
        steps = results["time"].to_numpy()
        np.testing.assert_allclose(steps, 1e-3 * np.arange(steps.size))


@needs_compiler
def test_a_checkpoint_that_cannot_be_written_is_a_sentence(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("no folder")
    arguments = ("run", str(ring(tmp_path)), "--step", "1e-3", "--duration", "1", "--out", str(tmp_path / "r"))
    done = run(*arguments, "--checkpoint", str(blocked / "c"))
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "cannot be written: File exists" in " ".join(done.stderr.split())
    with open_results(tmp_path / "r" / "system.nc") as data:
        assert data.sizes["time"] == 0  # it is found out before the first step


@needs_compiler
def test_a_crash_in_this_process_leaves_readable_results(tmp_path: Path) -> None:
    """Without --isolate a crash takes the master along; what was recorded before is there."""
    arguments = ("run", str(ring(tmp_path)), "--step", "1e-3", "--duration", "500", "--out", str(tmp_path / "r"))
    done = run(*arguments, "--set", "b.fault=6", "--set", "b.fault_step=100000", prepare=no_core)
    assert done.returncode == -signal.SIGSEGV
    with open_results(tmp_path / "r" / "system.nc") as data:
        assert data.sizes["time"] > 1000
        assert np.isfinite(data["a.y[1]"].to_numpy()).all()


@needs_compiler
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_isolated_run_stops_in_order(tmp_path: Path, number: signal.Signals) -> None:
    command = [sys.executable, "-m", "orchestrator", "run", str(ring(tmp_path)), "--step", "1e-3", "--json"]
    command += ["--duration", "1000", "--isolate", "--timeout", "60", "--out", str(tmp_path / "r")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        path = tmp_path / "r" / "system.nc"
        limit = time.monotonic() + 120
        while not (path.exists() and path.stat().st_size > 3000) and time.monotonic() < limit:
            time.sleep(0.1)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "Traceback" not in err
    assert "stopped; results up to then are in" in err
    assert json.loads(out)["completed"] is False
