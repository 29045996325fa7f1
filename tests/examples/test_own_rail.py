"""The rail by hand in `examples/own_rail`: it runs through its SSD and is the modal rail that it should be."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fmus.modal.modes import Modes
from fmus.packaging.build import SSP_NAME
from fmus.packaging.python.fmu import build_python_fmu
from fmus.rail.component import rail
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.probing.mobility import published_mobility
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.runs.scenario import Scenario
from orchestrator.system.reader import read_system

EXAMPLE = Path(__file__).parents[2] / "examples" / "own_rail"
SSD = Path(__file__).parents[2] / "ssp" / "SystemStructure.ssd"
STEP = 5e-6
AXES = {"lon": ("X", 1e-3), "lat": ("Y", -1e-3), "ver": ("Z", -1e-3), "spin": ("Yaw", -1.0)}
"""The rail's own axis of each direction, and what turns its speed into the contract's."""

RAIL = {
    "lon": (300.0, 3.0e5, 3.0e7),
    "lat": (60.0, 6.0e4, 2.0e7),
    "ver": (150.0, 1.0e5, 1.1e8),
    "spin": (0.5, 1.5e3, 1e6),
}
"""Mass, damping and stiffness that the example states."""


@pytest.fixture(scope="module")
def folder(built: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with the example as its README builds it."""
    target = tmp_path_factory.mktemp("own_rail")
    for file in EXAMPLE.iterdir():
        shutil.copy(file, target)
    for name in ("wheel.fmu", "contact.fmu"):
        shutil.copy(built / name, target)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "own_rail.py"]
    subprocess.run(command, cwd=target, check=True, capture_output=True, timeout=60)
    return target


def equivalent_modes() -> Modes:
    """Return the modes of the four oscillators: omega^2 = k / m, zeta = c / (2 sqrt(k m)), shape 1 / sqrt(m)."""
    m, c, k = np.array([RAIL[d] for d in AXES]).T
    return Modes(np.sqrt(k / m), c / (2 * np.sqrt(k * m)), np.diag(1 / np.sqrt(m)))


def test_it_takes_some_40_lines() -> None:
    assert len((EXAMPLE / "own_rail.py").read_text(encoding="utf-8").splitlines()) <= 40


def test_through_its_ssd_it_is_the_equivalent_modal_rail(folder: Path, built: Path, tmp_path: Path) -> None:
    """8 ms of Case 1: the midpoint rule's error is (s h)^2 / 12 of a pole s; 1e-5 at 2 kHz, 5e-5 is asked."""
    modal = build_python_fmu(rail(equivalent_modes()), tmp_path / "modal.fmu", "0")
    records: list[dict[str, np.ndarray]] = []
    for scenario in (
        Scenario(str(folder / "own_rail.ssd"), duration=8e-3, record_every=1),
        Scenario(str(built / SSP_NAME), duration=8e-3, record_every=1, sources={"rail": modal}),
    ):
        path = tmp_path / f"{len(records)}.nc"
        assembly, settings = scenario.prepare()
        with Master(assembly, settings) as master, ResultsFile(path, master.signals(), {}) as results:
            progress = master.run(results)
            assert progress.steps == 1600
        with open_results(path) as data:
            records.append({name: data[name].to_numpy() for name in map(str, data)})
    own, reference = records
    for direction in ("lat", "ver"):
        axis, factor = AXES[direction]
        expected = reference[f"rail.v_{direction}"]
        assert np.abs(expected).max() > 1e-5
        found = factor * own[f"rail.speed{axis}"]
        assert np.abs(found - expected).max() <= 5e-5 * np.abs(expected).max()
        wheel = reference[f"wheel.v_{direction}"]
        assert np.abs(own[f"wheel.v_{direction}"] - wheel).max() <= 5e-5 * np.abs(wheel).max()


def test_the_master_measures_its_mobility(folder: Path) -> None:
    """Through the SSD's units and signs: one step of the midpoint rule, h / (m + h c / 2 + h^2 k / 4)."""
    assembly = assemble(read_system(folder / "own_rail.ssd"))
    with Master(assembly, Settings(STEP, STEP)) as master:
        total = master.parameters["contact"]
    of_wheel = published_mobility(assembly.fmus["wheel"], {"step_size": STEP})
    assert of_wheel is not None
    for j, direction in enumerate(AXES):
        m, c, k = RAIL[direction]
        share = STEP / (m + STEP * c / 2 + STEP**2 * k / 4)
        found = float(total[f"mobility_{direction}_{direction}"]) - of_wheel[j, j]
        assert found == pytest.approx(share, rel=1e-9)


def test_the_ssd_is_case_1_but_for_the_rail(folder: Path) -> None:
    """Nobody changes the contract without the example noticing: the same wires, all names but the rail's equal."""
    own, paper = (read_system(path) for path in (folder / "own_rail.ssd", SSD))
    assert len(own.wires) == len(paper.wires)
    for mine, theirs in zip(own.wires, paper.wires, strict=True):
        assert (mine.start_element, mine.end_element) == (theirs.start_element, theirs.end_element)
        if theirs.start_element != "rail":
            assert mine.start_connector == theirs.start_connector
        if theirs.end_element != "rail":
            assert mine.end_connector == theirs.end_connector
