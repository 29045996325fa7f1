"""FMUs with the traits of the Reference-FMUs, through the master and through FMPy's simulator: the same, to the bit."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import Rows
from reference_fmus import clocks, reference_fmu, state_space, ticking
from table_fmus import COMPILER

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.fmi.file import open_fmu
from orchestrator.fmi.instance import Value
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")

STEP = 0.25
"""Such that the sum of steps is exact: FMPy tells the FMU the difference of two times."""


def simulate(
    fmu: Path, duration: float, values: dict[str, Value] | None = None
) -> tuple[Rows, dict[str, np.ndarray], Master]:
    """Run an FMU alone; return rows, signals and the master."""
    system = read_system(write_ssd(fmu.with_suffix(".ssd"), {"c": fmu}, [])).with_parameters({"c": values or {}})
    rows = Rows()
    with Master(assemble(system), Settings(STEP, duration, record_every=1)) as master:
        master.run(rows)
        return rows, rows.columns(master.signals()), master


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("kind", ["Dahlquist", "VanDerPol", "BouncingBall", "Resource", "Stair"])
def test_one_fmu_is_as_fmpy_has_it(tmp_path: Path, kind: str, fmi: int) -> None:
    """All outputs at all times."""
    fmu = reference_fmu(tmp_path, kind, fmi)
    rows, found, _ = simulate(fmu, 5.0)
    names = open_fmu(fmu).names("output")
    expected = fmpy.simulate_fmu(str(fmu), stop_time=5.0, output_interval=STEP, step_size=STEP, output=names)
    np.testing.assert_array_equal(rows.times, expected["time"])
    for name in names:
        np.testing.assert_array_equal(found[f"c.{name}"], expected[name], name)
    if kind == "BouncingBall":
        np.testing.assert_array_equal(found["c.h_ft"], found["c.h"])
        assert found["c.h"].min() < 0.2 < found["c.h"].max()


@pytest.mark.parametrize("fmi", [2, 3])
def test_stair_ends_the_run(tmp_path: Path, fmi: int) -> None:
    """At its eleventh second: FMI 3.0 with a step that counts, FMI 2.0 with a step that is discarded."""
    rows, found, master = simulate(reference_fmu(tmp_path, "Stair", fmi), 20.0)
    assert master.progress.ended is not None
    assert master.progress.ended.startswith("c ended the simulation at t = ")
    assert (rows.times[-1], found["c.counter"][-1]) == (10.0 if fmi == 3 else 9.75, 10)
    assert found["c.counter"].dtype == np.int32


@pytest.mark.parametrize("fmi", [2, 3])
def test_all_types_go_through(tmp_path: Path, fmi: int) -> None:
    """From one to the next: numbers in their types, whole numbers of 64 bits beyond those of a double, texts."""
    fmu = reference_fmu(tmp_path, "Feedthrough", fmi)
    large: dict[str, Value] = {"int64_in": -(2**62) - 1, "uint64_in": 2**64 - 3, "uint8_in": 255} if fmi == 3 else {}
    given: dict[str, Value] = {"real_in": 0.1, "int_in": -7, "bool_in": True, "text_in": "Gleisbogen 2°", **large}
    wires = [(f"a.{name[:-3]}_out".replace("__", "_"), f"b.{name}") for name in given]
    system = read_system(write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, wires)).with_parameters({"a": given})
    rows = Rows()
    with Master(assemble(system), Settings(STEP, 1.0, record_every=1)) as master:
        master.run(rows)
        found = rows.columns(master.signals())
        assert master.instances["b"].get_texts(["text_out"]) == ["Gleisbogen 2°"]
    for name in ("real", "int", "bool", *(n[:-3] for n in large)):
        assert found[f"b.{name}_out"][-1] == given[f"{name}_in"], name
    if fmi == 3:
        assert [found[f"b.{n}_out"].dtype.name for n in ("int64", "uint64", "uint8")] == ["int64", "uint64", "uint8"]


def test_recording_of_a_text_is_refused(tmp_path: Path) -> None:
    """By name or by a pattern that means texts alone; a wider one records the numbers."""
    fmu = reference_fmu(tmp_path, "Feedthrough", 3)
    assembly = assemble(read_system(write_ssd(tmp_path / "s.ssd", {"a": fmu}, [])))
    for pattern in ("a.text_out", "*.text_*"):
        with pytest.raises(InputError, match=r"^record .*: a\.text_(in|out) is a text; results hold numbers only"):
            Master(assembly, Settings(STEP, 1.0, record=(pattern,)))
    with Master(assembly, Settings(STEP, 1.0, record=("a.*_out",))) as master:
        assert "a.int_out" in [column.name for column in master.signals()]
        assert not [column.name for column in master.signals() if "text" in column.name]


def test_a_number_that_does_not_fit_is_an_error(tmp_path: Path) -> None:
    fmu = reference_fmu(tmp_path, "Feedthrough", 3)
    system = read_system(write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, [("a.int64_out", "b.uint8_in")]))
    for value in (256, -1):
        with pytest.raises(
            SimulationError, match=r"b: an input does not hold the whole number that is connected to it"
        ):
            Master(assemble(system.with_parameters({"a": {"int64_in": value}})), Settings(STEP, 1.0))
    with pytest.raises(InputError, match=r"a\.uint8_in = 256: must be in the range 0 to 255 of UInt8"):
        assemble(system.with_parameters({"a": {"uint8_in": 256}}))


def test_boolean_becomes_real_by_a_declared_mapping_only(tmp_path: Path) -> None:
    fmu = reference_fmu(tmp_path, "Feedthrough", 2)
    ssd = write_ssd(tmp_path / "s.ssd", {"a": fmu, "b": fmu}, [("a.bool_out", "b.real_in")])
    system = read_system(ssd).with_parameters({"a": {"bool_in": True}})
    with pytest.raises(
        InputError, match=r"connection a\.bool_out -> b\.real_in: Boolean becomes Real only as a Linear"
    ):
        assemble(system)
    mapping = '<ssc:LinearTransformation factor="2" offset="0.5"/>'
    ssd.write_text(
        ssd.read_text().replace('endConnector="real_in"/>', f'endConnector="real_in">{mapping}</ssd:Connection>')
    )
    with Master(assemble(read_system(ssd).with_parameters({"a": {"bool_in": True}})), Settings(STEP, 1.0)) as master:
        master.run()
        assert master.instances["b"].get_real(["real_out"]) == [2.5]


def test_structural_parameters_resize_arrays(tmp_path: Path) -> None:
    """M = 1, n = 2, r = 3: sizes, what the FMU then holds, elements that are set, and the run, as FMPy has them."""
    fmu = state_space(tmp_path)
    _, plain, _ = simulate(fmu, 3.0, {"u": "1 2 3"})
    assert list(plain) == ["c.y[1]", "c.y[2]", "c.y[3]"]
    sizes: dict[str, Value] = {"m": "1", "n": 2, "r": 3}
    values: dict[str, Value] = {"A": "0.5 0.1 -0.2 0.25", "x0": "1 2", "u": "3", "D[2,1]": 0.75}
    rows, found, _ = simulate(fmu, 3.0, {**sizes, **values})
    system = read_system(fmu.with_suffix(".ssd")).with_parameters({"c": {**sizes, **values}})
    with Master(assemble(system), Settings(STEP, 1.0)) as master:
        held = master.instances["c"].get_real([f"D[{k},1]" for k in (1, 2, 3)])
        assert held == pytest.approx([0.3, 0.75, 0.5], rel=1e-15)
    A, B = np.array([[0.5, 0.1], [-0.2, 0.25]]), np.array([0.1, 0.2])
    C, D = 0.1 * (np.arange(6).reshape(3, 2) + 2), np.array([0.3, 0.75, 0.5])
    x = np.array([1.0, 2.0])
    for n in range(13):
        y = np.array([found[f"c.y[{k}]"][n] for k in (1, 2, 3)])
        assert y == pytest.approx(C @ x + 3 * D, rel=1e-14), rows.times[n]
        if (n + 1) % 4 == 0:
            x = x + A @ x + 3 * B
    with pytest.raises(InputError, match=r"parameter c\.m = 0: must be in the range 1 to inf"):
        simulate(fmu, 3.0, {"m": 0})
    with pytest.raises(InputError, match=r"parameter c\.A: wants 4 values, got 9"):
        simulate(fmu, 3.0, {**sizes, "A": "1 0 0 0 1 0 0 0 1"})


def test_scheduled_execution_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"Clocks\.fmu: offers scheduled execution only; co-simulation is wanted"):
        open_fmu(clocks(tmp_path))


def test_clocks_and_binary_variables_are_declined_with_a_sentence(tmp_path: Path) -> None:
    """The FMU runs without them, which is said; a connection of them is refused."""
    fmu = ticking(tmp_path)
    _, found, master = simulate(fmu, 2.0)
    assert found["c.y"][-1] == 2.0
    assert master.notices == [
        "c (Ticking.fmu): clocks are not supported; clock1 never tick",
        "c (Ticking.fmu): binary inputs are not supported; received stay at the start",
    ]
    ssd = write_ssd(tmp_path / "two.ssd", {"a": fmu, "b": fmu}, [("a.sent", "b.received")])
    with pytest.raises(InputError, match=r"connection a\.sent -> b\.received: Binary cannot be connected to Binary"):
        assemble(read_system(ssd))


def test_an_early_return_is_gone_on_from(tmp_path: Path) -> None:
    """An FMU that comes back half-way is asked for the other half; one that does not get on is an error."""
    _, found, _ = simulate(reference_fmu(tmp_path, "Early", 3), 2.0)
    assert (found["c.y"][-1], found["c.n"][-1]) == (2.0, 16)
    with pytest.raises(SimulationError, match=r"c: doStep returned early at t = 0 s without getting on"):
        simulate(reference_fmu(tmp_path, "Stuck", 3), 2.0)


def test_event_mode_is_served_where_an_fmu_needs_it(tmp_path: Path) -> None:
    """Once after the initialisation, then after each of eight steps."""
    _, found, _ = simulate(reference_fmu(tmp_path, "Events", 3), 2.0)
    assert (found["c.y"][-1], found["c.n"].tolist()) == (2.0, list(range(1, 10)))
