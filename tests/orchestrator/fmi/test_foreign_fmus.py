"""Any co-simulation FMU in any place: FMI 3.0 with arrays, other types, own steps, iteration; and what is refused."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from coupled import modes_of, rail_of
from fmi3_fmu import StateSpace, needs_compiler, state_space_fmu, write_ssd
from two_masses import two_masses

from fmus.cases import read_cases
from fmus.interface import DIRECTIONS, connections
from fmus.modal.modes import state_space
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.contact_mobility import power_pairs
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.fmi.instance import FmuInstance, Value, open_fmu
from orchestrator.probing.mobility import probed_mobility, published_mobility, with_step
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

pytestmark = needs_compiler


@pytest.mark.parametrize(("value", "message"), [("1", "wants 2 values, got 1"), ("1 x", "must be a number")])
def test_arrays_as_parameters(masses: Path, value: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        assemble(two_masses(masses).with_parameters({"one": {"x0": value}}))
    whole = assemble(two_masses(masses).with_parameters({"one": {"A": [[0.0, 1.0], [-9.0, 0.0]]}}))  # type: ignore[dict-item]
    assert whole.parameters["one"]["A[2,1]"] == -9.0
    single = assemble(two_masses(masses).with_parameters({"one": {"A[2,1]": "-9"}}))
    assert single.parameters["one"]["A[2,1]"] == -9.0
    for assembly in (whole, single):
        with Master(assembly, Settings(0.01, 0.1)) as master:
            assert master.instances["one"].get_real(["A[1,2]", "A[2,1]"]) == [1.0, -9.0]


def test_an_array_is_no_connector(masses: Path) -> None:
    system = two_masses(masses)
    wires = [("one.y", "spring.u[1]")]
    bad = write_ssd(masses / "bad.ssd", {n: e.source for n, e in system.elements.items()}, wires)
    with pytest.raises(InputError, match=r"y is an array; name an element, y\[1\] to y\[2\]"):
        assemble(read_system(bad))


def test_whole_numbers_and_booleans_are_exchanged(masses: Path) -> None:
    """`enable` of the second follows `positive` of the first; a count of steps drives a real input."""
    wires = [("one.positive", "two.enable"), ("one.steps", "two.u[1]"), ("two.y[1]", "one.u[1]")]
    path = write_ssd(masses / "typed.ssd", {n: masses / f"{n}.fmu" for n in ("one", "two")}, wires)
    system = read_system(path).with_parameters({"one": {"x0": "-1 0"}})
    with Master(assemble(system), Settings(0.01, 0.05)) as master:
        master.run()
        values = dict(zip(master.outputs, master.plan.y, strict=True))
    assert values["one", "steps"] == 5
    assert values["one", "positive"] == 0
    assert values["two", "y[1]"] == 0  # not enabled: the force of 1 to 5 N does nothing
    assert values["one", "single"] == pytest.approx(values["one", "y[1]"], rel=1e-6)
    wrong = write_ssd(
        masses / "wrong.ssd", {n: masses / f"{n}.fmu" for n in ("one", "two")}, [("one.y[1]", "two.enable")]
    )
    with pytest.raises(InputError, match="Real cannot be connected to Boolean"):
        assemble(read_system(wrong))


@pytest.fixture(scope="module")
def array_rail(built: Path, tmp_path_factory: pytest.TempPathFactory) -> System:
    """Return Case 1 with a state-space FMU of FMI 3.0 in the rail's place, its matrices those of the modal rail."""
    folder = tmp_path_factory.mktemp("rail")
    A, B, C, C_d = state_space(modes_of(rail_of(1)))
    rail = state_space_fmu(folder, "matrix_rail", StateSpace(A, B, np.vstack([C, C_d])))
    for name in ("wheel", "contact"):
        (folder / f"{name}.fmu").write_bytes((built / f"{name}.fmu").read_bytes())
    element = {f"f_{d}": f"u[{i + 1}]" for i, d in enumerate(DIRECTIONS)}
    element |= {f"{kind}_{d}": f"y[{4 * k + i + 1}]" for k, kind in enumerate("vu") for i, d in enumerate(DIRECTIONS)}
    wires = []
    for c in connections():
        ends = ((c.start_element, c.start_connector), (c.end_element, c.end_connector))
        texts = [f"{e}.{element[v] if e == 'rail' else v}" for e, v in ends]
        wires.append((texts[0], texts[1]))
    parts = {"wheel": folder / "wheel.fmu", "rail": rail, "contact": folder / "contact.fmu"}
    return read_system(write_ssd(folder / "case1.ssd", parts, wires))


def test_state_space_of_fmi_3_stands_as_the_rail(array_rail: System, built: Path, tmp_path: Path) -> None:
    """Same rail, other FMU: matrices as arrays, mobility probed, FMI 3.0; the same run to 1e-6 of the largest value."""
    pulse: dict[str, dict[str, Value]] = {"contact": dict(read_cases()[0].contact)}
    found = {}
    for name, system in (("array", array_rail), ("modal", read_system(built / "curvesqueal.ssp"))):
        path = tmp_path / f"{name}.nc"
        with (
            Master(assemble(system.with_parameters(pulse)), Settings(5e-6, 2e-3, record_every=1)) as master,
            ResultsFile(path, master.signals(), {}) as results,
        ):
            master.run(results)
        with open_results(path) as data:
            found[name] = data.load()
    for modal, array in (("rail.v_lat", "rail.y[2]"), ("rail.u_ver", "rail.y[7]"), ("wheel.v_lat",) * 2):
        expected = found["modal"][modal].to_numpy()
        np.testing.assert_allclose(found["array"][array].to_numpy(), expected, atol=1e-6 * abs(expected).max())


