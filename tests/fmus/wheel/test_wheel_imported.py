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
from fmus.wheel.imported import CSV_COLUMNS, ModalChoice, read_csv, read_modes, wheel_from_modes

AXES = ModalChoice(node=7, axes={1: "lon", -2: "lat", -3: "ver"})
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
    assert_same(read_modes(tmp_path / "wheel.toml").modes, MODES, rtol=0)
    assert_same(read_modes(tmp_path / "wheel.csv").modes, MODES, rtol=1e-15)
    assert_same(read_modes(tmp_path / "wheel.uff", AXES).modes, MODES, rtol=1e-5)
    assert read_modes(tmp_path / "wheel.csv").modes.labels == MODES.labels


@settings(max_examples=25, deadline=None)
@given(
    st.lists(st.tuples(st.floats(0, 1e5), st.floats(0, 1), *[st.floats(0.01, 1e3)] * 4), min_size=1, max_size=4)
)  # fmt: skip
def test_csv_is_read_back(tmp_path_factory: pytest.TempPathFactory, rows: list[tuple[float, ...]]) -> None:
    """What is written is read, for any modes in rising order."""
    table = np.array(sorted(rows))
    labels = tuple(f"mode {i}" for i in range(len(rows)))
    modes = Modes(2 * np.pi * table[:, 0], table[:, 1], table[:, 2:], labels)
    assert_same(read_csv(write_csv(tmp_path_factory.mktemp("csv") / "wheel.csv", modes))[0], modes, rtol=1e-15)


def test_imported_modes_make_a_wheel_component(tmp_path: Path) -> None:
    component = wheel(read_csv(write_csv(tmp_path / "wheel.csv", MODES))[0])
    assert component.state_size == 2 * len(MODES)


def test_uff_shapes_are_divided_by_the_root_of_the_modal_mass(tmp_path: Path) -> None:
    """A shape scaled by sqrt(m) with modal mass m is the same mode, to the six digits of the format."""
    path = write_uff(tmp_path / "wheel.unv", [units(), *(data_55(i, mass=0.25) for i in range(3))])
    assert_same(read_modes(path, AXES).modes, MODES, rtol=1e-5)


def test_the_header_of_a_universal_file_is_kept(tmp_path: Path) -> None:
    header = {"type": 151, "model_name": "wheel 9", "description": "modal test", "db_app": "a", "program": "b"}
    path = write_uff(tmp_path / "wheel.unv", [header, units(), *(data_55(i) for i in range(3))])
    assert read_modes(path, AXES).origin.startswith("wheel 9, modal test, b, ")


def test_uff_hysteretic_damping_counts_half(tmp_path: Path) -> None:
    """At resonance a loss factor eta damps like zeta = eta/2."""
    sets = [data_55(i, modal_damp_vis=0.0, modal_damp_his=0.02) for i in range(3)]
    np.testing.assert_allclose(read_modes(write_uff(tmp_path / "wheel.uff", [units(), *sets]), AXES).modes.zeta, 0.01)


def test_uff_without_rotations_says_that_spin_is_rigid(tmp_path: Path) -> None:
    sets = [{k: v for k, v in data_55(i, data_ch=2).items() if k not in {"r4", "r5", "r6"}} for i in range(3)]
    read = read_modes(write_uff(tmp_path / "wheel.uff", [units(), *sets]), AXES)
    np.testing.assert_allclose(read.modes.shape[:, :3], MODES.shape[:, :3], rtol=1e-5)
    assert not read.modes.shape[:, 3].any()
    assert "the wheel is rigid in spin" in read.notes[0]


