"""An exported system of foreign FMUs runs as the original: sizes, declared mappings and steps of its own included."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import write_ssd
from reference_fmus import reference_fmu, state_space
from table_fmus import COMPILER

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.runs.export import export_system
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")
HOW = Settings(0.5, 4.0)


def last(system: System) -> dict[tuple[str, str], float]:
    """Run and return the outputs at the end."""
    with Master(assemble(system), HOW) as master:
        master.run()
        return dict(zip(master.outputs, np.array(master.plan.y).tolist(), strict=True))


def test_round_trip(tmp_path: Path) -> None:
    parts = {"s": state_space(tmp_path), "a": reference_fmu(tmp_path, "Feedthrough", 3)}
    ssd = write_ssd(tmp_path / "s.ssd", parts, [("a.bool_out", "s.u[1]")])
    mapping = '<ssc:LinearTransformation factor="1"/>'
    ssd.write_text(ssd.read_text().replace('endConnector="u[1]"/>', f'endConnector="u[1]">{mapping}</ssd:Connection>'))
    system = read_system(ssd).with_parameters({"s": {"m": 1, "n": 2, "x0": "1 2"}, "a": {"bool_in": True}})
    slow = replace(system, elements={**system.elements, "s": replace(system.elements["s"], step=2.0)})
    export_system(assemble(slow), HOW, tmp_path / "out.ssp")
    again = read_system(tmp_path / "out.ssp")
    assert again.elements["s"].step == 2.0
    found, expected = last(again), last(slow)
    assert found == expected
    assert len([key for key in found if key[0] == "s"]) == 3
    assert last(again.with_parameters({"a": {"bool_in": False}})) != expected
