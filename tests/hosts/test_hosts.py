"""The native SSP in hosts that are not ours: ecos, libcosim and the container of the FMU Manipulation Toolbox.

All of them couple by Jacobi, so they must give the numbers of our `jacobi`. They make no exchange after the
initialisation; the runs start from rest, where that changes nothing.
"""

from __future__ import annotations

import csv
import importlib.util
import json
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp

from fmus.interface import connections
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.system.reader import read_system

H = 5e-6
STEPS = 400
WATCHED = ("contact.wheel_f_lat", "contact.wheel_f_ver", "contact.normal_force", "contact.tangential_force_lat")

LIBCOSIM = """
import json, os, sys
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
log_output_level(CosimLogLevel.ERROR)
execution = CosimExecution.from_ssp_file(ssp_path=sys.argv[1], step_size=int(sys.argv[2]))
observer = CosimObserver.create_last_value()
execution.add_observer(observer=observer)
contact = execution.slave_index_from_instance_name("contact")
assert execution.step(int(sys.argv[3]))
values = observer.last_real_values(slave_index=contact, variable_references=json.loads(sys.argv[4]))
print("RESULT" + json.dumps(list(values)), flush=True)
os._exit(0)
"""


COFMUPY = """
import json, sys
from cofmupy import Coordinator
config, step, steps, names = json.loads(sys.argv[1]), float(sys.argv[2]), int(sys.argv[3]), json.loads(sys.argv[4])
coordinator = Coordinator()
coordinator.start(config)
for _ in range(steps):
    coordinator.do_step(step)
results = coordinator.get_results()
print("RESULT" + json.dumps([float(results[tuple(name.split("."))][-1]) for name in names]), flush=True)
"""


@pytest.fixture(scope="module")
def expected(native: Path) -> np.ndarray:
    """Return the watched outputs after all steps of our own Jacobi master."""
    with Master(assemble(read_system(native / "curvesqueal.ssp")), Settings(H, STEPS * H, "jacobi")) as master:
        master.run()
        names = [f"{component}.{variable}" for component, variable in master.outputs]
        values: np.ndarray = master.plan.y[[names.index(name) for name in WATCHED]].copy()
    assert abs(values[0]) > 1.0
    return values


def package(name: str) -> Path:
    """Return the folder of an installed package, or skip."""
    spec = importlib.util.find_spec(name)
    if spec is None or spec.origin is None:
        pytest.skip(f"needs {name}")
    return Path(spec.origin).parent


def package_of(native: Path, folder: Path, bare: bool) -> Path:
    """Return the SSP, or one as made by hand: components and wires, nothing set."""
    if not bare:
        return native / "curvesqueal.ssp"
    target = folder / "bare.ssp"
    with zipfile.ZipFile(native / "curvesqueal.ssp") as source, zipfile.ZipFile(target, "w") as archive:
        for name in ("resources/wheel.fmu", "resources/rail.fmu", "resources/contact.fmu"):
            archive.writestr(name, (native / Path(name).name).read_bytes())
        text = source.read("SystemStructure.ssd").decode()
        bindings = r"<ssd:ParameterBindings>.*?</ssd:ParameterBindings>"
        archive.writestr("SystemStructure.ssd", re.sub(bindings, "", text, flags=re.DOTALL))
    return target


BARE = pytest.mark.parametrize("bare", [False, True], ids=["ssp", "wired by hand"])


@BARE
def test_the_program_ecos_agrees(native: Path, expected: np.ndarray, tmp_path: Path, bare: bool) -> None:
    """A program in C++ with no Python in it; it writes six decimals. Start values are those of Case 1."""
    for file in (package("ecospy") / "binaries").iterdir():
        shutil.copy(file, tmp_path)
    program = tmp_path / "ecos"
    program.chmod(0o755)
    command = [
        str(program), "simulate", "--path", str(package_of(native, tmp_path, bare)), "--stopTime",
        repr((STEPS + 0.5) * H), "--stepSize", repr(H), "--noParallel", "--logLevel", "err",
    ]  # fmt: skip
    command += [] if bare else ["--parameterSet", "initialValues"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    if "libtbb" in done.stderr:
        pytest.skip("ecos needs the Debian package libtbb12")
    assert done.returncode == 0, done.stderr[-2000:]
    with next(tmp_path.glob("*.csv")).open() as table:
        rows = list(csv.DictReader(table, skipinitialspace=True))
    last = next(row for row in rows if int(row["iterations"]) == STEPS)
    found = [float(last[name.replace(".", "::") + "[REAL]"]) for name in WATCHED]
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-5)