@pytest.mark.parametrize("nodes", [15, 2411])
def test_spin_is_the_rotation_of_nodes_nearby(tmp_path: Path, nodes: int) -> None:
    """Rigid rotation by 2 about -z, ver's axis, and a translation, at nodes nearby: exact but for digits."""
    offsets = np.array([[0, 0, 0], [0.02, 0, 0], [0, 0.03, 0], [0, 0, 0.02], [0.01, 0.02, -0.01], [-0.02, 0.01, 0.01]])
    moved = np.cross([0, 0, -2.0], offsets) + np.array([0.1, 0.2, 0.3])
    sets = [
        units(),
        {"type": nodes, "node_nums": [7, 1, 2, 3, 4, 5], "def_cs": [0] * 6, "disp_cs": [0] * 6, "color": [0] * 6,
         **dict(zip("xyz", (offsets + 1).T.tolist(), strict=True))},
        data_55(0, data_ch=2, node_nums=np.array([7, 1, 2, 3, 4, 5]), r1=moved[:, 0], r2=moved[:, 1], r3=moved[:, 2],
                r4=None, r5=None, r6=None),
    ]  # fmt: skip
    sets[2] = {k: v for k, v in sets[2].items() if v is not None}
    read = read_modes(write_uff(tmp_path / "wheel.uff", sets), AXES)
    np.testing.assert_allclose(read.modes.shape[0], [0.1, -0.2, -0.3, 2.0], rtol=1e-4)
    assert "rotation of the nodes within 50 mm" in read.notes[0]


def test_units_of_data_set_164_are_converted(tmp_path: Path) -> None:
    """In mm and mN the unit of mass is 1 kg; rotations are per mm."""
    changed = [data_55(i) for i in range(3)]
    for data in changed:
        data["r6"] = data["r6"] / 1000
    si = write_uff(tmp_path / "si.uff", [units(), *(data_55(i) for i in range(3))])
    mm = write_uff(tmp_path / "mm.uff", [units(units_code=5, length=1e3, force=1e3), *changed])
    assert_same(read_modes(mm, AXES).modes, read_modes(si, AXES).modes, rtol=1e-5)


def test_data_sets_2414_hold_the_same_modes(tmp_path: Path) -> None:
    """Analysis data at nodes, real normal modes with six values, by pyuff."""
    path = write_uff(tmp_path / "wheel.uff", [units()])
    text = path.read_text()
    for i in range(3):
        text += text_2414(i + 1, data_55(i))
    path.write_text(text)
    assert_same(read_modes(path, AXES).modes, MODES, rtol=1e-5)


def text_2414(number: int, mode: dict[str, Any]) -> str:
    """Return a mode as data set 2414; pyuff writes it for frequency responses only."""
    head = [f"{number:10d}", "modes", f"{1:10d}", *["NONE"] * 5, "".join(f"{x:10d}" for x in (1, 2, 3, 8, 2, 6))]
    head += ["".join(f"{x:10d}" for x in (0, 0, 0, 0, 1, number, 0, 0)), f"{0:10d}{0:10d}"]
    numbers = (0.0, mode["freq"], 0.0, mode["modal_m"], mode["modal_damp_vis"], 0.0)
    head += ["".join(f"{x:13.5e}" for x in numbers), "".join(f"{0.0:13.5e}" for _ in range(6))]
    body = []
    for k, node in enumerate(mode["node_nums"]):
        body += [f"{node:10d}", "".join(f"{float(mode[f'r{j}'][k]):13.5e}" for j in range(1, 7))]
    return "\n".join(["    -1", "  2414", *head, *body, "    -1"]) + "\n"


