"""A wheel FMU from modal data by one command, and what is refused."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from fmus.component import Instance
from fmus.modal.component import structure
from fmus.wheel.imported import read_modes
from orchestrator.commands.structures.wheel_build import build
from orchestrator.errors import InputError

TABLE = """label,frequency_hz,damping_ratio,lon,lat,ver,spin
first,500,1e-3,0.02,0.1,0.01,0.3
second,1500,1e-4,-0.03,0.2,0.05,-0.1
"""


def test_a_wheel_fmu_from_a_table_moves_as_its_modes_do(tmp_path: Path) -> None:
    """The FMU of two modes under a held lateral force against the component of the same modes, 100 steps."""
    table = tmp_path / "own.csv"
    table.write_text(TABLE)
    fmu = tmp_path / "own.fmu"
    build(files=[str(table)], out=fmu)
    assert validate_fmu(str(fmu)) == []
    push = np.array([(0.0, 10.0), (1.0, 10.0)], dtype=[("time", float), ("f_lat", float)])
    found = fmpy.simulate_fmu(str(fmu), stop_time=5e-4, step_size=5e-6, output_interval=5e-6, input=push)
    instance = Instance(structure("own", "", read_modes(table).modes))
    instance.initialise()
    instance.inputs[1] = 10.0
    for _ in range(100):
        instance.do_step(5e-6)
    last = [found[name][-1] for name in ("v_lon", "v_lat", "v_ver", "v_spin")]
    assert last == pytest.approx(instance.outputs[:4].tolist(), rel=1e-12)


def test_the_identified_wheel_becomes_an_fmu(tmp_path: Path) -> None:
    build(files=["class158"], out=tmp_path / "class158.fmu")
    assert validate_fmu(str(tmp_path / "class158.fmu")) == []


def test_mistakes_are_one_sentence(tmp_path: Path) -> None:
    table = tmp_path / "own.csv"
    table.write_text(TABLE.replace("1e-3", "-1e-3"))
    taken = tmp_path / "taken.fmu"
    taken.write_bytes(b"mine")
    cases = {
        (str(table), tmp_path / "a.fmu", None): "-0.001",
        (str(tmp_path / "no.csv"), tmp_path / "a.fmu", None): "no such file",
        (str(table), tmp_path / "a.zip", None): "must end with .fmu",
        (str(table), taken, None): "is there already",
        (str(table), tmp_path / "a.fmu", ("12,x",)): "axis 12,x: must be CODE=DIRECTION",
    }
    for (modes, out, axes), message in cases.items():
        with pytest.raises(InputError, match=message):
            build(files=[modes], axis=None if axes is None else list(axes), out=out)
    assert taken.read_bytes() == b"mine"
