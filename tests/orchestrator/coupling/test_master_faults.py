"""What the master says when something fails or does not fit, and what is left of the run."""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from master_runs import run
from toy_fmus import toy_fmu, toy_ssd

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.system.cases import built_ssp
from orchestrator.system.model import System
from orchestrator.system.reader import read_system


@pytest.fixture(scope="module")
def case1(built: Path) -> System:
    return read_system(built / "curvesqueal.ssp")


@pytest.mark.parametrize(
    ("component", "name", "value", "message"),
    [
        ("contact", "mu", "0.4", r"parameter contact.mu: contact.fmu has no variable 'mu'; did you mean 'mu0'\?"),
        ("contact", "mu0", "3", r"parameter contact.mu0 = 3: must be in the range 0 to 2$"),
        ("contact", "mu0", "nan", r"parameter contact.mu0 = nan: must be in the range"),
        ("contact", "mu0", "much", r"parameter contact.mu0 = much: must be a number"),
        ("contact", "grid_cells", "2.5", r"parameter contact.grid_cells = 2.5: must be a whole number"),
        ("contact", "linear_spring", "maybe", r"must be true or false"),
        ("contact", "normal_force", "1", r"is no parameter but output"),
        ("brake", "mu0", "1", r"set brake: the system has no component 'brake'; it has wheel, rail, contact"),
    ],
)
def test_bad_parameters_are_one_sentence(case1: System, component: str, name: str, value: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        assemble(case1.with_parameters({component: {name: value}}))


@pytest.mark.parametrize(
    ("how", "message"),
    [
        ({"step": -1e-6, "duration": 1.0}, "step = -1e-06 s: must be > 0"),
        ({"step": 1e-3, "duration": 1e-4}, "duration = 0.0001 s: must be at least one step"),
        ({"step": 1e-3, "duration": 1.0, "record_every": 0}, "record_every = 0: must be >= 1"),
    ],
)
def test_bad_settings_are_one_sentence(how: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Settings(**how)  # type: ignore[arg-type]


def test_rail_without_the_contracts_variables_is_refused(case1: System, built: Path) -> None:
    with pytest.raises(
        InputError, match=r"connection rail.v_lon -> contact.rail_v_lon: contact.fmu has no variable 'v_lon'"
    ):
        assemble(case1.with_sources({"rail": built / "contact.fmu"}))
    with pytest.raises(InputError, match="the system has no component 'sleeper'"):
        case1.with_sources({"sleeper": built / "rail.fmu"})


GOOD = "self.y = 0.5 * self.u + self.p"


def ring(folder: Path, body: str, unit: str = "", extra: str = "") -> Path:
    """Return an SSD of a good toy and one whose step is `body`."""
    return toy_ssd(folder, toy_fmu(folder, "Good", GOOD), toy_fmu(folder, "Other", body), unit, extra)


def test_any_fmus_can_be_coupled(tmp_path: Path) -> None:
    """Two affine maps in a ring, Jacobi: y_a = y_b/2 + 1, y_b = -y_a/2 + 1 reach their fixed point 1.2 and 0.4."""
    path = ring(tmp_path, GOOD, extra='<ssc:LinearTransformation factor="-1" offset="0"/>')
    _, last = run(read_system(path), Settings(1e-4, 0.01, "jacobi"))
    assert sorted(last) == pytest.approx([0.4, 1.2], rel=1e-12)


def test_algebraic_loop_runs_with_jacobi_as_the_refusal_says(tmp_path: Path) -> None:
    """The same ring, declared as a true loop: staggered refuses and names a way out, and that way works."""
    first, second = (toy_fmu(tmp_path, name, GOOD, feedthrough=True) for name in ("First", "Second"))
    turned = '<ssc:LinearTransformation factor="-1" offset="0"/>'
    system = read_system(toy_ssd(tmp_path, first, second, extra=turned))
    with pytest.raises(InputError, match=r"algebraic loop: .* cannot get and set .* use the algorithm jacobi"):
        run(system, Settings(1e-4, 0.01))
    _, last = run(system, Settings(1e-4, 0.01, "jacobi"))
    assert sorted(last) == pytest.approx([0.4, 1.2], rel=1e-12)


def test_a_component_may_end_the_run_in_fmi_2(tmp_path: Path) -> None:
    """fmi2Discard with fmi2Terminated, which is what False means to PythonFMU: the run ends well, its rows are kept."""
    system = read_system(ring(tmp_path, "if self.steps == 7: return False"))
    path = tmp_path / "r.nc"
    with (
        Master(assemble(system), Settings(1e-4, 0.01, "jacobi", record_every=1)) as master,
        ResultsFile(path, master.signals(), {}) as results,
    ):
        assert master.run(results).ended == "b ended the simulation at t = 0.0006 s"
    with open_results(path) as data:
        assert data.sizes["time"] == 7


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (
            "if self.steps == 7: raise RuntimeError('out of sand')",
            r"b: doStep returned fatal at t = 0.0006 s: out of sand",
        ),
        (
            "self.y = float('nan') if self.steps == 7 else 0.0",
            r"b: output y = nan at t = 0.0006 s: not a finite number",
        ),
    ],
)
def test_failing_component_is_named_and_results_are_kept(tmp_path: Path, body: str, message: str) -> None:
    """In a process of its own: PythonFMU corrupts the memory of one in which a slave raises an exception."""
    path = ring(tmp_path, body)
    command = [sys.executable, "-m", "orchestrator", "run", str(path), "--step", "1e-4", "--algorithm", "jacobi"]
    command += ["--record-every", "1", "--out", str(tmp_path)]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert re.search(message, done.stderr), done.stderr
    with open_results(tmp_path / "ring.nc") as data:
        assert data.sizes["time"] == 7


