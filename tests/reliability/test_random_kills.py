"""Runs that are killed through the command line, again and again, end with the bits of a run that never was."""

from __future__ import annotations

import json
import random
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from damaged_files import numbers
from figures import count, write_figure
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu, write_ssd

pytestmark = [pytest.mark.slow, pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")]

SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
STEPS = 6_000_000
IN_A_ROW = 5
"""Kills of one run before it may end."""

LONGEST = 1.2
"""Longest life of a run after its first checkpoint [s]."""

CURVESQUEAL = [sys.executable, "-m", "orchestrator"]


def first_run(ssd: Path, out: Path) -> list[str]:
    options = ["--step", "1e-3", "--duration", str(STEPS * 1e-3), "--record-every", "1000", "--json"]
    return [*CURVESQUEAL, "run", str(ssd), *options, "--out", str(out)]


def finished(command: list[str]) -> Path:
    """Let a command run to its end and return its results."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert (data["steps"], data["completed"]) == (STEPS, True)
    return Path(data["results"])


def killed(command: list[str], checkpoint: Path, number: signal.Signals, dice: random.Random) -> bool:
    """Kill a command at a random moment after it wrote a checkpoint; return whether it was still there."""
    before = checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        limit = time.monotonic() + 300
        while process.poll() is None and time.monotonic() < limit:
            if checkpoint.exists() and checkpoint.stat().st_mtime_ns != before:
                break
            time.sleep(0.01)
        time.sleep(dice.uniform(0.0, LONGEST))
        there = process.poll() is None
        process.send_signal(number)
        _, err = process.communicate(timeout=60)
    assert "Traceback" not in err, err
    assert process.returncode in ({0, -signal.SIGKILL} if number == signal.SIGKILL else {0, 130}), err
    return there and process.returncode != 0


def test_finals_have_the_bits_of_a_run_that_was_never_killed(tmp_path: Path) -> None:
    fmu = state_space_fmu(tmp_path, "lag", StateSpace([[-10.0]], [[5.0]], [[1.0]]))
    ssd = write_ssd(tmp_path / "ring.ssd", {"a": fmu, "b": fmu}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])
    whole = numbers(finished(first_run(ssd, tmp_path / "whole")))
    wanted, dice, kills, finals = count(6, 200), random.Random(14), Counter[str](), 0
    while sum(kills.values()) < wanted:
        finals += 1
        checkpoint = tmp_path / f"{finals}.checkpoint"
        resume = [*CURVESQUEAL, "resume", str(checkpoint), "--checkpoint-every", "0", "--json"]
        begin = [*first_run(ssd, tmp_path / f"run{finals}"), "--checkpoint", str(checkpoint), "--checkpoint-every", "0"]
        for k in range(min(IN_A_ROW, wanted - sum(kills.values()))):
            number = dice.choice(SIGNALS)
            if not killed(resume if k else begin, checkpoint, number, dice):
                break
            kills[number.name] += 1
        assert numbers(finished(resume)) == whole
    each = ", ".join(f"{kills[s.name]} {s.name}" for s in SIGNALS)
    write_figure("kills through the command line, with checkpoints", f"{sum(kills.values())} kills ({each})",
                 f"{finals} of {finals} finals bit-identical")  # fmt: skip
