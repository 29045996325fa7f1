"""The wheel's data: axes, families, imposed frequencies, and what is refused."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from fmus.wheel.wheelset import DATA, contact_shape, read_wheelset

ROW = {"n": 3, "u_r": 0.2, "u_theta": 0.3, "u_z": 0.5, "du_theta_dz": 0.7}


def test_contact_axes_are_those_of_the_contract() -> None:
    """The contact is the lowest point: upwards is -u_r; the gauge side is -u_z."""
    np.testing.assert_allclose(contact_shape(ROW, "cosine", 0.42), [0, -0.5, -0.2, 0])
    assert contact_shape(ROW, "sine", 0.42)[:3] == [0.3, 0.0, 0.0]


def test_a_wheelset_that_yaws_rigidly_spins_by_its_yaw() -> None:
    """Rotation by a about a transverse axis at mid-axle: u_r = a z, u_theta = -a z, u_z = -a r at the contact."""
    a, R, z = 0.045, 0.42, 0.75
    row = {"n": 1, "u_r": a * z, "u_theta": -a * z, "u_z": -a * R, "du_theta_dz": -a}
    lon, lat, ver, spin = contact_shape(row, "sine", R)
    assert (lon, lat, ver) == (-a * z, 0.0, 0.0)
    assert spin == pytest.approx(-a, rel=1e-12)


def test_doublets_have_both_families() -> None:
    """Modes with n >= 1 count twice with equal frequency and damping; those with n = 0 once."""
    wheelset = read_wheelset(DATA / "generic840.toml")
    modes = wheelset.modes
    for label in {name.rsplit(" ", 1)[0] for name in modes.labels}:
        pair = [i for i, name in enumerate(modes.labels) if name.rsplit(" ", 1)[0] == label]
        expected = 1 if wheelset.nodal_diameters[pair[0]] == 0 else 2
        assert len(pair) == expected, label
        assert np.ptp(modes.omega[pair]) == 0
        assert np.ptp(modes.zeta[pair]) == 0


def test_frequencies_of_table_4_are_imposed() -> None:
    modes = read_wheelset(DATA / "generic840.toml").modes
    wanted = {
        "axle": 82.37, "(1,0)": 149.42, "(0,0)": 272.54, "(0,x)": 402.03, "(2,0)": 418.34, "(3,0)": 1102.0,
        "(2,r)": 1959.4, "(4,0)": 1976.2, "(5,0)": 2950.4, "(4,1)": 3915.1, "(6,0)": 3977.4,
    }  # fmt: skip
    found = {name.rsplit(" ", 1)[0]: omega / (2 * np.pi) for name, omega in zip(modes.labels, modes.omega, strict=True)}
    for label, frequency in wanted.items():
        assert found[label] == pytest.approx(frequency, rel=1e-12)


def test_rigid_body_and_radial_modes_are_kept() -> None:
    modes = read_wheelset(DATA / "generic840.toml").modes
    rigid = [i for i, name in enumerate(modes.labels) if name.startswith("rigid")]
    assert len(rigid) >= 6
    np.testing.assert_allclose(modes.omega[rigid], 2 * np.pi * 2.0)
    radial = modes.labels.index("(2,r) cosine")
    assert abs(modes.shape[radial, 2]) > abs(modes.shape[radial, 1])


def copy(folder: Path) -> Path:
    for name in ("generic840.toml", "generic840.csv"):
        shutil.copy(DATA / name, folder / name)
    return folder / "generic840.toml"


def test_missing_column_is_named(tmp_path: Path) -> None:
    file = copy(tmp_path)
    table = tmp_path / "generic840.csv"
    table.write_text(table.read_text().replace("u_theta", "other", 1))
    with pytest.raises(ValueError, match="column 'u_theta' is missing"):
        read_wheelset(file)


def test_bad_number_is_found_by_its_line(tmp_path: Path) -> None:
    file = copy(tmp_path)
    table = tmp_path / "generic840.csv"
    lines = table.read_text().splitlines()
    lines[4] = lines[4].replace(",", ",x", 3)
    table.write_text("\n".join(lines))
    with pytest.raises(ValueError, match="line 5"):
        read_wheelset(file)


def test_frequency_for_a_mode_that_is_not_there_is_refused(tmp_path: Path) -> None:
    file = copy(tmp_path)
    file.write_text(file.read_text().replace("order = 3", "order = 99"))
    with pytest.raises(ValueError, match="no mode n = 4, symmetric, number 99"):
        read_wheelset(file)