def test_units_that_do_not_match_are_refused(tmp_path: Path, built: Path) -> None:
    """A rail whose SSD says that a velocity is in N."""
    source = (Path(__file__).parents[3] / "ssp" / "SystemStructure.ssd").read_text()
    wrong = source.replace(
        '<ssd:Connector name="v_lat" kind="output">\n            <ssc:Real unit="m/s" />',
        '<ssd:Connector name="v_lat" kind="output">\n            <ssc:Real unit="N" />',
        1,
    )
    assert wrong != source
    folder = tmp_path / "system"
    system = unpack_beside(built, folder, wrong)
    with pytest.raises(InputError, match="the units do not match: N cannot become m/s"):
        assemble(read_system(system))


def test_unit_factors_are_applied(tmp_path: Path, built: Path) -> None:
    """A parameter in kN arrives in N."""
    system = unpack_beside(built, tmp_path / "system", None)
    file = system.parent / "resources" / "contact-case1.ssv"
    file.write_text(file.read_text().replace('value="100.0" unit="N"', 'value="0.1" unit="kN"'))
    assert assemble(read_system(system)).parameters["contact"]["pulse_force"] == pytest.approx(100.0)


def unpack_beside(built: Path, folder: Path, description: str | None) -> Path:
    """Unpack the SSP into a folder, with another default description; return the SSD."""
    import zipfile  # noqa: PLC0415

    with zipfile.ZipFile(built / "curvesqueal.ssp") as archive:
        archive.extractall(folder)
    ssd = folder / "SystemStructure.ssd"
    if description is not None:
        ssd.write_text(description)
    return ssd


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<ssd:Connection ", "<ssd:Conection ", "Element.*Conection.*not expected"),
        ("</ssd:System>", "", "is not well-formed XML"),
        (
            'endElement="contact" endConnector="rail_u_ver"',
            'endElement="contact" endConnector="rail_u_lat"',
            "is fed by two connections",
        ),
        (
            'endConnector="wheel_u_ver"',
            'endConnector="wheel_u_var"',
            "has no variable 'wheel_u_var'; did you mean 'wheel_u_ver'",
        ),
        (
            'startElement="wheel" startConnector="u_ver"',
            'startElement="axle" startConnector="u_ver"',
            "names the component 'axle'",
        ),
        ('source="resources/rail.fmu"', 'source="../rail.fmu"', "lies outside the system's folder"),
        ('source="resources/rail.fmu"', 'source="resources/no.fmu"', "no such FMU file"),
    ],
)
def test_bad_descriptions_are_one_sentence(tmp_path: Path, built: Path, old: str, new: str, message: str) -> None:
    source = (Path(__file__).parents[3] / "ssp" / "SystemStructure.ssd").read_text()
    assert old in source
    system = unpack_beside(built, tmp_path / "system", source.replace(old, new, 1))
    with pytest.raises(InputError, match=message):
        assemble(read_system(system))


def test_unconnected_input_is_told(tmp_path: Path, built: Path) -> None:
    source = (Path(__file__).parents[3] / "ssp" / "SystemStructure.ssd").read_text()
    lines = [line for line in source.splitlines() if 'endConnector="wheel_v_lat"' not in line]
    system = unpack_beside(built, tmp_path / "system", "\n".join(lines))
    said = "input contact.wheel_v_lat of contact.fmu is connected to nothing; it stays at 0.0"
    assert assemble(read_system(system)).notices == (said,)
    given = read_system(system).with_parameters({"contact": {"wheel_v_lat": 0.0}})
    assert not assemble(given).notices


def test_xml_entities_are_not_expanded(tmp_path: Path, built: Path) -> None:
    source = (Path(__file__).parents[3] / "ssp" / "SystemStructure.ssd").read_text()
    body = source.split("?>", 1)[1]
    system = unpack_beside(built, tmp_path / "s", '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "b">]>' + body)
    with pytest.raises(InputError, match="document type declaration; refused"):
        read_system(system)


KILLED = """
import sys
from pathlib import Path
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.results.file import ResultsFile
from orchestrator.system.cases import built_ssp
from orchestrator.system.reader import read_system
with Master(assemble(read_system(Path(sys.argv[1]))), Settings(5e-6, 100.0)) as master:
    with ResultsFile(Path(sys.argv[2]), master.signals(), {}) as results:
        master.run(results, lambda progress: print(progress.steps, flush=True))
"""


def test_a_killed_run_leaves_readable_results(built: Path, tmp_path: Path) -> None:
    """Kill -9 in the middle of a long run: everything that was reported is in the file."""
    path = tmp_path / "r.nc"
    command = [sys.executable, "-c", KILLED, str(built / "curvesqueal.ssp"), str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        reported = [int(process.stdout.readline()) for _ in range(12)]
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
    with open_results(path) as data:
        assert data.sizes["time"] >= reported[-1] // 4
        assert np.isfinite(data["wheel.v_lat"].to_numpy()).all()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_keeps_its_results(tmp_path: Path, number: signal.Signals) -> None:
    """Ctrl-C and SIGTERM end the run in order: message, exit code 130, readable results."""
    built_ssp()
    command = [
        sys.executable,
        "-m",
        "orchestrator",
        "run",
        "case1",
        "--duration",
        "100",
        "--json",
        "--out",
        str(tmp_path),
    ]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        path = tmp_path / "case1.nc"
        limit = time.monotonic() + 120
        while not (path.exists() and path.stat().st_size > 300_000) and time.monotonic() < limit:
            time.sleep(0.1)
        process.send_signal(number)
        out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "stopped; results up to then are in" in err
    assert json.loads(out)["completed"] is False
    with open_results(path) as data:
        assert data.sizes["time"] > 100
