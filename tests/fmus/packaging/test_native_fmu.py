"""Native FMUs: one library, no Python, several platforms, and every call of the standard in every state."""

from __future__ import annotations

import ctypes
import json
import re
import zipfile
from importlib.util import find_spec
from pathlib import Path

import fmpy
import lief
import numpy as np
import pytest
from fmpy.validation import validate_fmu
from lxml import etree
from slaves import HEADERS, NAMES, H, InProcess, Slave, Slave3, binary, coupled, signal

from fmus.component import Component, Instance
from fmus.interface import DIRECTIONS, PAIRS
from fmus.modal.component import structure
from fmus.modal.modes import Modes
from fmus.packaging.build import build_fmu, build_fmus
from fmus.packaging.catalogue import components
from fmus.packaging.native.kept import NOTHING_KEPT
from fmus.packaging.target import Target

LIBRARIES = {"libc.so.6", "libm.so.6"}


@pytest.fixture(scope="module")
def declared() -> dict[str, Component]:
    return components()


@pytest.mark.parametrize("fmi", ["native", "native3"])
@pytest.mark.parametrize("name", NAMES)
def test_library_needs_nothing_but_the_c_library(
    request: pytest.FixtureRequest, fmi: str, name: str, tmp_path: Path
) -> None:
    folder: Path = request.getfixturevalue(fmi)
    place = "linux64" if fmi == "native" else "x86_64-linux"
    library = lief.ELF.parse(str(binary(folder / f"{name}.fmu", tmp_path, place)))
    assert library is not None
    assert set(library.libraries) <= LIBRARIES
    exported = {s.name for s in library.exported_symbols}
    assert exported
    assert all(str(s).startswith("fmi") for s in exported)
    needed = {
        str(s.symbol_version.symbol_version_auxiliary.name)
        for s in library.imported_symbols
        if s.symbol_version and s.symbol_version.symbol_version_auxiliary
    }
    if find_spec("ziglang") is not None:
        oldest = max((tuple(int(x) for x in v.removeprefix("GLIBC_").split(".")) for v in needed), default=(0,))
        assert oldest <= (2, 17)


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_function_of_co_simulation_is_there(request: pytest.FixtureRequest, fmi: int, tmp_path: Path) -> None:
    folder: Path = request.getfixturevalue("native" if fmi == 2 else "native3")
    library = ctypes.CDLL(str(binary(folder / "rail-rigid.fmu", tmp_path, "linux64" if fmi == 2 else "x86_64-linux")))
    text = (HEADERS / f"fmi{fmi}Functions.h").read_text()
    names = set(re.findall(rf"FMI{fmi}_Export\s+fmi{fmi}\w+TYPE\s+(\w+)\s*;", text))
    exchange = (
        "EventMode",
        "ContinuousTime",
        "ContinuousStates",
        "IntegratorStep",
        "SetTime",
        "Derivatives",
        "Indicators",
    )
    wanted = {n for n in names if fmi == 3 or not any(word in n for word in (*exchange, "NewDiscreteStates"))}
    assert len(wanted) > 25
    assert [n for n in sorted(wanted) if not hasattr(library, n)] == []


