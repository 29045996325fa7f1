"""Files that are cut or have a flipped bit: a sentence, the same numbers, or a notice; and where a format cannot tell.

Results and checkpoints have checksums, archives those of zip. SSD, SSV, TOML, CSV and universal files are plain text: a
digit that became another digit is a number like any other.
"""

from __future__ import annotations

import hashlib
import random
import shutil
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from figures import count, write_figure
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu
from frf_files import write_uff

from fmus.cache import _root
from fmus.errors import DataError
from fmus.measured.read import read_contents
from fmus.modal.data import read_modal_data
from fmus.rail import shipped
from fmus.wheel.imported import CSV_COLUMNS, read_modes
from orchestrator.errors import DamageWarning, InputError
from orchestrator.fmi.file import open_fmu
from orchestrator.results.file import open_results
from orchestrator.runs.checkpoint import read_checkpoint
from orchestrator.runs.identity import identity
from orchestrator.runs.run import Keeping, Report, run_scenario
from orchestrator.runs.scenario import Scenario

pytestmark = [pytest.mark.slow, pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")]

Read = Callable[[Path], tuple[Any, Any]]
"""A file in, what it says and the notices out."""


def digest(value: Any) -> str:
    """Return a hash of numbers, texts and what is made of them."""
    found = hashlib.sha256()

    def add(each: Any) -> None:
        if isinstance(each, np.ndarray):
            found.update(repr((each.shape, each.dtype.str)).encode() + np.ascontiguousarray(each).tobytes())
        elif is_dataclass(each) and not isinstance(each, type):
            for one in fields(each):
                add(getattr(each, one.name))
        elif isinstance(each, dict):
            for key in sorted(each, key=str):
                add(key)
                add(each[key])
        elif isinstance(each, list | tuple):
            found.update(f"{len(each)}:".encode())
            for one in each:
                add(one)
        elif not isinstance(each, Path):
            found.update(f"{type(each).__name__} {each!r};".encode())

    add(value)
    return found.hexdigest()


def of_results(path: Path) -> tuple[Any, Any]:
    with open_results(path) as data:
        loaded = data.load()
        return {str(n): v.to_numpy() for n, v in loaded.variables.items()}, ()


def of_checkpoint(path: Path) -> tuple[Any, Any]:
    kept = read_checkpoint(path)
    return (kept.states, kept.numbers, kept.steps, kept.rows, kept.run, kept.resolved), ()


def of_fmu(path: Path) -> tuple[Any, Any]:
    fmu = open_fmu(path)
    binaries = [file.read_bytes() for file in sorted((fmu.folder / "binaries").rglob("*")) if file.is_file()]
    return (binaries, fmu.variables, {k: str(v) for k, v in fmu.dependencies().items()}, fmu.version), fmu.faults


def of_system(path: Path, ssd: Path | None = None) -> tuple[Any, Any]:
    assembly, settings = Scenario(str(ssd or path), step=0.01).prepare()
    return identity(assembly, settings), assembly.notices


def in_system(ssd: Path) -> Read:
    return partial(of_system, ssd=ssd)


SSD = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="ring">
  <ssd:System name="root"><ssd:Elements>
    <ssd:Component name="a" source="lag.fmu"><ssd:ParameterBindings>
      <ssd:ParameterBinding source="values.ssv"/></ssd:ParameterBindings></ssd:Component>
    <ssd:Component name="b" source="lag.fmu"/></ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="a" startConnector="y[1]" endElement="b" endConnector="u[1]"/>
      <ssd:Connection startElement="b" startConnector="y[1]" endElement="a" endConnector="u[1]">
        <ssc:LinearTransformation factor="0.5" offset="1.25"/></ssd:Connection>
    </ssd:Connections>
  </ssd:System>
  <ssd:DefaultExperiment startTime="0" stopTime="0.5"/>
</ssd:SystemStructureDescription>
"""

SSV = """<?xml version="1.0" encoding="UTF-8"?>
<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" name="values">
  <ssv:Parameters><ssv:Parameter name="x0"><ssv:Real value="1.5"/></ssv:Parameter></ssv:Parameters>
</ssv:ParameterSet>
"""


RAIL = Path(shipped.__file__).parent / "data" / "rail.toml"


def modal_csv(path: Path) -> Path:
    """Write the modes of the rail as a table; they move in every direction."""
    modes = read_modal_data(RAIL).modes
    rows = sorted(zip((modes.omega / (2 * np.pi)).tolist(), modes.zeta.tolist(), modes.shape.tolist(), strict=True))
    lines = [f"mode {k},{f!r},{zeta!r},{','.join(map(repr, shape))}" for k, (f, zeta, shape) in enumerate(rows)]
    path.write_text("\n".join([",".join(CSV_COLUMNS), *lines, ""]), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Read]]:
    """Return a whole file of each kind and what reads it."""
    folder = tmp_path_factory.mktemp("whole")
    fmu = state_space_fmu(folder, "lag", StateSpace([[-10.0]], [[5.0]], [[1.0]]))
    ssd, ssv, ssp = folder / "ring.ssd", folder / "values.ssv", folder / "ring.ssp"
    ssd.write_text(SSD, encoding="utf-8")
    ssv.write_text(SSV, encoding="utf-8")
    with zipfile.ZipFile(ssp, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("SystemStructure.ssd", SSD)
        archive.write(ssv, "values.ssv")
        archive.write(fmu, "lag.fmu")
    scenario = Scenario(str(ssd), step=0.01, record_every=1)
    run = run_scenario(scenario, folder / "r", Report(picture=False), Keeping(folder / "run.checkpoint"))
    assert run.progress.steps == 50
    return {
        "results": (run.results, of_results),
        "checkpoint": (folder / "run.checkpoint", of_checkpoint),
        "FMU": (fmu, of_fmu),
        "SSP": (ssp, of_system),
        "SSD": (ssd, of_system),
        "SSV": (ssv, in_system(ssd)),
        "modal TOML": (RAIL, lambda path: (read_modal_data(path), ())),
        "modal CSV": (modal_csv(folder / "modes.csv"), lambda path: (read_modes(path), ())),
        "UFF": (write_uff(folder / "m.uff", [{}]), lambda path: (read_contents(path), ())),
    }


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Keep what is unpacked of damaged archives apart."""
    monkeypatch.setenv("CURVESQUEAL_CACHE", str(tmp_path / "cache"))
    yield
    _root.cache_clear()
    shutil.rmtree(tmp_path, ignore_errors=True)


def damaged(data: bytes, number: int, dice: random.Random) -> bytes:
    """Return the data cut at a random place, or with one bit flipped."""
    place = dice.randrange(len(data))
    if number % 2:
        return data[:place]
    return data[:place] + bytes([data[place] ^ (1 << dice.randrange(8))]) + data[place + 1 :]


def outcome(read: Read, path: Path, whole: str, notices: Any) -> str:
    """Return what comes of a damaged file: refused, told, same or changed; any other exception is a fault."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            found, more = read(path)
        except (InputError, DataError):
            return "refused"
    if digest(found) == whole:
        return "same"
    told = any(issubclass(w.category, DamageWarning) for w in said) or tuple(more) != tuple(notices)
    return "told" if told else "changed"


CHECKED = ("results", "checkpoint", "FMU", "SSP")
TEXT = ("SSD", "SSV", "modal TOML", "modal CSV", "UFF")


@pytest.mark.parametrize("kind", [*CHECKED, *TEXT])
def test_cuts_and_flips(files: dict[str, tuple[Path, Read]], kind: str) -> None:
    path, read = files[kind]
    original = path.read_bytes()
    before, notices = read(path)
    whole, dice, seen = digest(before), random.Random(kind), Counter[str]()
    beside = path if kind == "SSV" else path.with_name(f"damaged{path.suffix}")
    times = count(60, 1000)
    try:
        for number in range(times):
            beside.write_bytes(damaged(original, number, dice))
            seen[outcome(read, beside, whole, notices)] += 1
    finally:
        if beside == path:
            path.write_bytes(original)
        else:
            beside.unlink()
    assert sum(seen.values()) == times
    assert seen["refused"] + seen["told"] > times / 5
    if kind in CHECKED:
        assert seen["changed"] == 0
    words = ", ".join(f"{seen[word]} {word}" for word in ("refused", "told", "same", "changed") if seen[word])
    write_figure(f"cuts and flipped bits, {kind}", f"{times:,} files", words)
