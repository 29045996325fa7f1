"""Arrays of FMI 3.0 FMUs in an SSP 2.0: whole, by element, and as values of parameter sets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from block_systems import archive, component, connector, description, inline, system, wire
from fmi3_fmu import COMPILER, StateSpace, state_space_fmu

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.runs.export import export_system
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the FMI 3.0 test FMU")


def gain(folder: Path, name: str, D: list[list[float]]) -> Path:
    """Return an FMU y = D u + x with a state x0 that stays, seen in all outputs."""
    return state_space_fmu(folder, name, StateSpace([[0]], np.zeros((1, len(D[0]))), np.ones((len(D), 1)), D))


def element(name: str, file: str, inputs: int, outputs: int, bindings: str = "") -> str:
    array = '<ssc:Float64/><ssc:Dimension size="{}"/>'.format
    both = connector("u", "input", content=array(inputs)) + connector("y", "output", content=array(outputs))
    return component(name, bindings, source=f"resources/{file}.fmu", connectors=both)


def test_arrays_are_connected_whole_and_by_element(tmp_path: Path) -> None:
    """x0 = 2 gives (2, 2, 2), times D (12, 30); half of the second, by its index, is the last input of another D."""
    first, second = gain(tmp_path, "first", [[0], [0], [0]]), gain(tmp_path, "second", [[1, 2, 3], [4, 5, 6]])
    values, matrix = (
        inline({name: 2.0}).replace('version="1.0"', 'version="2.0"').replace("ssv:Real", "ssv:Float64")
        for name in ("x0", "D")
    )
    matrix = matrix.replace('value="2.0"', 'value="1 2 3 4 5 7"')
    root = system(
        element("a", "first", 1, 3, values) + element("b", "second", 3, 2) + element("c", "second", 3, 2, matrix),
        wire("a.y", "b.u")
        + wire("b.y", "c.u", '<ssc:LinearTransformation factor="0.5"/>', ' startIndices="2" endIndices="3"')
        + "".join(wire("a.y", "c.u", more=f' startIndices="{i}" endIndices="{i}"') for i in (1, 2)),
    )
    files = {f"resources/{file.name}": file.read_bytes() for file in (first, second)}
    path = archive(tmp_path / "a.ssp", first, description(root, version="2.0"), files)
    found = assemble(read_system(path))
    assert [str(link.wire) for link in found.links] == [
        "a.y[1] -> b.u[1]", "a.y[2] -> b.u[2]", "a.y[3] -> b.u[3]", "b.y[2] -> c.u[3]", "a.y[1] -> c.u[1]",
        "a.y[2] -> c.u[2]",
    ]  # fmt: skip
    settings = Settings(0.1, 1.0, "jacobi")
    export_system(found, settings, tmp_path / "c.ssp")
    again = assemble(read_system(tmp_path / "c.ssp"))
    assert [str(link.wire) for link in again.links] == [str(link.wire) for link in found.links]
    assert again.parameters == found.parameters
    with Master(found, settings) as master:
        master.run()
        last = {f"{e}.{v}": y for (e, v), y in zip(master.outputs, master.plan.y.tolist(), strict=True)}
    assert [last[f"a.y[{i}]"] for i in (1, 2, 3)] == [2.0, 2.0, 2.0]
    assert [last[f"b.y[{i}]"] for i in (1, 2)] == [12.0, 30.0]
    assert [last[f"c.y[{i}]"] for i in (1, 2)] == [2 + 2 * 2 + 3 * 15.0, 4 * 2 + 5 * 2 + 7 * 15.0]
    pair = element("a", "first", 1, 3) + element("b", "second", 3, 2)
    wrong = description(system(pair, wire("b.y", "a.u")), version="2.0")
    with pytest.raises(InputError, match=r"b.y -> a.u: y\[1\] to y\[2\] on u\[1\] to u\[1\]; shapes must agree"):
        assemble(read_system(archive(tmp_path / "b.ssp", first, wrong, files)))