@pytest.mark.parametrize("names", [["rail"], pytest.param(NAMES, marks=pytest.mark.slow)])
def test_a_build_without_kept_files_gives_the_same_bytes(
    native: Path, declared: dict[str, Component], names: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(NOTHING_KEPT, "1")
    files = build_fmus({name: declared[name] for name in names}, tmp_path, Target("native"))
    for name, file in files.items():
        assert file.read_bytes() == (native / f"{name}.fmu").read_bytes(), name


@pytest.mark.parametrize("name", NAMES)
def test_fmi3_is_valid(native3: Path, name: str, tmp_path: Path) -> None:
    assert validate_fmu(str(native3 / f"{name}.fmu")) == []
    with zipfile.ZipFile(native3 / f"{name}.fmu") as archive:
        root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        description = etree.fromstring(archive.read("modelDescription.xml"))
        build = json.loads(archive.read("extra/org.curvesqueal/build.json"))
    schema = etree.XMLSchema(etree.parse(Path(fmpy.__file__).parent / "schema" / "fmi3" / "fmi3TerminalsAndIcons.xsd"))
    schema.assertValid(root)
    variables = {v.get("name") for v in description.iter("Float64")}
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert members
    assert members <= variables
    assert {"kernels", "flags", "compilers", "versions"} <= build.keys()


def test_the_plugs_of_all_rails_fit_the_contact(native3: Path) -> None:
    def plugs(name: str) -> dict[str, set[str]]:
        with zipfile.ZipFile(native3 / f"{name}.fmu") as archive:
            root = etree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        return {t.get("name"): {m.get("memberName") for m in t} for t in root.iter("Terminal")}

    contact = plugs("contact")
    assert set(contact) == {"wheel", "rail"}
    for name in ("wheel", "rail", "rail-rigid", "rail-discrete"):
        assert plugs(name)["contact_point"] == contact["rail"] == contact["wheel"]


# agreement


@pytest.mark.parametrize(("steps", "moves"), [(1_000, 1e-4), pytest.param(10_000, 5e-4, marks=pytest.mark.slow)])
def test_all_routes_give_the_same_numbers_over_many_coupled_steps(
    built: Path, native: Path, declared: dict[str, Component], steps: int, moves: float
) -> None:
    """Case 1 in sliding, started by the pulse: native, Python and in-process, to 1e-12 of each output's largest."""
    pulse = {"pulse_force": 100.0, "pulse_duration": 1e-4}
    names = {"wheel": {}, "rail": {}, "contact": pulse}
    runs = []
    for make in (
        lambda name, p: Slave(built / f"{name}.fmu", p),
        lambda name, p: Slave(native / f"{name}.fmu", p),
        lambda name, p: InProcess(declared[name], p),
    ):
        parts = [make(name, p) for name, p in names.items()]
        runs.append(coupled(parts, steps))
        for part in parts:
            part.close()
    scale = abs(runs[2]).max(axis=0)
    assert scale[1] > moves  # m/s, lateral velocity of the wheel
    for other in runs[:2]:
        assert (abs(other - runs[2]).max(axis=0) <= 1e-12 * scale).all()


@pytest.mark.parametrize("name", NAMES)
def test_fmi3_computes_what_the_component_computes(native3: Path, declared: dict[str, Component], name: str) -> None:
    slave, instance = Slave3(native3 / f"{name}.fmu"), Instance(declared[name])
    slave.start()
    instance.initialise()
    inputs = [v.name for v in declared[name].of("input")]
    outputs = [v.name for v in declared[name].of("output")]
    references = [[slave.variables[n].valueReference for n in names] for names in (inputs, outputs)]
    found, expected = [], []
    for k, u in enumerate(signal(declared[name], 1000)):
        slave.slave.setFloat64(references[0], u.tolist())
        slave.slave.doStep(k * H, H)
        found.append(slave.slave.getFloat64(references[1]))
        instance.inputs[:] = u
        instance.do_step(H)
        expected.append(instance.outputs.copy())
    assert slave.get("time")[0] == pytest.approx(1000 * H)
    slave.close()
    scale = abs(np.array(expected)).max(axis=0)
    assert (abs(np.array(found) - expected).max(axis=0) <= 1e-12 * scale).all()


def test_fmi3_modal_parameters_are_arrays(native3: Path, declared: dict[str, Component]) -> None:
    n = declared["wheel"].state_size // 2
    slave = Slave3(native3 / "wheel.fmu")
    assert slave.variables["frequency"].dimensions[0].start == n
    velocity = np.linspace(1e-3, 2e-3, n)
    slave.set("initial_velocity", velocity.tolist())
    slave.start()
    shape = slave.get("shape_lat", n)
    assert slave.get("v_lat")[0] == pytest.approx(shape @ velocity, rel=1e-12)
    np.testing.assert_allclose(slave.get("modal_velocity", n), velocity)
    for values, message in (([0.0] * (n - 1), "too few"), ([0.0] * (n + 1), "too many")):
        slave.slave.reset()
        slave.messages.clear()
        with pytest.raises(fmpy.fmi1.FMICallException):
            slave.set("initial_velocity", values)
        assert message in slave.messages[-1]
    slave.close()


# directional derivatives


@pytest.mark.parametrize("name", ["wheel", "rail", "rail-rigid"])
def test_directional_derivatives_of_structures_are_the_published_mobilities(native: Path, name: str) -> None:
    slave = Slave(native / f"{name}.fmu")
    slave.step()
    unknown = [slave.reference[f"v_{d}"] for d in DIRECTIONS]
    for column in DIRECTIONS:
        found = slave.slave.getDirectionalDerivative(unknown, [slave.reference[f"f_{column}"]], [2.0])
        for row, value in zip(DIRECTIONS, found, strict=True):
            pair = (row, column) if (row, column) in PAIRS else (column, row)
            (published,) = slave.slave.getReal([slave.reference["y_" + "_".join(pair)]])
            assert value == pytest.approx(2.0 * published, rel=1e-9, abs=1e-20)
    slave.close()


def test_directional_derivatives_of_the_contact_are_differences_of_its_steps(native: Path) -> None:
    """From the same kept state, one input a little more and a little less."""
    slave = Slave(native / "contact.fmu")
    sizes = np.array([1.0] * 8 + [1e-4] * 4 + [0.1, 0.1, 1.0, 1e5, 1.0])
    for k in range(20):
        slave.set_inputs(0.01 * np.sin(0.1 * k + np.arange(17.0)) * sizes)
        slave.step()
    state = slave.slave.getFMUstate()
    base = 0.003 * sizes
    outputs = slave.names("output")
    forces = [n for n in outputs if n != "force_evaluations"]
    scales = {"_f_spin": 1.0, "spin_moment": 1.0}
    for i, name in enumerate(slave.names("input")):
        results = []
        step = 1e-10 if "_u_" in name else 1.0 if name == "normal_load_change" else 1e-6
        for sign in (1, -1, 0):
            slave.slave.setFMUstate(state)
            u = base.copy()
            u[i] += sign * step
            slave.set_inputs(u)
            slave.step()
            results.append(dict(zip(outputs, slave.outputs(), strict=True)))
        found = slave.slave.getDirectionalDerivative(
            [slave.reference[n] for n in forces], [slave.reference[name]], [1.0]
        )
        difference = np.array([(results[0][n] - results[1][n]) / (2 * step) for n in forces])
        size = np.array([max(abs(d), 1e-3 * scales.get(n, 1e3)) for d, n in zip(difference, forces, strict=True)])
        assert (abs(np.array(found) - difference) <= 2e-3 * size).all(), name
    slave.close()


# what cannot be built


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("rust",), "must be native or python"),
        (("python", 3), "PythonFMU writes FMI 2 only"),
        (("native", 1), "must be 2 or 3"),
        (("native", 2, ("sparc-solaris",)), "must be one of x86_64-linux"),
        (("python", 2, ("aarch64-linux",)), "leave the platforms out"),
    ],
)
def test_targets_that_cannot_be_built_are_refused(arguments: tuple[object, ...], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Target(*arguments)  # type: ignore[arg-type]


def test_capacity_leaves_room_for_more_modes(tmp_path: Path, declared: dict[str, Component]) -> None:
    """A structural size is fixed per build; what fits in it may be set."""
    modes = Modes(np.array([1e3]), np.array([0.01]), np.full((1, 4), 0.1))
    fmu = build_fmu(structure("one", "One mode", modes, capacity=3), tmp_path / "one.fmu", Target("native"))
    slave = Slave(fmu, {"frequency_002": 500.0, "damping_ratio_002": 0.01, "shape_lat_002": 0.2})
    assert slave.slave.getReal([slave.reference["shape_lat_002"]]) == [0.2]
    slave.step()
    slave.close()
