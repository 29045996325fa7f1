"""FMUs of both flavours in tools that are not ours, and against the component in this process."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from fmu_manipulation_toolbox.checker import get_checkers
from fmu_manipulation_toolbox.operations import FMU
from slaves import NAMES, H, Slave, assert_steps_as, signal

from fmus.component import Component, Instance
from fmus.contact.component import contact
from fmus.interface import DIRECTIONS
from fmus.packaging.catalogue import components
from fmus.packaging.python.fmu import build_python_fmu


@pytest.fixture(scope="module")
def declared() -> dict[str, Component]:
    return components()


@pytest.fixture(scope="module", params=[pytest.param("built", marks=pytest.mark.slow), "native"])
def flavour(request: pytest.FixtureRequest) -> Path:
    """Return the folder of the Python or of the native FMUs."""
    folder: Path = request.getfixturevalue(request.param)
    return folder


@pytest.mark.parametrize("name", NAMES)
def test_fmpy_finds_no_problem(flavour: Path, name: str) -> None:
    assert validate_fmu(str(flavour / f"{name}.fmu")) == []


@pytest.mark.parametrize("name", NAMES)
def test_fmu_manipulation_toolbox_finds_no_problem(flavour: Path, name: str, caplog: pytest.LogCaptureFixture) -> None:
    """Schema and semantic rules of FMI 2.0.5."""
    fmu = FMU(str(flavour / f"{name}.fmu"))
    for checker in get_checkers():
        fmu.apply_operation(checker())
    assert [r.getMessage() for r in caplog.records if r.levelname in ("ERROR", "WARNING", "CRITICAL")] == []


@pytest.mark.parametrize("name", NAMES)
def test_two_builds_give_the_same_bytes(built: Path, declared: dict[str, Component], name: str, tmp_path: Path) -> None:
    again = build_python_fmu(declared[name], tmp_path / "again.fmu", fmpy_version(built / f"{name}.fmu"))
    assert again.read_bytes() == (built / f"{name}.fmu").read_bytes()


def fmpy_version(file: Path) -> str:
    return str(fmpy.read_model_description(str(file)).version)


def test_guid_follows_the_content(built: Path, tmp_path: Path, declared: dict[str, Component]) -> None:
    other = build_python_fmu(contact({"mobility_lon_lon": 1.0}), tmp_path / "other.fmu", "0")
    descriptions = [fmpy.read_model_description(str(f)) for f in (other, built / "contact.fmu")]
    assert descriptions[0].guid != descriptions[1].guid


@pytest.mark.parametrize("name", NAMES)
def test_model_description_says_what_tools_need(flavour: Path, name: str) -> None:
    description = fmpy.read_model_description(str(flavour / f"{name}.fmu"))
    assert description.defaultExperiment.stepSize == "5e-06"
    assert description.coSimulation.canGetAndSetFMUstate
    assert description.coSimulation.canSerializeFMUstate
    assert not description.coSimulation.needsExecutionTool
    reals = [v for v in description.modelVariables if v.type == "Real"]
    assert all(v.unit and v.nominal and v.description for v in reals)
    inputs = {v.name for v in description.modelVariables if v.causality == "input"}
    for unknown in description.outputs:
        known = {v.name for v in unknown.dependencies}
        assert known == (inputs if name == "contact" else set())
    assert len(description.initialUnknowns) == len(
        [v for v in description.modelVariables if v.causality in ("output", "calculatedParameter")]
    )


@pytest.mark.parametrize("name", NAMES)
def test_fmu_computes_what_the_component_computes(flavour: Path, declared: dict[str, Component], name: str) -> None:
    """Over 1000 steps, to 1e-12 of each output's largest value (the machine code may differ, the text does not)."""
    component = declared[name]
    moving = {v.name: 1e-3 for v in component.of("parameter") if v.name.startswith("initial_velocity")}
    assert_steps_as(Slave(flavour / f"{name}.fmu", moving), Instance(component, moving), 1000)


