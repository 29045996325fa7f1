"""An exported system runs as the one it came from: the same numbers to the last bit, here and in another tool."""

from __future__ import annotations

import json
import subprocess
import sys
import zipfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from block_systems import archive, block_fmu, component, connector, description, inline, parameter_set, system, wire

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master
from orchestrator.errors import InputError
from orchestrator.fmi.instance import Value
from orchestrator.results.file import ResultsFile, open_results
from orchestrator.runs.export import export_system
from orchestrator.runs.scenario import Scenario
from orchestrator.system.reader import read_system


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return block_fmu(tmp_path_factory.mktemp("block"))


@pytest.fixture
def rich(tmp_path: Path, fmu: Path) -> Path:
    """Return an SSP that uses much of the standard: nesting, units, transformations, bindings at three levels."""
    third = '<ssc:LinearTransformation factor="0.3333333333333333" offset="0.1"/>'
    inner = system(
        component("m2", inline({"k": 7.0, "n": 3, "s": "a &amp; b"}), units=("mm", ""))
        + component("m3", inline({"b": 0.7}, "mm"), connectors=connector("b", "parameter", "m")),
        wire("length", "m2.u", third) + wire("m2.y", "far", third),
        connector("length", "input", "m") + connector("far", "output"),
        inline({"m2.k": 0.1}),
        name="inner",
    )
    root = system(
        component("m1", units=("", "km")) + inner,
        wire("start", "m1.u") + wire("m1.y", "inner.length") + wire("inner.far", "out"),
        connector("start", "input", "m") + connector("out", "output"),
        '<ssd:ParameterBinding source="resources/v.ssv"/>',
    )
    units = "".join(
        f'<ssc:Unit name="{name}"><ssc:BaseUnit m="1" factor="{factor}"/></ssc:Unit>'
        for name, factor in {"m": 1, "mm": 0.001, "km": 1000}.items()
    )
    text = description(root, more=f"<ssd:Units>{units}</ssd:Units>")
    values = parameter_set({"start": 0.123, "inner.m2.b": 1e-3, "m1.on": True})
    return archive(tmp_path / "rich.ssp", fmu, text, {"resources/v.ssv": values})


def recorded(scenario: Scenario, path: Path) -> dict[str, np.ndarray]:
    """Run a scenario; return every recorded signal and the last outputs in full precision."""
    assembly, settings = scenario.prepare()
    with Master(assembly, settings) as master, ResultsFile(path, master.signals(), {}) as results:
        master.run(results)
        last = master.plan.y.copy()
    with open_results(path) as data:
        return {"last outputs": last, **{str(name): data[name].to_numpy() for name in data.variables}}


def same_run(scenario: Scenario, folder: Path) -> Path:
    """Export a scenario, run both, compare to the bit; return the export."""
    exported = folder / "exported.ssp"
    export_system(*scenario.prepare(), exported)
    first = recorded(scenario, folder / "first.nc")
    second = recorded(Scenario(str(exported), record_every=scenario.record_every), folder / "second.nc")
    assert first.keys() == second.keys()
    for name, values in first.items():
        np.testing.assert_array_equal(values, second[name], err_msg=name)
    return exported


def test_export_of_a_rich_system_runs_the_same(tmp_path: Path, rich: Path) -> None:
    values: dict[str, dict[str, Value]] = {"inner": {"m2.k": 0.7}, "m1": {"n": 2}}
    scenario = Scenario(str(rich), duration=0.02, step=1e-3, algorithm="jacobi", values=values, record_every=1)
    exported = same_run(scenario, tmp_path)
    before, after = scenario.prepare()[0], assemble(read_system(exported))
    assert after.parameters == before.parameters
    assert [(link.gain, link.offset) for link in after.outputs] == [(1 / 3, 0.1)]
    assert not read_system(exported).notices


