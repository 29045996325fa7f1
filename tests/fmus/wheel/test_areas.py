"""Estimated radiating areas against those of the finite elements, and labels taken over from a known wheel."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from fmus.modal.data import ModalData, write_modal_data
from fmus.modal.modes import Modes
from fmus.wheel.areas import UNCERTAINTY_DB, estimated_wheelset, given_wheelset, like, taken_over
from fmus.wheel.class158 import class158
from fmus.wheel.imported import read_modes
from fmus.wheel.wheelset import DATA, read_wheelset


@pytest.mark.parametrize("name", ["generic840", "straight840"])
def test_estimates_are_as_good_as_they_say(name: str) -> None:
    """Against the surface integrals of both webs below 5.2 kHz: all (n,0), and 85 of 100 others, as is said."""
    true = read_wheelset(DATA / f"{name}.toml")
    found = estimated_wheelset(true.modes, "estimate")
    other = []
    for i, label in enumerate(true.modes.labels):
        if label.startswith("rigid") or true.modes.omega[i] > 2 * np.pi * 5200 or not true.area_axial[i]:
            continue
        error = 10 * np.log10(found.area_axial[i] / true.area_axial[i])
        if re.match(r"\(\d,0\)", label):
            assert abs(error) < UNCERTAINTY_DB["(n,0)"], label
            assert found.nodal_diameters[i] == true.nodal_diameters[i]
        else:
            other.append(abs(error))
    assert np.percentile(other, 85) < UNCERTAINTY_DB["others"]


def test_the_area_of_a_doublet_is_that_of_both_members_and_grows_with_the_wheel() -> None:
    modes = Modes(
        np.array([2000.0, 2000.0]), np.full(2, 1e-4), np.array([[0, 0.1, 0, 0], [0, 0, 0, 0.5]]),
        ("(2,0) cosine", "(2,0) sine"),
    )  # fmt: skip
    small, large = estimated_wheelset(modes, "a"), estimated_wheelset(modes, "b", radius=0.84)
    assert small.area_axial[0] == small.area_axial[1] == pytest.approx(0.225 * 0.01, rel=1e-12)
    np.testing.assert_allclose(large.area_axial, 4 * small.area_axial, rtol=1e-12)


def test_labels_come_from_a_known_wheel() -> None:
    """Class158 with every frequency 1 % higher and no labels: those of the modes that squeal come back."""
    known = class158().modes
    bare = Modes(1.01 * known.omega, known.zeta, known.shape, ("?",) * len(known))
    found = like(bare, known)
    squeal = [i for i, label in enumerate(known.labels) if re.match(r"\([2-7],0\)", label)]
    assert [found.labels[i] for i in squeal] == [known.labels[i] for i in squeal]
    assert like(bare, known, within=1e-6).labels == bare.labels


COLUMNS = "label,frequency_hz,damping_ratio,lon,lat,ver,spin,area_axial,area_radial"
ROWS = ['"(2,0) cosine",500,1e-4,0.02,0.1,0.01,0.3,2e-3,3e-4', '"(3,0) cosine",1500,1e-4,-0.03,0.2,0.05,-0.1,4e-3,0']


def table(path: Path, header: str, rows: list[str]) -> Path:
    path.write_text("\n".join([header, *rows]) + "\n")
    return path


def test_areas_are_columns_of_a_table_and_of_modal_data(tmp_path: Path) -> None:
    """CSV in, TOML out and in again: the same areas; a file without them has none."""
    read = read_modes(table(tmp_path / "w.csv", COLUMNS, ROWS))
    np.testing.assert_array_equal(read.areas, [[2e-3, 3e-4], [4e-3, 0.0]])
    write_modal_data(tmp_path / "w.toml", ModalData("a wheel", "made up", read.modes, read.areas))
    again = read_modes(tmp_path / "w.toml")
    np.testing.assert_array_equal(again.areas, read.areas)
    wheelset = given_wheelset(again.modes, np.asarray(again.areas), "w")
    assert wheelset.area_axial.tolist() == [2e-3, 4e-3]
    assert wheelset.nodal_diameters.tolist() == [2, 3]
    bare = [row.rsplit(",", 2)[0] for row in ROWS]
    assert read_modes(table(tmp_path / "bare.csv", COLUMNS.rsplit(",", 2)[0], bare)).areas is None


@pytest.mark.parametrize(
    ("header", "rows", "message"),
    [
        (COLUMNS, [ROWS[0].replace("2e-3", "-2e-3")], r"w.csv, line 2: areas are \[-0.002, 0.0003\]; must be >= 0"),
        (COLUMNS, [ROWS[0].replace("2e-3", "large")], r"w.csv, line 2: every column but label must be a number; got"),
        (
            COLUMNS.rsplit(",", 1)[0],
            ROWS,
            r"w.csv, line 1: has area_axial alone; must be area_axial and area",
        ),
    ],
)
def test_bad_areas_are_refused(header: str, rows: list[str], message: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=message):
        read_modes(table(tmp_path / "w.csv", header, rows))


def test_areas_of_some_modes_alone_are_refused(tmp_path: Path) -> None:
    modes = read_modes(table(tmp_path / "w.csv", COLUMNS, ROWS))
    write_modal_data(tmp_path / "w.toml", ModalData("a wheel", "made up", modes.modes, modes.areas))
    text = (tmp_path / "w.toml").read_text()
    for there, message in (
        ("area_axial = 0.004\n", r"w.toml, mode 2 \(\(3,0\) cosine\): has one of area_axial and area_radial"),
        (
            "area_axial = 0.004\narea_radial = 0.0\n",
            "w.toml, mode 2: has no area_axial and area_radial; others",
        ),
    ):
        (tmp_path / "w.toml").write_text(text.replace(there, ""))
        with pytest.raises(ValueError, match=message):
            read_modes(tmp_path / "w.toml")


def test_areas_of_a_known_wheel_are_taken_over() -> None:
    """Class158 1 % higher: the areas of the modes that squeal come back; a mode of its own is estimated."""
    known = class158()
    areas = np.column_stack([known.area_axial, known.area_radial])
    other = Modes(np.array([1e5]), np.array([1e-4]), np.array([[0, 0.1, 0, 0]]), ("(2,0) cosine",))
    omega = np.append(1.01 * known.modes.omega, other.omega)
    shape = np.concatenate([known.modes.shape, other.shape])
    modes = Modes(omega, np.append(known.modes.zeta, other.zeta), shape, (*known.modes.labels, *other.labels))
    found, count = taken_over(modes, known.modes, areas)
    squeal = [i for i, label in enumerate(known.modes.labels) if re.match(r"\([2-7],0\)", label)]
    np.testing.assert_array_equal(found[squeal], areas[squeal])
    assert found[-1, 0] == pytest.approx(0.225 * 0.01, rel=1e-12)
    assert count < len(modes)
