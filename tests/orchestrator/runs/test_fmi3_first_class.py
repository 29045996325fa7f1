"""The project's own FMUs of FMI 3.0 against those of FMI 2.0: the same numbers, and no command says less of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.modal.parameters import modal_velocities
from orchestrator.results.file import open_results
from orchestrator.runs.outcome import Outcome
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.runs.starts import mode_start
from orchestrator.stability.linear_model import model_of, model_of_assembly
from orchestrator.stability.scheme import as_json
from orchestrator.system.inspection import describe

QUIET = Report(picture=False)


def run(system: Path, folder: Path, **how: object) -> Outcome:
    return run_scenario(Scenario(str(system), duration=0.01, **how), folder, QUIET)  # type: ignore[arg-type]


@pytest.mark.parametrize("algorithm", ["staggered", "jacobi", "iterative"])
def test_runs_are_the_same_and_so_is_what_they_tell(
    native: Path, native3: Path, tmp_path: Path, algorithm: str
) -> None:
    """To 1e-12 of the largest value, modal velocities included; a random start sets arrays element by element."""
    pair = [run(folder / "curvesqueal.ssp", tmp_path, algorithm=algorithm, seed=3) for folder in (native, native3)]
    with open_results(pair[0].results) as two, open_results(pair[1].results) as three:
        names = [modal_velocities("wheel", data.data_vars) for data in (two, three)]
        assert len(names[0]) == len(names[1]) == 122
        columns = [*zip(*names, strict=True), *((n, n) for n in ("wheel.v_lat", "rail.v_ver", "contact.normal_force"))]
        for first, second in columns:
            expected, found = np.asarray(two[first]), np.asarray(three[second])
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())
        poles = [model_of(data).poles for data in (two, three)]
        np.testing.assert_allclose(poles[1].growth_rate, poles[0].growth_rate, rtol=1e-9, atol=1e-6)
    assert pair[0].spurious.largest == pytest.approx(pair[1].spurious.largest, rel=1e-9)
    assert pair[0].spurious.sentence == pair[1].spurious.sentence
    assert pair[0].verdict.sentence == pair[1].verdict.sentence


def test_one_structure_of_fmi_3_among_fmi_2_changes_no_figure(native: Path, native3: Path) -> None:
    """A rail or wheel of FMI 3.0 was once taken as rigid: eight stable modes were said to become unstable."""
    tables = []
    for sources in ({}, {"rail": native3 / "rail.fmu"}, {"wheel": native3 / "wheel.fmu"}):
        scenario = Scenario(str(native / "curvesqueal.ssp"), step=1e-5, sources=sources)
        model = model_of_assembly(scenario.prepare()[0], 1e-5)
        assert model.identified == ()
        tables.append(as_json(model, 1e-5)["jacobi"])
    for table in tables[1:]:
        assert table["stable_modes_made_unstable"] == tables[0]["stable_modes_made_unstable"]
        assert table["max_growth_rate_error"] == pytest.approx(tables[0]["max_growth_rate_error"], rel=1e-9)


def test_a_start_on_a_mode_and_the_description_know_arrays(native: Path, native3: Path) -> None:
    starts = []
    for folder in (native, native3):
        fmu = Scenario(str(folder / "curvesqueal.ssp")).prepare()[0].fmus["wheel"]
        starts.append(list(mode_start(fmu, {}, 1100.0).values()))
    assert starts[0] == starts[1]
    two, three = (describe(folder / "wheel.fmu")["variables"] for folder in (native, native3))
    assert len(two) == len([v for v in three if v["name"] != "time"])


def test_a_friction_law_by_name_is_the_same_law(native: Path, native3: Path, tmp_path: Path) -> None:
    """Its table is an array in FMI 3.0 and forty parameters in FMI 2.0."""
    values = {"contact": {"friction": "friction-modifier"}}
    pair = [run(folder / "curvesqueal.ssp", tmp_path, values=values) for folder in (native, native3)]
    with open_results(pair[0].results) as two, open_results(pair[1].results) as three:
        force = np.asarray(two["contact.tangential_force_lat"])
        np.testing.assert_allclose(
            np.asarray(three["contact.tangential_force_lat"]), force, rtol=0, atol=1e-12 * np.abs(force).max()
        )
        laws = [model_of(data).poles.growth_rate for data in (two, three)]
    np.testing.assert_allclose(laws[1], laws[0], rtol=1e-9, atol=1e-6)
    plain = run(native3 / "curvesqueal.ssp", tmp_path)
    with open_results(plain.results) as data:
        assert np.abs(model_of(data).poles.growth_rate.max() - laws[1].max()) > 1.0