def test_export_of_case_3_with_another_rail_runs_the_same(tmp_path: Path, built: Path) -> None:
    """Random start, another friction, a rail in place of the case's own, another step: all of it is in the file."""
    scenario = Scenario(
        "case3", duration=2e-3, step=1e-5, values={"contact": {"mu0": "0.35"}},
        sources={"rail": built / "rail-rigid.fmu"}, seed=5,
    )  # fmt: skip
    exported = same_run(scenario, tmp_path)
    with zipfile.ZipFile(exported) as packed:
        names = packed.namelist()
    assert "resources/rail-rigid.fmu" in names
    assert "resources/rail.fmu" not in names
    assert Scenario(str(exported)).prepare()[1].step == 1e-5


def test_export_gives_the_same_bytes_and_keeps_stages(tmp_path: Path, fmu: Path) -> None:
    stage = '<ssc:Annotation type="curvesqueal"><c:Component xmlns:c="urn:curvesqueal:ssp" stage="2"/></ssc:Annotation>'
    more = f"<ssd:Annotations>{stage}</ssd:Annotations>"
    ssd = description(system(component("a b", more=more) + component("a_b", inline({"b": 1.0}))))
    scenario = Scenario(str(archive(tmp_path / "a.ssp", fmu, ssd)), step=1e-3)
    for name in ("1.ssp", "2.ssp"):
        export_system(*scenario.prepare(), tmp_path / name)
    assert (tmp_path / "1.ssp").read_bytes() == (tmp_path / "2.ssp").read_bytes()
    found = read_system(tmp_path / "1.ssp")
    assert found.stages == {"a b": 2}
    assert len({element.source for element in found.elements.values()}) == 1


ECOS = """
import json, sys
from ecospy import EcosSimulation
with EcosSimulation(ssp_path=sys.argv[1], step_size=1e-3) as simulation:
    assert simulation.init(parameter_set="initialValues")
    simulation.step(20)
    print("RESULT" + json.dumps([simulation.get_real(name) for name in json.loads(sys.argv[2])]))
    simulation.terminate()
"""


def test_another_tool_gives_the_same_numbers_from_the_export(tmp_path: Path, rich: Path) -> None:
    """Ecos reads neither nesting nor mappings nor system connectors; in the export it needs none of them."""
    assembly, settings = Scenario(str(rich), duration=0.02, step=1e-3, algorithm="jacobi").prepare()
    exported = tmp_path / "exported.ssp"
    export_system(replace(assembly, outputs=()), settings, exported)
    with Master(assembly, settings) as master:
        master.run()
        outputs = zip(master.outputs, master.plan.y.tolist(), strict=True)
        ours = {"::".join(output): y for output, y in outputs if output[1] == "y"}
    done = subprocess.run(
        [sys.executable, "-c", ECOS, str(exported), json.dumps(list(ours))],
        capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    if "libtbb" in done.stderr:
        pytest.skip("ecospy needs the Debian package libtbb12")
    line = next((text for text in done.stdout.splitlines() if text.startswith("RESULT")), None)
    assert line is not None, done.stderr[-2000:]
    assert json.loads(line.removeprefix("RESULT")) == pytest.approx(list(ours.values()), rel=1e-12)
    assert min(map(abs, ours.values())) > 1e-6


def test_command_writes_what_run_takes(tmp_path: Path, rich: Path) -> None:
    def call(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "orchestrator", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)

    out = tmp_path / "out.ssp"
    done = call("export", str(rich), str(out), "--step", "1e-3", "--algorithm", "jacobi", "--set", "inner.m2.k=2")
    assert done.returncode == 0, done.stderr
    assert "note: input inner.m3.u of block.fmu is connected to nothing; it stays at 0\n" in done.stderr
    again = call("export", str(rich), str(out), "--step", "1e-3")
    assert again.returncode == 1
    assert "is there already; give another name, or --force" in again.stderr
    assert Scenario(str(out)).prepare()[0].parameters["inner.m2"]["k"] == 2.0
    with pytest.raises(InputError, match=r"the system has no component 'outer'; it has m1, inner.m2, inner.m3"):
        Scenario(str(rich), step=1e-3, values={"outer": {"m2.k": 1.0}}).prepare()
