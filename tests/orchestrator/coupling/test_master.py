"""The master with the project's FMUs: what it couples, in which order, and what it records and reports."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from coupled import Coupled
from master_runs import run

from fmus.contact.component import contact
from fmus.interface import DIRECTIONS, PAIRS
from fmus.wheel.class158 import identified_stiffness
from fmus.wheel.component import wheel
from orchestrator.coupling.algorithms import stages
from orchestrator.coupling.assembly import Assembly, assemble
from orchestrator.coupling.contact_mobility import contact_mobility, power_pairs
from orchestrator.coupling.dependencies import Coupling
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.probing.mobility import probed_mobility, published_mobility, with_step
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.results.formats import write_csv
from orchestrator.runs.scenario import random_start
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

H = 5e-6


@pytest.fixture(scope="module")
def case1(built: Path) -> System:
    return read_system(built / "curvesqueal.ssp")


@pytest.fixture(scope="module")
def assembly(case1: System) -> Assembly:
    return assemble(case1)


@pytest.mark.parametrize("algorithm", ["staggered", "jacobi"])
def test_master_steps_as_the_components_do_by_hand(case1: System, tmp_path: Path, algorithm: str) -> None:
    """FMUs through FMI and the compiled loop against the in-process components: 400 steps, to 1e-9 of the largest.

    The bits may differ in the last place per step, which stick and slip do not amplify in this time.
    """
    path = tmp_path / "r.nc"
    run(case1, Settings(H, 400 * H, algorithm, record_every=1), path)
    jacobi, stiffness = algorithm == "jacobi", identified_stiffness()
    system = Coupled.of(
        1, H, jacobi=jacobi, own_wheel=wheel(), hertz_stiffness=stiffness, pulse_force=100.0, pulse_duration=1e-4
    )
    record = system.run(400)
    with open_results(path) as data:
        assert data.sizes["time"] == 401
        for name, component in (("wheel", "v_lat"), ("rail", "u_ver")):
            place = {"v_lat": 1, "u_ver": 6}[component]
            found, expected = data[f"{name}.{component}"].to_numpy()[1:], record[name][:, place]
            np.testing.assert_allclose(found, expected, atol=1e-9 * abs(expected).max())
    _, last = run(case1, Settings(H, 400 * H, algorithm))
    final = np.concatenate([record[name][-1] for name in ("wheel", "rail", "contact")])
    scale = np.concatenate([abs(record[name]).max(axis=0) for name in ("wheel", "rail", "contact")])
    assert (abs(last - final) <= 1e-9 * scale + 1e-25)[:-1].all()


def test_time_is_counted_in_whole_steps(case1: System, tmp_path: Path) -> None:
    """Rows are at whole multiples of the step, without drift; the number of steps is exact."""
    path = tmp_path / "r.nc"
    settings = Settings(H, 0.0123, record_every=3)
    run(case1, settings, path)
    with open_results(path) as data:
        expected = H * (3 * np.arange(settings.steps // 3 + 1))
        np.testing.assert_array_equal(data["time"].to_numpy(), expected)


def test_results_carry_names_and_units(case1: System, tmp_path: Path) -> None:
    path = tmp_path / "r.nc"
    run(case1, Settings(H, 100 * H), path)
    with xr.open_dataset(path) as data:
        assert data["wheel.v_lat"].attrs["units"] == "m/s"
        assert data["contact.normal_force"].attrs["units"] == "N"
        assert {f"energy_into.wheel_{d}" for d in DIRECTIONS} <= set(data.data_vars)
        write_csv(data, tmp_path / "r.csv")
    lines = (tmp_path / "r.csv").read_text().splitlines()
    assert lines[0].startswith("time [s],wheel.v_lon [m/s],")
    assert len(lines) == 27


def test_mobility_is_the_sum_of_the_published_ones(assembly: Assembly) -> None:
    """What the master sets equals the start values of the contact, which are those of the default system."""
    found = contact_mobility(assembly, H)
    fmu = assembly.fmus["contact"]
    for row, column in PAIRS:
        name = f"mobility_{row}_{column}"
        assert found[name] == pytest.approx(float(fmu.variables[name].start), rel=1e-12)


@pytest.mark.parametrize("name", ["wheel", "rail"])
def test_probed_mobility_equals_the_published_one(assembly: Assembly, name: str) -> None:
    """A structure that publishes none is found out by one step of a unit force; rounding only."""
    bonds = {b.direction: b for b in assembly.bonds if b.force.wire.end_element == name}
    parameters = with_step(assembly.fmus[name], assembly.parameters[name], 2e-5)
    published = published_mobility(assembly.fmus[name], parameters)
    assert published is not None
    probed = probed_mobility(assembly.fmus[name], parameters, power_pairs(bonds), 2e-5)
    np.testing.assert_allclose(probed, published, atol=1e-12 * abs(published).max())


def test_energy_into_a_structure_is_the_held_force_along_its_way(case1: System, tmp_path: Path) -> None:
    """From the recorded rows, against what the loop counted; two summations of 300 terms, so only rounding is left."""
    path = tmp_path / "r.nc"
    with (
        Master(assemble(case1), Settings(H, 300 * H, record_every=1)) as master,
        ResultsFile(path, master.signals(), {}) as results,
    ):
        progress = master.run(results)
    with open_results(path) as data:
        for s in ("wheel", "rail"):
            total = 0.0
            for d in DIRECTIONS:
                force = data[f"contact.{s}_f_{d}"].to_numpy()[:-1]
                way = np.diff(data[f"{s}.u_{d}"].to_numpy())
                if d in ("lon", "spin"):  # no displacement is wired
                    way = 0.5 * H * (data[f"{s}.v_{d}"].to_numpy()[1:] + data[f"{s}.v_{d}"].to_numpy()[:-1])
                work = float(force @ way)
                assert data[f"energy_into.{s}_{d}"].to_numpy()[-1] == pytest.approx(work, rel=1e-9)
                total += work
            assert progress.energy_into[s] == pytest.approx(total, rel=1e-9)
        added = {d: float(data[f"contact.energy_added_{d}"][-1]) for d in progress.energy_residual}
    assert progress.energy_residual == added


def test_random_start_repeats_with_its_seed(assembly: Assembly) -> None:
    first, again, other = (random_start(assembly.fmus, seed) for seed in (1, 1, 2))
    assert first == again
    assert first != other
    assert first["contact"] == {"pulse_force": 0.0}


def test_structures_step_before_the_contact(assembly: Assembly) -> None:
    assert stages("staggered", assembly.coupling) == [["wheel", "rail"], ["contact"]]
    assert stages("jacobi", assembly.coupling) == [["wheel", "rail", "contact"]]


def test_component_between_the_others_steps_last_when_nobody_tells() -> None:
    feeds = {"a": frozenset({"link"}), "link": frozenset({"a", "b"}), "b": frozenset({"link"})}
    coupling = Coupling.of_components(feeds, dict.fromkeys(feeds))
    assert stages("staggered", coupling) == [["a", "b"], ["link"]]


def test_order_comes_from_dependencies_then_annotation_then_place() -> None:
    """What an FMU declares wins over the annotation; the annotation over the place between the others."""
    feeds = {"a": frozenset({"link"}), "link": frozenset({"a", "b"}), "b": frozenset({"link"})}
    silent: dict[str, bool | None] = dict.fromkeys(feeds)
    assert Coupling.of_components(feeds, silent).guesses() == [
        "a, link, b do not declare which outputs depend on which inputs, so FMI has them depend on all, and a, link, b "
        "wait for each other: a, b first with inputs of the step before, then link; if that is wrong, the annotation "
        '<Component stage="..."/> in the SSD settles it (docs/conventions.md)'
    ]
    annotated = Coupling.of_components(feeds, silent, {"a": 1, "link": 0, "b": 0})
    assert stages("staggered", annotated) == [["link", "b"], ["a"]]
    assert annotated.guesses() == []
    declared = Coupling.of_components(feeds, {"a": False, "link": True, "b": False}, {"a": 1, "link": 0})
    assert stages("staggered", declared) == [["a", "b"], ["link"]]


def test_only_the_members_of_a_loop_are_named() -> None:
    """`late` depends on the loop and feeds nobody; `early` feeds it; the loop is x and y."""
    feeds = {
        "early": frozenset[str](), "x": frozenset({"early", "y"}), "y": frozenset({"x"}), "late": frozenset({"y"}),
    }  # fmt: skip
    coupling = Coupling.of_components(feeds, {"early": False, "x": True, "y": True, "late": True})
    with pytest.raises(InputError, match="the outputs of x, y depend on each other"):
        stages("staggered", coupling)
    assert [set(stage) for stage in stages("iterative", coupling)] == [{"early"}, {"x", "y"}, {"late"}]


def test_algebraic_loop_is_named() -> None:
    feeds = {"a": frozenset({"b"}), "b": frozenset({"a"})}
    with pytest.raises(InputError, match="algebraic loop: the outputs of a, b depend on each other"):
        stages("staggered", Coupling.of_components(feeds, {"a": True, "b": True}))


def test_parameters_reach_the_components(case1: System) -> None:
    changed = case1.with_parameters({"contact": {"mu0": "0.4", "linear_spring": "true", "grid_cells": "5"}})
    master, last = run(changed, Settings(H, 10 * H))
    names = list(master.outputs)
    friction = last[names.index(("contact", "friction_coefficient"))]
    assert friction == pytest.approx(0.4 * 0.92212, rel=1e-3)
    assert contact().parameter_index["grid_cells"] >= 0
