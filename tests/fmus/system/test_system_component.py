"""The coupled system as one component and as one FMU."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import simulate_fmu
from slaves import H, Slave

from fmus.cases import read_cases
from fmus.component import Component, Instance
from fmus.contact.layout import D
from fmus.interface import OPERATING_POINT
from fmus.packaging.catalogue import components
from fmus.sources import files_of
from fmus.system.layout import N_CONTACT_DERIVED

CASE = read_cases()[0].contact
INPUTS = [port.name for port in OPERATING_POINT]


@pytest.fixture(scope="module")
def declared() -> dict[str, Component]:
    return components()


def coupled(declared: dict[str, Component], steps: int, values: dict[str, float], mu0: np.ndarray) -> np.ndarray:
    """Step three instances by hand, structures first, the friction coefficient changing over time."""
    wheel, rail = Instance(declared["wheel"]), Instance(declared["rail"])
    contact = Instance(declared["contact"], {**CASE, **values})
    for part in (wheel, rail, contact):
        part.initialise()
    place = declared["contact"].parameter_index["mu0"]
    rows = []
    for k in range(steps):
        wheel.do_step(H)
        rail.do_step(H)
        w, r, u = wheel.outputs, rail.outputs, contact.inputs
        u[0:4], u[4:8], u[8:10], u[10:12] = w[0:4], r[0:4], w[5:7], r[5:7]
        contact.parameters[place] = mu0[k]
        contact.do_step(H)
        wheel.inputs[:], rail.inputs[:] = contact.outputs[0:4], contact.outputs[4:8]
        rows.append(np.concatenate([u[:12], contact.outputs]))
    return np.array(rows)


def test_the_system_is_its_three_parts_stepped_in_order(declared: dict[str, Component]) -> None:
    """Bit for bit; the same arithmetic in the same order."""
    system = Instance(declared["curvesqueal"])
    system.initialise()
    rows = []
    for _ in range(2000):
        system.do_step(H)
        rows.append(system.outputs.copy())
    np.testing.assert_array_equal(rows, coupled(declared, 2000, {}, np.full(2000, 0.3)))


def test_a_long_step_is_made_of_equal_micro_steps(declared: dict[str, Component]) -> None:
    one, many = Instance(declared["curvesqueal"]), Instance(declared["curvesqueal"])
    for instance in (one, many):
        instance.initialise()
    one.do_step(200 * H)
    for _ in range(200):
        many.do_step(H)
    np.testing.assert_array_equal(one.outputs, many.outputs)


@pytest.mark.parametrize("step", [60.0, 1e300])
def test_a_step_of_too_many_micro_steps_is_an_error_at_once(native: Path, step: float) -> None:
    with pytest.raises(Exception, match="fmi2DoStep failed with status 3"):
        simulate_fmu(str(native / "curvesqueal.fmu"), stop_time=step, output_interval=step, step_size=step)


def test_micro_steps_of_another_size_bring_their_own_mobility(declared: dict[str, Component]) -> None:
    """A step that no whole number of micro steps fills is divided more finely: second order, so nearly the same."""
    found = []
    for step, count in ((5e-6, 294), (14.7e-6, 100)):
        system = Instance(declared["curvesqueal"])
        system.initialise()
        for _ in range(count):
            system.do_step(step)
        found.append(system.outputs[:8].copy())
    assert abs(found[0] - found[1]).max() < 2e-3 * abs(found[0]).max()
    assert (found[0] != found[1]).any()


def test_friction_changes_over_time_without_a_constant_force_on_the_structures(declared: dict[str, Component]) -> None:
    """From rest, another friction coefficient is another steady state: nothing moves, and the total force follows."""
    system = Instance(declared["curvesqueal"], {"pulse_force": 0.0})
    system.initialise()
    mu0 = INPUTS.index("mu0")
    before = system.outputs.copy()
    system.inputs[mu0] = 0.1
    for _ in range(100):
        system.do_step(H)
    names = [v.name for v in declared["curvesqueal"].of("output")]
    total = names.index("tangential_force_lat")
    assert system.outputs[total] == pytest.approx(before[total] * 0.4 / 0.3, rel=1e-9)
    assert abs(system.outputs[:12]).max() < 1e-12


@pytest.mark.parametrize(("name", "change"), [("mu0", 0.1), ("steady_creepage_lat", -0.005)])
def test_a_parameter_is_tuned_as_its_input_changes_it(declared: dict[str, Component], name: str, change: float) -> None:
    """To rounding; both from the same moment on."""
    tuned, driven = Instance(declared["curvesqueal"]), Instance(declared["curvesqueal"])
    for system in (tuned, driven):
        system.initialise()
    start = tuned.parameters[tuned.component.parameter_index[name]]
    for k in range(600):
        if k == 100:
            tuned.set_parameter(name, start + change)
            driven.inputs[INPUTS.index(name)] = change
        tuned.do_step(H)
        driven.do_step(H)
    np.testing.assert_allclose(tuned.outputs, driven.outputs, rtol=1e-9, atol=1e-15)
    assert abs(tuned.outputs[:8]).max() > 1e-5


@pytest.mark.parametrize("load", [30e3, 60e3, 90e3])
def test_the_contact_stiffness_follows_hertz_when_the_load_changes(declared: dict[str, Component], load: float) -> None:
    """The approach goes with the load to the power 2/3, so the stiffness with its cube root."""
    system = Instance(declared["curvesqueal"], {"pulse_force": 0.0})
    system.initialise()
    stiffness = CASE["hertz_stiffness"]
    system.inputs[INPUTS.index("normal_load")] = load - 60e3
    system.do_step(H)
    derived = system.derived[-N_CONTACT_DERIVED:]
    assert 1.5 * load / derived[D.approach] == pytest.approx(stiffness * (load / 60e3) ** (1 / 3), rel=1e-12)
    names = [v.name for v in declared["curvesqueal"].of("output")]
    assert system.outputs[names.index("normal_force")] == pytest.approx(load, rel=1e-9)


@pytest.mark.parametrize("folder", [pytest.param("built", marks=pytest.mark.slow), "native"])
def test_the_fmu_computes_what_the_component_computes(
    request: pytest.FixtureRequest, declared: dict[str, Component], folder: str
) -> None:
    path: Path = request.getfixturevalue(folder)
    slave = Slave(path / "curvesqueal.fmu")
    instance = Instance(declared["curvesqueal"])
    instance.initialise()
    found, expected = [], []
    for k in range(500):
        inputs = np.array([0.0, 0.0, 0.0, 0.0, 0.05 * np.sin(0.05 * k)])
        slave.set_inputs(inputs)
        slave.step()
        found.append(slave.outputs())
        instance.inputs[:] = inputs
        instance.do_step(H)
        expected.append(instance.outputs.copy())
    slave.close()
    scale = abs(np.array(expected)).max(axis=0)
    assert (abs(np.array(found) - expected).max(axis=0) <= 1e-12 * scale).all()


def test_one_call_of_fmpy_is_a_scenario(native: Path) -> None:
    """More friction, faster growth; with no friction nothing grows."""
    levels = []
    for mu0 in (0.0, 0.2, 0.4):
        result = fmpy.simulate_fmu(
            str(native / "curvesqueal.fmu"), start_values={"mu0": mu0}, stop_time=0.15, step_size=5e-5,
            output_interval=5e-5, output=["wheel_v_lat"],
        )  # fmt: skip
        levels.append(np.sqrt(np.mean(result["wheel_v_lat"][-1000:] ** 2)))
    assert levels[0] < levels[1] < levels[2]


def test_the_example_runs(native: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    example = Path(__file__).parents[3] / "examples" / "system" / "family.py"
    monkeypatch.setattr(sys, "argv", [str(example), str(native / "curvesqueal.fmu")])
    module = runpy.run_path(str(example))
    module["main"].__globals__["DURATION"] = 0.25
    module["main"]()
    lines = capsys.readouterr().out.strip().splitlines()
    assert len(lines) == 9
    rates = [float(line.split()[2]) for line in lines[1:]]
    assert rates[2] > rates[0]  # falling friction grows faster with more of it


def test_an_fmu_carries_what_its_kernels_import(declared: dict[str, Component]) -> None:
    files = files_of(declared["curvesqueal"].kernels)
    assert {"system/kernels.py", "modal/kernels.py", "contact/kernels.py", "creep/fastsim.py", "compile.py"} <= set(
        files
    )
    assert "contact/component.py" not in files
