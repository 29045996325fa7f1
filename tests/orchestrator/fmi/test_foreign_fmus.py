"""Any co-simulation FMU in any place: FMI 3.0 with arrays, other types, own steps, iteration; and what is refused."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import zipfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from coupled import modes_of, rail_of
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu, write_ssd
from numpy.typing import NDArray
from scipy.linalg import expm

from fmus.cases import read_cases
from fmus.interface import DIRECTIONS, connections
from fmus.modal.modes import state_space
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.contact_mobility import power_pairs
from orchestrator.coupling.master import Master, Progress, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.fmi.instance import FmuInstance, Value, open_fmu
from orchestrator.probing.mobility import probed_mobility, published_mobility, with_step
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the FMI 3.0 test FMU")
pytestmark = needs_compiler

STIFFNESS, DAMPING = 4.0, 0.1
MASSES = (1.0, 2.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with two oscillating masses and the spring between them."""
    path = tmp_path_factory.mktemp("fmi3")
    for name, mass in zip(("one", "two"), MASSES, strict=True):
        ground = StateSpace([[0, 1], [-1.0 / mass, 0]], [[0], [1 / mass]], np.eye(2))
        state_space_fmu(path, name, ground)
        state_space_fmu(path, f"{name}_slow", ground, fixed_step=0.04)
        state_space_fmu(path, f"{name}_forgetful", ground, keeps_state=False)
    gain = np.array([[-STIFFNESS, -DAMPING, STIFFNESS, DAMPING]])
    state_space_fmu(path, "spring", StateSpace([[0]], np.zeros((1, 4)), np.zeros((2, 1)), np.vstack([gain, -gain])))
    return path


def two_masses(folder: Path, one: str = "one", two: str = "two") -> System:
    """Return the two-mass oscillator: two FMUs with forces in and motion out, and a spring and damper between them."""
    wires = [(f"{m}.y[{i}]", f"spring.u[{2 * k + i}]") for k, m in enumerate(("one", "two")) for i in (1, 2)]
    wires += [("spring.y[1]", "one.u[1]"), ("spring.y[2]", "two.u[1]")]
    parts = {"one": folder / f"{one}.fmu", "two": folder / f"{two}.fmu", "spring": folder / "spring.fmu"}
    system = read_system(write_ssd(folder / "two_masses.ssd", parts, wires))
    return system.with_parameters({"one": {"x0": "1 0"}})


def exact(time: float) -> NDArray[np.float64]:
    """Return the motion of both masses: the exponential of the coupled system."""
    (m, n), k, c = MASSES, STIFFNESS, DAMPING
    A = [
        [0, 1, 0, 0],
        [-(1 + k) / m, -c / m, k / m, c / m],
        [0, 0, 0, 1],
        [k / n, c / n, -(1 + k) / n, -c / n],
    ]
    return np.asarray(expm(np.array(A) * time) @ [1, 0, 0, 0])


def end_state(system: System, settings: Settings) -> tuple[NDArray[np.float64], Progress]:
    """Run and return the motion of both masses at the end."""
    with Master(assemble(system), settings) as master:
        progress = master.run()
        last = dict(zip(master.outputs, master.plan.y, strict=True))
    return np.array([last[m, f"y[{i}]"] for m in ("one", "two") for i in (1, 2)]), progress


@pytest.mark.parametrize(("algorithm", "order"), [("staggered", 1), ("jacobi", 1), ("iterative", 2)])
def test_order_of_convergence_on_the_two_mass_oscillator(folder: Path, algorithm: str, order: int) -> None:
    """A spring that knows nothing of the step: held forces are of first order, the converged mean of second."""
    system = two_masses(folder)
    steps = (0.02, 0.01, 0.005)
    errors = [abs(end_state(system, Settings(h, 4.0, algorithm))[0] - exact(4.0)).max() for h in steps]
    orders = [np.log2(a / b) for a, b in pairwise(errors)]
    assert orders == pytest.approx([order] * 2, abs=0.15), errors


def test_iteration_reports_its_sweeps(folder: Path) -> None:
    _, progress = end_state(two_masses(folder), Settings(0.01, 1.0, "iterative"))
    assert 2 <= progress.sweeps <= progress.most_sweeps < 12
    _, plain = end_state(two_masses(folder), Settings(0.01, 1.0))
    assert (plain.sweeps, plain.most_sweeps) == (1.0, 1)


