"""`resume` goes on with the run that the checkpoint was made of, with no other, and touches nothing before it knows."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu, write_ssd

from orchestrator.errors import InputError
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.runs.checkpoint import read_checkpoint
from orchestrator.runs.run import Keeping, Report, resume, run_scenario
from orchestrator.runs.scenario import Scenario

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the FMI 3.0 test FMU")

QUIET = Report(picture=False, trial=False)


class CutError(Exception):
    """Ends a run in the middle."""


def cut(_: object) -> None:
    raise CutError


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return an SSD of two lags in a ring beside their FMU."""
    folder = tmp_path_factory.mktemp("model")
    file = state_space_fmu(folder, "lag", StateSpace([[-10.0]], [[5.0]], [[1.0]]))
    return write_ssd(folder / "ring.ssd", {"a": file, "b": file}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])


@pytest.fixture
def half(model: Path, tmp_path: Path) -> Path:
    """Return the checkpoint of a run that was cut off, its model beside it."""
    shutil.copytree(model.parent, tmp_path / "m")
    scenario = Scenario(str(tmp_path / "m" / "ring.ssd"), step=1e-3, duration=30.0, record_every=1)
    with pytest.raises(CutError):
        run_scenario(scenario, tmp_path / "r", Report(cut, picture=False), Keeping(tmp_path / "c", 0.0))
    return tmp_path / "c"


def changed(checkpoint: Path, **what: Any) -> None:
    """Write other things into the head of a checkpoint."""
    with np.load(checkpoint) as data:
        arrays = {name: data[name] for name in data.files}
    head = json.loads(arrays["head"].tobytes()) | what
    arrays["head"] = np.frombuffer(json.dumps(head).encode(), dtype=np.uint8)
    with checkpoint.open("wb") as file:
        np.savez(file, **arrays)


def replaced(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new, 1)


WIRE = 'startElement="a" startConnector="y[1]" endElement="b" endConnector="u[1]"/>'
FACTOR = WIRE[:-2] + '><ssc:LinearTransformation factor="0.5"/></ssd:Connection>'
SET = (
    "</ssd:Connectors><ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>"
    '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="p">'
    '<ssv:Parameters><ssv:Parameter name="x0[1]"><ssv:Real value="2"/></ssv:Parameter></ssv:Parameters>'
    "</ssv:ParameterSet></ssd:ParameterValues></ssd:ParameterBinding></ssd:ParameterBindings>"
)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (replaced(WIRE, FACTOR), r"-> b\.u\[1\] was there with factor 1 and offset 0 and is there with factor 0\.5"),
        (replaced(f"<ssd:Connection {WIRE}", ""), r"connection a\.y\[1\] -> b\.u\[1\] was there .* and is not there"),
        (replaced("</ssd:Connectors>", SET), "component a has another FMU or other parameter"),
    ],
)  # fmt: skip
def test_another_system_is_refused(half: Path, change: Callable[[str], str], sentence: str) -> None:
    """A factor on a wire, a removed wire, another parameter set: one sentence, and no byte is changed."""
    ssd, results = half.parent / "m" / "ring.ssd", half.parent / "r" / "system.nc"
    assert change(ssd.read_text()) != ssd.read_text()
    ssd.write_text(change(ssd.read_text()))
    before = results.read_bytes()
    with pytest.raises(InputError, match=sentence):
        resume(half, QUIET)
    assert results.read_bytes() == before


@pytest.mark.parametrize("key", ["versions", "algorithm", "step", "steps", "start"])
def test_other_versions_and_settings_are_refused(half: Path, key: str) -> None:
    kept = read_checkpoint(half)
    other: Any = {**kept.resolved["versions"], "numpy": "1.0"} if key == "versions" else "another"
    changed(half, resolved={**kept.resolved, key: other})
    with pytest.raises(InputError, match=f"it is another one now: {key}"):
        resume(half, QUIET)


def test_a_crafted_checkpoint_touches_no_other_file(half: Path, tmp_path: Path) -> None:
    """Another run's results, results of no run, a file that is none: refused, not a byte changed."""
    other = run_scenario(read_checkpoint(half).scenario, tmp_path / "other", QUIET).results
    bare = tmp_path / "bare.nc"
    shutil.copy(other, bare)
    text = tmp_path / "text"
    text.write_bytes(b"CDF\x02" + bytes(100))
    for victim in (other, bare, text):
        before = victim.read_bytes()
        for rows in (0, 1, -5, 10**12):
            changed(half, results=str(victim), rows=rows, header=8)
            with pytest.raises(InputError):
                resume(half, QUIET)
        assert victim.read_bytes() == before


def test_one_resume_at_a_time(half: Path) -> None:
    """Who holds the results alone may go on; the lock of a killed process is gone."""
    results = half.parent / "r" / "system.nc"
    before = results.read_bytes()
    hold = (
        "import sys, time; from pathlib import Path; from orchestrator.results.locks import lock; "
        "f = Path(sys.argv[1]).open('r+b'); print(lock(f), flush=True); time.sleep(600)"
    )
    with subprocess.Popen([sys.executable, "-c", hold, str(results)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "True\n"
        with pytest.raises(InputError, match="another process is writing to these results"):
            resume(half, QUIET)
        process.kill()
    assert results.read_bytes() == before
    with open_results(resume(half, QUIET).results) as data:
        assert data.sizes["time"] == 30_001


def test_names_of_files_and_signals_are_plain(tmp_path: Path) -> None:
    """A file name has no separators, is never hidden, and never too long for a file system."""
    for name, stem in (("a/b", "a_b"), ("..", "_"), ("x" * 300, "x" * 200), ("\x1b[31m<b>", "_[31m_b_")):
        with ResultsFile.claim(tmp_path, name, [], {}) as file:
            assert file.path.name == f"{stem}.nc"
