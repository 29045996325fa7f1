"""Streams that are closed, break, are full, are no terminal or take few letters: the right exit code, no traceback."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from orchestrator.streams import BROKEN, INTERRUPTED

SHELL = shutil.which("bash")
pytestmark = pytest.mark.skipif(SHELL is None or os.name != "posix", reason="redirections of bash")
PLAIN = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


def shell(command: str, file: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which `cs` is the command line and $1 a file."""
    assert SHELL is not None
    text = f'set -o pipefail; cs() {{ "{sys.executable}" -m orchestrator "$@"; }}; {command}'
    done = subprocess.run(
        [SHELL, "-c", text, "bash", str(file)], capture_output=True, text=True, check=False, timeout=120,
        env={**os.environ, **variables}, cwd=file.parent, errors="replace",
    )  # fmt: skip
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    assert "Exception ignored" not in done.stderr
    return done


@pytest.mark.parametrize(
    ("command", "code", "said"),
    [
        ("cs info no.ssp 2>&-", 1, ""),
        ("cs info no.ssp >&- <&-", 1, "curvesqueal: "),
        pytest.param("cs run $(printf 'x%.0s' {1..5000}).ssp", 1, "File name too long", marks=pytest.mark.slow),
        pytest.param("cs run case1 --out $(printf 'x%.0s' {1..5000})", 1, "File name too long", marks=pytest.mark.slow),
        pytest.param("cs run case1 --duration 1e-3 --out $'o\\xff'", 1, "is not UTF-8", marks=pytest.mark.slow),
        pytest.param("cs --help >&-", 0, "", marks=pytest.mark.slow),
        pytest.param('cs info "$1" --json | head -c 10', BROKEN, "", marks=pytest.mark.slow),
        pytest.param('cs info "$1" 2>&1 | head -c 10', BROKEN, "", marks=pytest.mark.slow),
        pytest.param('cs info "$1" >&- 2>&-', 0, "", marks=pytest.mark.slow),
        pytest.param('cs info "$1" > /dev/full', 1, "No space left on device", marks=pytest.mark.slow),
        pytest.param('cs info "$1" --json > /dev/full', 1, "No space left on device", marks=pytest.mark.slow),
    ],
)
def test_streams_that_take_nothing(native: Path, command: str, code: int, said: str) -> None:
    done = shell(command, native / "wheel.fmu")
    assert done.returncode == code, done.stderr
    assert said in done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("variables", [{"TERM": "dumb"}, PLAIN, {**PLAIN, "PYTHONIOENCODING": "ascii:strict"}], ids=str)
def test_plain_terminals(tmp_path: Path, native: Path, variables: dict[str, str]) -> None:
    """A name with letters that the stream does not take is written with their numbers; the table is there."""
    file = tmp_path / "räder.fmu"
    shutil.copy(native / "contact.fmu", file)
    done = shell('cs info "$1"', file, **variables)
    assert done.returncode == 0, done.stderr
    assert "steady_creepage_lat" in done.stdout
    assert "\x1b" not in done.stdout


@pytest.mark.slow
def test_a_run_with_closed_streams_keeps_its_results_whole(tmp_path: Path) -> None:
    """Descriptors 0, 1 and 2 are closed: no file of the run takes their place and gets what is printed."""
    done = shell('cs run case2 --duration 0.002 --out "$1" --json <&- >&- 2>&-', tmp_path / "r")
    assert done.returncode == 0
    shown = shell('cs run case2 --duration 0.002 --out "$1" --json', tmp_path / "s")
    first, second = ((tmp_path / name / "case2.nc").read_bytes() for name in "rs")
    assert len(first) == len(second)
    assert first[-1000:] == second[-1000:]
    assert '"picture"' in shown.stdout


@pytest.mark.slow
def test_ctrl_c_while_it_starts() -> None:
    """At any moment of the first second: 130, or what Python itself says before it has read a line of this package."""
    codes = []
    for wait in (0.3, 0.6, 1.0, 1.5, 2.5):
        command = [sys.executable, "-m", "orchestrator", "run", "case1", "--duration", "100", "--out", os.devnull]
        with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
            time.sleep(wait)
            process.send_signal(signal.SIGINT)
            _, err = process.communicate(timeout=60)
        if process.returncode != -signal.SIGINT or "orchestrator" in err:  # else Python was not there yet
            assert "Traceback" not in err, err
            codes.append(process.returncode)
    assert codes
    assert set(codes) == {INTERRUPTED}