@BARE
def test_libcosim_agrees(native: Path, expected: np.ndarray, tmp_path: Path, bare: bool) -> None:
    package("libcosimpy")
    folder = tmp_path / "ssp"
    shutil.unpack_archive(package_of(native, tmp_path, bare), folder, "zip")
    description = fmpy.read_model_description(str(native / "contact.fmu"))
    reference = {v.name: v.valueReference for v in description.modelVariables}
    wanted = json.dumps([reference[name.removeprefix("contact.")] for name in WATCHED])
    done = subprocess.run(
        [sys.executable, "-c", LIBCOSIM, str(folder), str(round(H * 1e9)), str(STEPS), wanted],
        capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    line = next((text for text in done.stdout.splitlines() if text.startswith("RESULT")), None)
    assert line is not None, done.stderr[-2000:]
    np.testing.assert_allclose(json.loads(line.removeprefix("RESULT")), expected, rtol=1e-9, atol=1e-9)


def test_a_container_of_the_fmu_manipulation_toolbox_agrees(native: Path, expected: np.ndarray, tmp_path: Path) -> None:
    """The toolbox makes one FMU of the three; FMPy runs it: Case 1 from the start values of the FMUs alone."""
    package("fmu_manipulation_toolbox")
    for name in ("wheel", "rail", "contact"):
        shutil.copy(native / f"{name}.fmu", tmp_path)
    system = {
        "name": "coupled.fmu",
        "step_size": H,
        "fmu": ["wheel.fmu", "rail.fmu", "contact.fmu"],
        "link": [
            [f"{c.start_element}.fmu", c.start_connector, f"{c.end_element}.fmu", c.end_connector]
            for c in connections()
        ],
        "output": [["contact.fmu", name.removeprefix("contact."), name.removeprefix("contact.")] for name in WATCHED],
    }
    (tmp_path / "coupled.json").write_text(json.dumps(system))
    program = Path(sys.executable).parent / "fmucontainer"
    command = [str(program), "-container", "coupled.json", "-fmu-directory", "."]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300)
    file = tmp_path / "coupled.fmu"
    assert file.is_file(), done.stderr[-2000:]
    names = [name.removeprefix("contact.") for name in WATCHED]
    result = fmpy.simulate_fmu(str(file), stop_time=STEPS * H, step_size=H, output_interval=H, output=names)
    np.testing.assert_allclose([result[n][-1] for n in names], expected, rtol=1e-6, atol=1e-6)


def test_a_runner_that_ignores_parameter_sets_runs_case_1(native: Path, expected: np.ndarray) -> None:
    """FMPy's runner of SSPs reads the structure only; the contact has the values of its case as start values."""
    result = simulate_ssp(str(native / "curvesqueal.ssp"), stop_time=STEPS * H, step_size=H)
    np.testing.assert_allclose([result[name][-1] for name in WATCHED], expected, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_cofmupy_agrees(native: Path, expected: np.ndarray) -> None:
    """In an environment of its own (`make hosts`), because it wants older versions of FMPy and PythonFMU."""
    program = Path(sys.prefix) / "hosts" / "bin" / "python"
    if not program.is_file():
        pytest.skip("needs the environment that `make hosts` makes")
    config = {
        "fmus": [{"id": name, "path": str(native / f"{name}.fmu")} for name in ("wheel", "rail", "contact")],
        "connections": [
            {
                "source": {"id": c.start_element, "variable": c.start_connector},
                "target": {"id": c.end_element, "variable": c.end_connector},
            }
            for c in connections()
        ],
        "cosim_method": "jacobi",
        "iterative": False,
    }
    arguments = [json.dumps(config), repr(H), str(STEPS), json.dumps(WATCHED)]
    command = [str(program), "-c", COFMUPY, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
    line = next((text for text in done.stdout.splitlines() if text.startswith("RESULT")), None)
    assert line is not None, done.stderr[-2000:]
    np.testing.assert_allclose(json.loads(line.removeprefix("RESULT")), expected, rtol=1e-9, atol=1e-9)
