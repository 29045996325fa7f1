"""The commands `wheel measured` and `wheel treat`: files in, wheels with labels out, refusals in a sentence."""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import typer
from frf_files import write_uff
from typer.testing import CliRunner

from fmus.modal.data import read_modal_data
from fmus.modal.modes import Modes, receptance
from fmus.wheel.class158 import class158
from orchestrator.commands.structures.wheel_measured import measured
from orchestrator.commands.structures.wheel_treat import treat
from orchestrator.errors import InputError

TRUTH = Modes(
    omega=2 * np.pi * np.array([418.34, 1102.0]),
    zeta=np.array([1e-3, 1e-3]),
    shape=np.array([[0, -0.115, 0.02, 0], [0, -0.117, 0.03, 0]]),
)
F = np.arange(350.0, 1200.0, 1.0)
CODE = {1: -2, 2: -3}
"""Codes of the measurement's axes for lat and ver: y to the field side, z downwards."""
NONE = {"ordinate_axis_units_lab": "NONE", "orddenom_axis_units_lab": "NONE"}


def call(command: Callable[..., None], *arguments: str) -> str:
    """Return what a command prints; raise what it raises."""
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, [*arguments], catch_exceptions=False).output


def functions(path: Path) -> Path:
    """Write the receptances of two modes of the cosine family along the file's axes, both negative."""
    H = receptance(2 * np.pi * F, TRUTH)
    sets = [
        {"rsp_dir": CODE[j], "ref_dir": CODE[k], "data": H[:, j, k], "x": F, "abscissa_min": F[0], "abscissa_inc": 1.0,
         "ordinate_spec_data_type": 8, **NONE}
        for j, k in itertools.combinations_with_replacement((1, 2), 2)
    ]  # fmt: skip
    return write_uff(path, sets)


@pytest.mark.slow
def test_a_measured_wheel_gets_modes_and_labels(tmp_path: Path) -> None:
    """Both modes found again, with the labels of the known wheel; what was used is told.

    1 %: data count as known within 0.2 % at most, and the fit ends there.
    """
    out = tmp_path / "wheel.toml"
    axes = ["--axis", "1=lon", "--axis", "-2=lat", "--axis", "-3=ver"]
    options = [*axes, "--like", "class158", "--out", str(out), "--json"]
    data = json.loads(call(measured, str(functions(tmp_path / "w.uff")), *options))
    rigid, areas = data["notes"]
    assert rigid == "not measured, so the wheel is rigid there: lon, spin"
    assert areas.startswith("areas of ")
    assert " are those of class158, of the other " in areas
    assert [row["direction"] for row in data["used"]] == ["lat", "lat due to ver", "ver"]
    written, known = read_modal_data(out), class158()
    modes = written.modes
    assert written.areas is not None
    for i, label in enumerate(("(2,0) cosine", "(3,0) cosine")):
        found = modes.labels.index(label)
        assert modes.omega[found] == pytest.approx(TRUTH.omega[i], rel=1e-5)
        assert modes.zeta[found] == pytest.approx(TRUTH.zeta[i], rel=1e-2)
        np.testing.assert_allclose(np.abs(modes.shape[found]), np.abs(TRUTH.shape[i]), rtol=1e-2, atol=1e-9)
        assert written.areas[found, 0] == known.area_axial[known.modes.labels.index(label)]


def test_cross_functions_need_axes(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"w.uff: holds cross functions, whose signs depend on the axes: give the option"
    ):
        measured(files=[functions(tmp_path / "w.uff")])


def test_treat_writes_a_wheel_with_absorbers(tmp_path: Path) -> None:
    """The split in the JSON is that of the modes in the file."""
    out = tmp_path / "treated.toml"
    arguments = ["class158", "--absorber", "(3,0)", "--mass", "2", "--damp", "(2,0)=1e-3", "--out", str(out), "--json"]
    data, modes = json.loads(call(treat, *arguments)), read_modal_data(out).modes
    own = [i for i, label in enumerate(modes.labels) if label.startswith("(3,0)")]
    assert sorted({round(modes.omega[i] / (2 * np.pi), 2) for i in own}) == pytest.approx(data["split_hz"], abs=0.01)
    assert data["modes"] == len(modes) == 124
    assert all(modes.zeta[i] == 1e-3 for i, label in enumerate(modes.labels) if label.startswith("(2,0)"))
    with pytest.raises(InputError, match="--absorber and --mass go together"):
        call(treat, "class158", "--absorber", "(3,0)")
    with pytest.raises(InputError, match=r"no mode is called \(9,0\)"):
        call(treat, "class158", "--damp", "(9,0)=1", "--out", str(tmp_path / "x.fmu"))
