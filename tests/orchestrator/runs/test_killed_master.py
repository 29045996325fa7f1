"""A master that is killed leaves no process behind: not those of isolated FMUs, nor those of a campaign."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import U, Y, foreign_fmu
from table_fmus import COMPILER

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc"),
]
PATIENCE = 60.0


def descendants(pid: int) -> set[int]:
    """Return the processes that a process has begun, and theirs."""
    parents: dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                parents[int(entry.name)] = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            except (OSError, ValueError):
                continue
    found, new = set[int](), {pid}
    while new:
        new = {child for child, parent in parents.items() if parent in new} - found
        found |= new
    return found


def alive(pids: set[int]) -> set[int]:
    """Return those that are there and no zombies."""
    left = set()
    for pid in pids:
        try:
            if Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z":
                left.add(pid)
        except OSError:
            continue
    return left


def wait_until(true: Callable[[], bool]) -> None:
    limit = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < limit
        time.sleep(0.1)


def killed(command: list[str], folder: Path, working: Callable[[int], bool]) -> set[int]:
    """Kill a command once it works; return the processes that it had."""
    environment = {**os.environ, "TMPDIR": str(folder)}
    source = [sys.executable, "-m", "orchestrator", *command]
    with (
        (folder / "err").open("w") as err,
        subprocess.Popen(source, stdout=err, stderr=err, env=environment) as process,
    ):
        wait_until(lambda: working(process.pid))
        found = descendants(process.pid)
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
    return found


@pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")
@pytest.mark.parametrize("step", ["", "struct timespec p={600,0};while(nanosleep(&p,&p));", "for(;;);"])
def test_no_process_of_an_isolated_fmu_is_left(tmp_path: Path, step: str) -> None:
    """Waiting for the next call, asleep in a call, busy in a call."""
    began = tmp_path / "began"
    note = f'if(m->t>0.01){{FILE *f=fopen("{began}","w");fclose(f);{step}}}'
    fmu = foreign_fmu(tmp_path / "slow.fmu", Y + U, step=note)
    ssd = write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, [("a.y", "b.u")], stop=1e6)
    command = ["run", str(ssd), "--step", "1e-3", "--isolate", "--timeout", "3000", "--out", str(tmp_path / "r")]
    found = killed(command, tmp_path, lambda _pid: began.exists())
    assert len(found) >= 2
    wait_until(lambda: not alive(found))


def test_no_worker_of_a_campaign_is_left(tmp_path: Path) -> None:
    """Killed when its workers are there: a server of processes, and two workers that it has made."""
    command = ["competition", "case1", "--runs", "50", "--duration", "6", "--jobs", "2", "--out", str(tmp_path)]
    found = killed(command, tmp_path, lambda pid: len(descendants(pid)) >= 4)
    wait_until(lambda: not alive(found))