def ring_of_gains(folder: Path, gain: float) -> System:
    """Return two FMUs whose outputs depend on each other within a step: y = gain u + x, x = 1 in the first."""
    file = state_space_fmu(folder, "gain", StateSpace([[0]], [[0]], [[1]], [[gain]]))
    ssd = write_ssd(folder / "ring.ssd", {"a": file, "b": file}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])
    return read_system(ssd).with_parameters({"a": {"x0": "1"}})


def test_iteration_solves_an_algebraic_loop(tmp_path: Path) -> None:
    """y_a = y_b/2 + 1, y_b = y_a/2: 4/3 and 2/3 at every step, the first included."""
    system = ring_of_gains(tmp_path, 0.5)
    with pytest.raises(InputError, match=r"algebraic loop: the outputs of a, b depend on each other"):
        Master(assemble(system), Settings(0.1, 1.0))
    with Master(assemble(system), Settings(0.1, 1.0, "iterative")) as master:
        for _ in range(2):
            values = dict(zip(master.outputs, master.plan.y.copy(), strict=True))
            assert values["a", "y[1]"] == pytest.approx(4 / 3, rel=1e-7)
            assert values["b", "y[1]"] == pytest.approx(2 / 3, rel=1e-7)
            master.run()


def test_an_iteration_that_does_not_converge_says_so(tmp_path: Path) -> None:
    with (
        Master(assemble(ring_of_gains(tmp_path, 1.5)), Settings(0.1, 1.0, "iterative")) as master,
        pytest.raises(SimulationError, match=r"iterative: input [ab]\.u\[1\] still changes after 50 sweeps at t = 0 s"),
    ):
        master.run()


def test_iteration_needs_the_state(folder: Path) -> None:
    system = two_masses(folder, one="one_forgetful")
    with pytest.raises(InputError, match=r"iterative: one \(one_forgetful.fmu\) cannot get and set its state"):
        Master(assemble(system), Settings(0.01, 1.0, "iterative"))
    state, _ = end_state(system, Settings(0.01, 1.0))
    same, _ = end_state(two_masses(folder), Settings(0.01, 1.0))
    np.testing.assert_array_equal(state, same)


def with_own_step(system: System, name: str, step: float) -> System:
    """Return the system with a step of its own for a component, as an annotation gives it."""
    return replace(system, elements={**system.elements, name: replace(system.elements[name], step=step)})


def test_component_with_a_longer_step_of_its_own(folder: Path) -> None:
    """One mass steps by 0.04 s among others of 0.01 s: its outputs stay in between, and the whole still converges."""
    system = with_own_step(two_masses(folder), "one", 0.04)
    with Master(assemble(system), Settings(0.01, 0.12)) as master:
        assert master.notices == ["one makes one step of 0.04 s in 4 communication steps"]
        seen = []
        for _ in range(12):
            master.run(steps=1)
            seen.append(master.plan.y[master.outputs.index(("one", "y[1]"))])
    assert [len(set(seen[4 * k + 3 : 4 * k + 7])) for k in range(2)] == [1, 1]
    assert len(set(seen)) == 4  # the start, and three steps
    coarse, _ = end_state(two_masses(folder), Settings(0.04, 4.0))
    mixed, _ = end_state(system, Settings(0.01, 4.0))
    assert abs(mixed - exact(4.0)).max() < abs(coarse - exact(4.0)).max()


def test_steps_that_do_not_fit_are_refused(folder: Path) -> None:
    """Neither a step that is no multiple, nor a run at whose end a slow component has not arrived."""
    system = with_own_step(two_masses(folder), "one", 0.04)
    with pytest.raises(
        InputError, match=r"one: the system has it step by 0.04 s, no whole multiple of .* step of 0.03"
    ):
        Master(assemble(system), Settings(0.03, 1.0))
    with pytest.raises(
        InputError, match=r"one makes one step in 4 communication steps, and the run has 6: it would not"
    ):
        Master(assemble(system), Settings(0.01, 0.06))
    with pytest.raises(InputError, match=r"iterative: one .* steps more slowly than the others"):
        Master(assemble(system), Settings(0.02, 1.0, "iterative"))


def test_an_inner_step_is_advice(folder: Path) -> None:
    """FMI 3.0 fixedInternalStepSize: the FMU steps with the others all the same; that it does not fit is told."""
    system = two_masses(folder, one="one_slow")
    for step, told in ((0.02, 1), (0.08, 0)):
        with Master(assemble(system), Settings(step, 0.8)) as master:
            assert sum("steps inside by 0.04 s" in notice for notice in master.notices) == told
        found, plain = (end_state(s, Settings(step, 0.8))[0] for s in (system, two_masses(folder)))
        np.testing.assert_array_equal(found, plain)


