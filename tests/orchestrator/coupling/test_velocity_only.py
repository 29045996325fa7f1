"""Structures that exchange velocities and forces alone, as the paper's contract has it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np

from orchestrator.archive import unpack
from orchestrator.results.file import open_results
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.stability.linear_model import model_of_assembly
from orchestrator.stability.scheme import growth_of_scheme

QUIET = Report(picture=False)


def system_without(folder: Path, native: Path, *sides: str) -> str:
    """Write the system of Case 1 without the displacements of some sides; return the SSD."""
    inside = unpack(native / "curvesqueal.ssp", "SSP")
    text = (inside / "SystemStructure.ssd").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if not any(f'endConnector="{s}_u_' in line for s in sides)]
    ssd = folder / f"without-{'-'.join(sides)}.ssd"
    ssd.write_text("\n".join(lines), encoding="utf-8")
    shutil.copytree(inside / "resources", folder / "resources", dirs_exist_ok=True)
    return str(ssd)


def lateral(scenario: Scenario, folder: Path) -> np.ndarray:
    with open_results(run_scenario(scenario, folder, QUIET).results) as data:
        return np.asarray(data["wheel.v_lat"])


def test_a_rail_without_displacements_is_coupled_rightly_by_itself(tmp_path: Path, native: Path) -> None:
    """Within 1 % of the same rail with displacements over 50 ms of Case 1; a rigid one differs by 35 % and more."""
    plain = lateral(Scenario(str(native / "curvesqueal.ssp"), duration=0.05), tmp_path)
    scenario = Scenario(system_without(tmp_path, native, "rail"), duration=0.05)
    said: list[str] = []
    with open_results(run_scenario(scenario, tmp_path, Report(notice=said.append, picture=False)).results) as data:
        found = np.asarray(data["wheel.v_lat"])
    assert [text for text in said if "displacement" in text] == [
        "rail gives no displacements; the contact integrates its velocities"
    ]
    assert not any("rail_u_" in text for text in said)
    assert np.abs(found - plain).max() < 0.01 * np.abs(plain).max()


def test_both_sides_without_displacements_are_the_contact_that_takes_none(tmp_path: Path, native: Path) -> None:
    each = lateral(Scenario(system_without(tmp_path, native, "wheel", "rail"), duration=0.01), tmp_path)
    values = {"contact": {"use_displacements": False}}
    both = lateral(Scenario(str(native / "curvesqueal.ssp"), duration=0.01, values=values), tmp_path)
    np.testing.assert_allclose(each, both, atol=1e-9 * np.abs(both).max())


def test_the_figure_of_the_scheme_knows_it(tmp_path: Path, native: Path) -> None:
    """The sum of velocities is a rectangle rule: at 10 us it moves growth rates, by less than the figure of Jacobi."""
    rates = []
    for system, sides in ((system_without(tmp_path, native, "rail"), ("rail",)), (str(native / "curvesqueal.ssp"), ())):
        model = model_of_assembly(Scenario(system, step=1e-5).prepare()[0], 1e-5)
        assert model.integrated == sides
        modes = growth_of_scheme(model, 1e-5, "staggered").modes
        assert modes.invented == 0
        rates.append(modes.discrete)
    assert 1e-4 < np.abs(rates[0] - rates[1]).max() < 5.0
