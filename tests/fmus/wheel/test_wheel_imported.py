"""Modal data from CSV, TOML and UFF: the same modes by every way, and one sentence for what is refused."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyuff
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.interface import DIRECTIONS
from fmus.modal.data import ModalData, write_modal_data
from fmus.modal.modes import Modes
from fmus.wheel.component import wheel
from fmus.wheel.imported import CSV_COLUMNS, UffAxes, read_csv, read_modes, read_uff

AXES = UffAxes(node=7, lon="+x", lat="-y", ver="-z", spin="-rz")
MODES = Modes(
    omega=2 * np.pi * np.array([417.1, 1104.0, 1104.0]),
    zeta=np.array([1e-4, 2e-4, 1e-4]),
    shape=np.array([[0.0, -0.1151, 0.0012, 0.0], [0.0, -0.1173, -0.0039, 0.0], [0.0018, 0.0, 0.0, 0.66]]),
    labels=("(2,0)", "(3,0) cosine", "(3,0) sine"),
)


def write_csv(path: Path, modes: Modes) -> Path:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(CSV_COLUMNS)
        for i in range(len(modes)):
            values = [modes.omega[i] / (2 * np.pi), modes.zeta[i], *modes.shape[i]]
            writer.writerow([modes.labels[i], *map(repr, map(float, values))])
    return path


def units(**change: Any) -> dict[str, Any]:
    """Return data set 164 in SI, or changed."""
    si = {"type": 164, "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1.0, "force": 1.0}
    return {**si, "temp": 1.0, "temp_offset": 273.15, **change}


def data_55(mode: int, modes: Modes = MODES, mass: float = 1.0, **change: Any) -> dict[str, Any]:
    """Return data set 55 of a mode at nodes 3 and 7 in the axes of `AXES`, or changed."""
    lon, lat, ver, spin = modes.shape[mode] * np.sqrt(mass)
    here = dict(zip(("r1", "r2", "r3", "r4", "r5", "r6"), (lon, -lat, -ver, 0.0, 0.0, -spin), strict=True))
    return {
        "type": 55, "model_type": 1, "analysis_type": 2, "data_ch": 3, "spec_data_type": 8, "data_type": 2,
        "load_case": 1, "mode_n": mode + 1, "freq": modes.omega[mode] / (2 * np.pi), "modal_m": mass,
        "modal_damp_vis": modes.zeta[mode], "modal_damp_his": 0.0, "node_nums": np.array([3, 7]),
        **{name: np.array([9.0, value]) for name, value in here.items()}, **change,
    }  # fmt: skip


def write_uff(path: Path, sets: list[dict[str, Any]]) -> Path:
    pyuff.UFF(str(path)).write_sets(sets, "overwrite")
    return path


def assert_same(found: Modes, wanted: Modes, rtol: float) -> None:
    np.testing.assert_allclose(found.omega, wanted.omega, rtol=rtol)
    np.testing.assert_allclose(found.zeta, wanted.zeta, rtol=rtol)
    np.testing.assert_allclose(found.shape, wanted.shape, rtol=rtol, atol=0)


def test_csv_toml_and_uff_give_the_same_modes(tmp_path: Path) -> None:
    """Three ways to one wheel; CSV is exact but for 2 pi, TOML exact, UFF has six digits."""
    write_modal_data(tmp_path / "wheel.toml", ModalData("a wheel", "made up", MODES))
    write_csv(tmp_path / "wheel.csv", MODES)
    write_uff(tmp_path / "wheel.uff", [units(), *(data_55(i) for i in range(3))])
    assert_same(read_modes(tmp_path / "wheel.toml"), MODES, rtol=0)
    assert_same(read_modes(tmp_path / "wheel.csv"), MODES, rtol=1e-15)
    assert_same(read_modes(tmp_path / "wheel.uff", AXES), MODES, rtol=1e-5)
    assert read_modes(tmp_path / "wheel.csv").labels == MODES.labels


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 1e5), st.floats(0, 1), *[st.floats(0.01, 1e3)] * 4), min_size=1, max_size=4)
)  # fmt: skip
def test_csv_is_read_back(tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, ...]]) -> None:
    """What is written is read, for any modes in rising order."""
    table = np.array(sorted(rows))
    labels = tuple(f"mode {i}" for i in range(len(rows)))
    modes = Modes(2 * np.pi * table[:, 0], table[:, 1], table[:, 2:], labels)
    assert_same(read_csv(write_csv(tmp_path_factory.mktemp("csv") / "wheel.csv", modes)), modes, rtol=1e-15)


def test_imported_modes_make_a_wheel_component(tmp_path: Path) -> None:
    component = wheel(read_csv(write_csv(tmp_path / "wheel.csv", MODES)))
    assert component.state_size == 2 * len(MODES)


def test_uff_shapes_are_divided_by_the_root_of_the_modal_mass(tmp_path: Path) -> None:
    """A shape scaled by sqrt(m) with modal mass m is the same mode, to the six digits of the format."""
    path = write_uff(tmp_path / "wheel.unv", [units(), *(data_55(i, mass=0.25) for i in range(3))])
    assert_same(read_uff(path, AXES), MODES, rtol=1e-5)


def test_uff_hysteretic_damping_counts_half(tmp_path: Path) -> None:
    """At resonance a loss factor eta damps like zeta = eta/2."""
    sets = [data_55(i, modal_damp_vis=0.0, modal_damp_his=0.02) for i in range(3)]
    np.testing.assert_allclose(read_uff(write_uff(tmp_path / "wheel.uff", [units(), *sets]), AXES).zeta, 0.01)


def test_uff_without_rotations_can_leave_spin_out(tmp_path: Path) -> None:
    """Spin 'none' is a choice of the caller and gives a zero column."""
    sets = [{k: v for k, v in data_55(i, data_ch=2).items() if k not in {"r4", "r5", "r6"}} for i in range(3)]
    path = write_uff(tmp_path / "wheel.uff", [units(), *sets])
    modes = read_uff(path, UffAxes(7, "+x", "-y", "-z"))
    np.testing.assert_allclose(modes.shape[:, :3], MODES.shape[:, :3], rtol=1e-5)
    assert not modes.shape[:, 3].any()
    with pytest.raises(ValueError, match=r"wheel.uff, mode 1: direction spin is missing: the data have no 'rz'"):
        read_uff(path, AXES)


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ([data_55(0)], r"data set 164 \(units\) is missing; must say SI"),
        ([units(units_code=5, length=1e3, force=1e3), data_55(0)], "units are code 5 with 1000 per metre and 1000 per"),
        ([units(length=1e3), data_55(0)], "units are code 1 with 1000 per metre"),
        ([units()], "there is no data set 55 in it"),
        ([units(), data_55(0, modal_damp_vis=-0.01)], "mode 1: zeta = -0.01; must be finite and >= 0"),
        ([units(), data_55(0, freq=-1.0)], "mode 1: omega = -6.28319; must be finite and >= 0"),
        ([units(), data_55(1), data_55(0)], "mode 2 has 417.1 Hz after 1104 Hz; must be in rising order"),
        ([units(), data_55(0, modal_m=0.0)], "mode 1: modal mass is 0; must be > 0"),
        ([units(), data_55(0, spec_data_type=12)], "mode 1: data type is 12; must be 8, displacement"),
        ([units(), data_55(0, node_nums=np.array([3, 8]))], "mode 1: node 7 is not in it"),
        ([units(), data_55(0, r2=np.array([9.0, 0.0]))], "direction lon is missing: no mode moves in it"),
        ([units(), data_55(0, analysis_type=5, freq_step_n=1)], "mode 1: analysis type is 5; must be 2"),
    ],
)
def test_bad_uff_is_refused(tmp_path: Path, sets: list[dict[str, Any]], message: str) -> None:
    """One sentence with the file, the mode, the quantity, what was wanted and what came."""
    with pytest.raises(ValueError, match=f"wheel.uff.*{message}"):
        read_uff(write_uff(tmp_path / "wheel.uff", sets), AXES)


HEADER = ",".join(CSV_COLUMNS)
GOOD = "a,417.1,1e-4,0.1,0.1,0.1,0.1"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([HEADER.replace(",ver", "")], "column 'ver' is missing; wanted are label"),
        ([HEADER], "there are no modes in it"),
        ([HEADER, "a,fast,1e-4,0,0.1,0,0"], "line 2: every column but label must be a number"),
        ([HEADER, GOOD, "b,500"], "line 3: every column but label must be a number"),
        ([HEADER, GOOD.replace("1e-4", "-1e-4")], "mode 1: zeta = -0.0001; must be finite and >= 0"),
        ([HEADER, GOOD.replace("417.1", "nan")], "mode 1: omega = nan; must be finite"),
        ([HEADER, GOOD.replace("0.1,0.1", "inf,0.1", 1)], "mode 1: the shape is not finite"),
        ([HEADER, GOOD, "b,100,1e-4,0,0.1,0,0"], "mode 2 has 100 Hz after 417.1 Hz; must be in rising order"),
        ([HEADER, "a,417.1,1e-4,0.1,0.1,0,0.1"], "direction ver is missing: no mode moves in it"),
    ],
)
def test_bad_csv_is_refused(tmp_path: Path, lines: list[str], message: str) -> None:
    path = tmp_path / "wheel.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(ValueError, match=f"wheel.csv.*{message}"):
        read_modes(path)


def test_bad_toml_is_refused(tmp_path: Path) -> None:
    """The order of the frequencies and the directions are checked as for the other formats."""
    path = tmp_path / "wheel.toml"
    write_modal_data(path, ModalData("a wheel", "made up", MODES.keep([1, 0])))
    with pytest.raises(ValueError, match=r"wheel.toml: mode 2 has 417.1 Hz after 1104 Hz"):
        read_modes(path)
    write_modal_data(path, ModalData("a wheel", "made up", MODES.keep([0, 1])))
    with pytest.raises(ValueError, match=r"wheel.toml: direction lon is missing"):
        read_modes(path)


@pytest.mark.parametrize(
    ("axes", "message"),
    [
        ({"lat": "+x"}, "lon and lat are both 'x'; must differ"),
        ({"lat": "y"}, r"lat = 'y'; must be '\+' or '-' and one of x, y, z"),
        ({"ver": "+rz"}, r"ver = '\+rz'; must be"),
        ({"spin": "+z"}, r"spin = '\+z'; must be '\+' or '-' and one of rx, ry, rz"),
        ({"spin": ""}, "spin = ''; must be"),
    ],
)
def test_bad_axes_are_refused(axes: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=f"axes: {message}"):
        UffAxes(**{"node": 7, "lon": "+x", "lat": "-y", "ver": "-z", **axes})  # type: ignore[arg-type]


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"suffix '.xlsx' is unknown; must be .csv, .toml, .uff"):
        read_modes(tmp_path / "wheel.xlsx")
    with pytest.raises(ValueError, match="a UFF file needs the contact node and its axes"):
        read_modes(tmp_path / "wheel.uff")
    with pytest.raises(FileNotFoundError):
        read_modes(tmp_path / "wheel.uff", AXES)
    (tmp_path / "wheel.uff").write_text("    -1\n    55\nnonsense\n    -1\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"wheel.uff: not a readable UFF file"):
        read_modes(tmp_path / "wheel.uff", AXES)


def test_directions_of_the_contract_are_the_columns() -> None:
    assert CSV_COLUMNS[3:] == DIRECTIONS