def test_mobility_is_probed_by_rollback_and_without(array_rail: System, built: Path) -> None:
    """What the modal rail publishes, from one step of an FMU that publishes nothing; with its state and anew."""
    assembly = assemble(array_rail)
    bonds = {b.direction: b for b in assembly.bonds if b.force.wire.end_element == "rail"}
    fmu = open_fmu(built / "rail.fmu")
    published = published_mobility(fmu, with_step(fmu, {}, 1e-5))
    assert published is not None
    rail = assembly.fmus["rail"]
    assert rail.can_roll_back
    probed = probed_mobility(rail, {}, power_pairs(bonds), 1e-5)
    np.testing.assert_allclose(probed, published, atol=1e-9 * abs(published).max())
    rail.description.coSimulation.canGetAndSetFMUstate = False
    try:
        np.testing.assert_array_equal(probed_mobility(rail, {}, power_pairs(bonds), 1e-5), probed)
    finally:
        rail.description.coSimulation.canGetAndSetFMUstate = True


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (1, r"one: doStep returned discard at t = 0.02 s: fault on demand"),
        (2, r"one: doStep returned error at t = 0.02 s: fault on demand"),
        (3, r"one: doStep returned fatal at t = 0.02 s: fault on demand"),
        (4, r"one: output y\[1\] = nan at t = 0.02 s: not a finite number"),
    ],
)
def test_faults_of_an_fmi_3_component(masses: Path, number: int, message: str, tmp_path: Path) -> None:
    """At the third step; what was recorded until then is kept, here and with the message in a process of its own."""
    system = two_masses(masses).with_parameters({"one": {"fault": number, "fault_step": 3}})
    path = tmp_path / "r.nc"
    with (
        Master(assemble(system), Settings(0.01, 0.1, record_every=1)) as master,
        ResultsFile(path, master.signals(), {}) as results,
        pytest.raises(SimulationError, match=message),
    ):
        master.run(results)
    with open_results(path) as data:
        assert data.sizes["time"] == 3


def test_a_component_may_end_the_run(masses: Path, tmp_path: Path) -> None:
    """FMI 3.0 terminateSimulation with the third step: that step counts and is the last row; no error."""
    system = two_masses(masses).with_parameters({"one": {"fault": 5, "fault_step": 3}})
    path = tmp_path / "r.nc"
    with (
        Master(assemble(system), Settings(0.01, 0.1, record_every=2)) as master,
        ResultsFile(path, master.signals(), {}) as results,
    ):
        progress = master.run(results)
    assert progress.ended == "one ended the simulation at t = 0.03 s: fault on demand"
    with open_results(path) as data:
        assert data["time"].to_numpy() == pytest.approx([0.0, 0.02, 0.03], rel=1e-12)


def test_a_fault_on_the_command_line(masses: Path, tmp_path: Path) -> None:
    two_masses(masses)
    command = [sys.executable, "-m", "orchestrator", "run", str(masses / "two_masses.ssd"), "--step", "0.01", "--json"]
    command += ["--duration", "0.1", "--set", "one.fault=2", "--set", "one.fault_step=6", "--out", str(tmp_path)]
    done = subprocess.run([*command, "--record-every", "1"], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "one: doStep returned error at t = 0.05 s: fault on demand; results up to then are in" in done.stderr
    data = json.loads(done.stdout)
    assert data["completed"] is False
    with open_results(Path(data["results"])) as results:
        assert results.sizes["time"] == 6


MINIMAL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="{version}" modelName="m" guid="g"{more}>{interface}
{structure}</fmiModelDescription>"""

ONE_VARIABLE = (
    '<ModelVariables><ScalarVariable name="p" valueReference="0" causality="local"><Real/></ScalarVariable>'
    "</ModelVariables><ModelStructure/>"
)

FMI_1 = ' modelIdentifier="m" numberOfContinuousStates="0" numberOfEventIndicators="0"'


@pytest.mark.parametrize(
    ("version", "more", "interface", "structure", "message"),
    [
        ("1.0", FMI_1, "", "<ModelVariables/>", "is FMI 1.0; FMI 2.0 or 3.0 is wanted"),
        (
            "2.0", "", '<ModelExchange modelIdentifier="m"/>', ONE_VARIABLE,
            "offers model exchange only; co-simulation is wanted",
        ),
    ],
)  # fmt: skip
def test_other_kinds_of_fmus_are_refused(
    tmp_path: Path, version: str, more: str, interface: str, structure: str, message: str
) -> None:
    file = tmp_path / "m.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        text = MINIMAL.format(version=version, more=more, interface=interface, structure=structure)
        archive.writestr("modelDescription.xml", text)
    with pytest.raises(InputError, match=re.escape(message)):
        open_fmu(file)


def test_state_goes_through_bytes(masses: Path) -> None:
    fmu = open_fmu(masses / "one.fmu")
    instance = FmuInstance(fmu, "one")
    instance.set({"x0[1]": 1.0})
    instance.enter_initialization_mode(0.0, 1.0)
    instance.exit_initialization_mode()
    instance.do_step(0.0, 0.1)
    kept = instance.save()
    instance.do_step(0.1, 0.1)
    first = instance.get_real(["y[1]", "y[2]"])
    instance.restore(kept)
    instance.do_step(0.1, 0.1)
    assert instance.get_real(["y[1]", "y[2]"]) == first
    instance.close()