@pytest.mark.parametrize(("value", "message"), [("1", "wants 2 values, got 1"), ("1 x", "must be a number")])
def test_arrays_as_parameters(folder: Path, value: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        assemble(two_masses(folder).with_parameters({"one": {"x0": value}}))
    whole = assemble(two_masses(folder).with_parameters({"one": {"A": [[0.0, 1.0], [-9.0, 0.0]]}}))  # type: ignore[dict-item]
    assert whole.parameters["one"]["A[2,1]"] == -9.0
    single = assemble(two_masses(folder).with_parameters({"one": {"A[2,1]": "-9"}}))
    assert single.parameters["one"]["A[2,1]"] == -9.0
    for assembly in (whole, single):
        with Master(assembly, Settings(0.01, 0.1)) as master:
            assert master.instances["one"].get_real(["A[1,2]", "A[2,1]"]) == [1.0, -9.0]


def test_an_array_is_no_connector(folder: Path) -> None:
    system = two_masses(folder)
    wires = [("one.y", "spring.u[1]")]
    bad = write_ssd(folder / "bad.ssd", {n: e.source for n, e in system.elements.items()}, wires)
    with pytest.raises(InputError, match=r"y is an array; name an element, y\[1\] to y\[2\]"):
        assemble(read_system(bad))


def test_whole_numbers_and_booleans_are_exchanged(folder: Path) -> None:
    """`enable` of the second follows `positive` of the first; a count of steps drives a real input."""
    wires = [("one.positive", "two.enable"), ("one.steps", "two.u[1]"), ("two.y[1]", "one.u[1]")]
    path = write_ssd(folder / "typed.ssd", {n: folder / f"{n}.fmu" for n in ("one", "two")}, wires)
    system = read_system(path).with_parameters({"one": {"x0": "-1 0"}})
    with Master(assemble(system), Settings(0.01, 0.05)) as master:
        master.run()
        values = dict(zip(master.outputs, master.plan.y, strict=True))
    assert values["one", "steps"] == 5
    assert values["one", "positive"] == 0
    assert values["two", "y[1]"] == 0  # not enabled: the force of 1 to 5 N does nothing
    assert values["one", "single"] == pytest.approx(values["one", "y[1]"], rel=1e-6)
    wrong = write_ssd(
        folder / "wrong.ssd", {n: folder / f"{n}.fmu" for n in ("one", "two")}, [("one.y[1]", "two.enable")]
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
def test_faults_of_an_fmi_3_component(folder: Path, number: int, message: str, tmp_path: Path) -> None:
    """At the third step; what was recorded until then is kept, here and with the message in a process of its own."""
    system = two_masses(folder).with_parameters({"one": {"fault": number, "fault_step": 3}})
    path = tmp_path / "r.nc"
    with (
        Master(assemble(system), Settings(0.01, 0.1, record_every=1)) as master,
        ResultsFile(path, master.signals(), {}) as results,
        pytest.raises(SimulationError, match=message),
    ):
        master.run(results)
    with open_results(path) as data:
        assert data.sizes["time"] == 3


def test_a_component_may_end_the_run(folder: Path, tmp_path: Path) -> None:
    """FMI 3.0 terminateSimulation with the third step: that step counts and is the last row; no error."""
    system = two_masses(folder).with_parameters({"one": {"fault": 5, "fault_step": 3}})
    path = tmp_path / "r.nc"
    with (
        Master(assemble(system), Settings(0.01, 0.1, record_every=2)) as master,
        ResultsFile(path, master.signals(), {}) as results,
    ):
        progress = master.run(results)
    assert progress.ended == "one ended the simulation at t = 0.03 s: fault on demand"
    with open_results(path) as data:
        assert data["time"].to_numpy() == pytest.approx([0.0, 0.02, 0.03], rel=1e-12)


def test_a_fault_on_the_command_line(folder: Path, tmp_path: Path) -> None:
    two_masses(folder)
    command = [sys.executable, "-m", "orchestrator", "run", str(folder / "two_masses.ssd"), "--step", "0.01", "--json"]
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


def test_state_goes_through_bytes(folder: Path) -> None:
    fmu = open_fmu(folder / "one.fmu")
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