@pytest.mark.parametrize("name", NAMES)
def test_state_is_complete(flavour: Path, declared: dict[str, Component], name: str) -> None:
    """Go back to a state in the middle of a run, directly and through bytes: the same outputs, bit for bit."""
    slave = Slave(flavour / f"{name}.fmu")
    inputs = signal(declared[name], 60)

    def run(part: np.ndarray) -> list[np.ndarray]:
        rows = []
        for u in part:
            slave.set_inputs(u)
            slave.step()
            rows.append(slave.outputs())
        return rows

    run(inputs[:30])
    state = slave.slave.getFMUstate()
    data = slave.slave.serializeFMUstate(state)
    first = run(inputs[30:])
    slave.slave.setFMUstate(state)
    np.testing.assert_array_equal(run(inputs[30:]), first)
    restored = slave.slave.deSerializeFMUstate(data)
    slave.slave.setFMUstate(restored)
    np.testing.assert_array_equal(run(inputs[30:]), first)
    slave.slave.freeFMUstate(state)
    slave.close()


@pytest.mark.slow
def test_all_fmus_and_two_versions_of_one_work_in_a_process(
    built: Path, declared: dict[str, Component], tmp_path: Path
) -> None:
    """Every pair of FMUs sees its own code and data, in any order, also after the first ones were freed."""
    second = build_python_fmu(contact({"mobility_lat_lat": 4e-6}), tmp_path / "second.fmu", "0")
    for _ in range(2):
        slaves = [Slave(built / f"{name}.fmu") for name in NAMES] + [Slave(second), Slave(built / "contact.fmu")]
        parameter = [s.slave.getReal([s.reference["mobility_lat_lat"]])[0] for s in slaves[-3:]]
        start = next(v.start for v in declared["contact"].variables if v.name == "mobility_lat_lat")
        assert parameter == [start, 4e-6, start]
        for slave in slaves:
            slave.step()
        for slave in slaves:
            slave.close()


@pytest.mark.parametrize(
    ("name", "column", "output"),
    [("wheel", "f_lat", "v_lat"), ("rail", "f_ver", "v_ver"), ("contact", "wheel_v_lat", "creepage_lat")],
)
def test_fmu_runs_alone_with_an_input_signal(flavour: Path, name: str, column: str, output: str) -> None:
    inputs = np.array([(0.0, 0.0), (1e-3, 1.0)], dtype=[("time", float), (column, float)])
    result = fmpy.simulate_fmu(
        str(flavour / f"{name}.fmu"), stop_time=1e-3, step_size=H, output_interval=H, input=inputs, output=[output]
    )
    assert len(result) == 201
    assert result[output][-1] != result[output][0]
    assert np.isfinite(result[output]).all()


@pytest.mark.parametrize(
    ("parameters", "inputs", "message"),
    [
        ({"mu0": -1.0}, {}, "mu0 = -1: must be in the range 0 to 2"),
        ({}, {"wheel_v_lat": float("nan")}, "wheel_v_lat = nan: must be a finite number"),
    ],
)
def test_a_fault_is_an_error_that_names_the_variable(
    flavour: Path, parameters: dict[str, float], inputs: dict[str, float], message: str
) -> None:
    """In a process of its own, with FMPy's default logger, which prints."""
    script = f"""
import fmpy, os, sys
from pathlib import Path
sys.path.insert(0, {str(Path(__file__).parents[1] / "support")!r})
from slaves import H, Slave
try:
    slave = Slave(Path({str(flavour / "contact.fmu")!r}), {parameters!r})
    for name, value in {{k: float(v) for k, v in { ({k: str(v) for k, v in inputs.items()})!r}.items()}}.items():
        slave.slave.setReal([slave.reference[name]], [value])
    slave.step()
except fmpy.fmi1.FMICallException as error:
    print("status", error.status, flush=True)
os._exit(0)  # PythonFMU frees its state twice at an ordinary end
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert message in done.stdout
    assert "status" in done.stdout


def test_modal_velocities_add_up_to_the_velocity_of_the_contact_point(flavour: Path) -> None:
    slave = Slave(flavour / "wheel.fmu")
    slave.set_inputs(np.array([1e3, 2e3, 5e3, 10.0]))
    for _ in range(50):
        slave.step()
    modal = np.array(slave.slave.getReal([slave.reference[n] for n in slave.names("local")]))
    for direction in DIRECTIONS:
        names = [f"shape_{direction}_{i + 1:03d}" for i in range(modal.size)]
        shape = np.array(slave.slave.getReal([slave.reference[n] for n in names]))
        (velocity,) = slave.slave.getReal([slave.reference[f"v_{direction}"]])
        assert shape @ modal == pytest.approx(velocity, rel=1e-10)
    slave.close()