@pytest.mark.parametrize(
    ("sets", "message"),
    [
        ([data_55(0)], r"has no data set 164 \(units\); give them with the option units"),
        (
            [units(length=1e3), data_55(0)],
            "units code 1 means 1 per metre and 1 per newton, the factors are 1000 and 1",
        ),
        ([units()], "there is no data set 55 or 2414 in it; holds data sets 164"),
        ([units(), data_55(0, modal_damp_vis=-0.01)], "mode 1: zeta = -0.01; must be finite and >= 0"),
        ([units(), data_55(0, modal_m=0.0)], r"data set 2 \(line 7\): modal mass is 0; must be > 0"),
        ([units(), data_55(0, spec_data_type=12)], r"data set 2 \(line 7\): data type is 12; must be 8, displacement"),
        ([units(), data_55(0, node_nums=np.array([3, 8]))], "node 7 is not in it; has 3 to 8"),
        ([units(), data_55(0, r2=np.array([9.0, 0.0]))], "direction lon is missing: no mode moves in it"),
        (
            [units(), data_55(0, analysis_type=5, freq_step_n=1)],
            r"data set 2 \(line 7\): analysis type is 5; must be 2",
        ),
    ],
)
def test_bad_uff_is_refused(tmp_path: Path, sets: list[dict[str, Any]], message: str) -> None:
    """One sentence with the file, the data set, the quantity, what was wanted and what came."""
    with pytest.raises(ValueError, match=f"wheel.uff.*{message}"):
        read_modes(write_uff(tmp_path / "wheel.uff", sets), AXES)


HEADER = ",".join(CSV_COLUMNS)
GOOD = "a,417.1,1e-4,0.1,0.1,0.1,0.1"


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([HEADER.replace(",ver", "")], "line 1: column 'ver' is missing; wanted are label"),
        ([HEADER], "there are no modes in it"),
        ([HEADER, "a,fast,1e-4,0,0.1,0,0"], "line 2: every column but label must be a number"),
        ([HEADER, GOOD, "b,500"], "line 3: every column but label must be a number"),
        ([HEADER, GOOD.replace("1e-4", "-1e-4")], "line 2: mode 1: zeta = -0.0001; must be finite and >= 0"),
        ([HEADER, GOOD.replace("417.1", "nan")], "line 2: mode 1: omega = nan; must be finite"),
        ([HEADER, GOOD.replace("0.1,0.1", "inf,0.1", 1)], "line 2: mode 1: the shape is not finite"),
        ([HEADER, GOOD, "b,100,1e-4,0,0.1,0,0"], "line 3: mode 2 has 100 Hz after 417.1 Hz; must be in rising order"),
        ([HEADER, "a,417.1,1e-4,0.1,0.1,0,0.1"], "direction ver is missing: no mode moves in it"),
    ],
)
def test_bad_csv_is_refused(tmp_path: Path, lines: list[str], message: str) -> None:
    path = tmp_path / "wheel.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    with pytest.raises(ValueError, match=f"wheel.csv.*{message}"):
        read_modes(path)


def test_what_the_project_wrote_itself_is_read_as_it_is(tmp_path: Path) -> None:
    """TOML of a wheel in any order, as class158 is, and of directions that were not measured, which is said."""
    path = tmp_path / "wheel.toml"
    write_modal_data(path, ModalData("a wheel", "made up", MODES.keep([1, 0])))
    read = read_modes(path)
    assert read.modes.labels == ("(3,0) cosine", "(2,0)")
    assert read.notes == ("no mode moves in lon, spin: the wheel is rigid there",)


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"wheel.uff: no such file"):
        read_modes(tmp_path / "wheel.uff", AXES)
    (tmp_path / "wheel.uff").write_text("    -1\n    55\nnonsense\n    -1\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"wheel.uff, data set 1 \(line 1\): is not a readable data set 55"):
        read_modes(tmp_path / "wheel.uff", AXES)
    write_csv(tmp_path / "wheel.csv", MODES)
    with pytest.raises(ValueError, match=r"wheel.csv: only universal files, .frd, .f06 and .op2 can be parts"):
        read_modes([tmp_path / "wheel.csv"] * 2, AXES)


def test_arrays_make_a_wheel() -> None:
    assert_same(wheel_from_modes(MODES.omega / (2 * np.pi), MODES.zeta, MODES.shape), MODES, rtol=1e-15)
    with pytest.raises(ValueError, match="modes: mode 2 has 1 Hz after 2 Hz; must be in rising order"):
        wheel_from_modes([2.0, 1.0], [0.0, 0.0], np.zeros((2, 4)))


def test_directions_of_the_contract_are_the_columns() -> None:
    assert CSV_COLUMNS[3:] == DIRECTIONS
