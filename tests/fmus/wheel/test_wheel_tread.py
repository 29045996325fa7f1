"""Wheels read beside their nominal contact point: slopes along the tread, and what is not known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.interface import DIRECTIONS
from fmus.wheel.wheelset import DATA, read_wheelset

LAT, VER = DIRECTIONS.index("lat"), DIRECTIONS.index("ver")

RATIOS = {
    "(1,0)": -0.0028, "(0,0)": -0.0018, "(2,0)": -0.0052, "(3,0)": -0.0067, "(4,0)": -0.0080, "(5,0)": -0.0089,
    "(6,0)": -0.0098,
}  # fmt: skip
"""Change of u_r/u_z per mm to the field side, of another reading of the same wheel on a coarser mesh."""

ZEROS = {"(2,0)": 1.9, "(3,0)": 4.9, "(4,0)": 7.1, "(5,0)": 9.2, "(6,0)": 11.5}
"""Where u_r/u_z vanishes [mm]."""


def ratio(label: str, positions: np.ndarray) -> np.ndarray:
    wheel = read_wheelset(DATA / "generic840.toml")
    i = wheel.modes.labels.index(f"{label} cosine")
    shapes = np.array([wheel.at(float(s)).shape[i] for s in positions])
    return np.asarray(shapes[:, VER] / shapes[:, LAT])


@pytest.mark.parametrize("label", RATIOS)
def test_radial_over_axial_motion_is_linear_along_the_tread(label: str) -> None:
    """Slopes within 3 %; what is not straight is a fortieth of the change over 30 mm."""
    s = np.linspace(-0.015, 0.015, 31)
    found = ratio(label, s)
    slope, offset = np.polyfit(s, found, 1)
    assert slope / 1e3 == pytest.approx(RATIOS[label], rel=0.03)
    assert np.abs(found - (slope * s + offset)).max() < abs(slope) * 0.03 / 40


@pytest.mark.parametrize("label", ZEROS)
def test_radial_motion_vanishes_where_it_did(label: str) -> None:
    """To 0.12 mm: the digit that was printed, and that amplitudes are parabolas here."""
    s = np.linspace(0, 0.02, 2001)
    assert 1e3 * np.interp(0, -ratio(label, s), s) == pytest.approx(ZEROS[label], abs=0.12)


def test_the_nominal_point_is_the_table() -> None:
    wheel = read_wheelset(DATA / "generic840.toml")
    assert wheel.at(0.0) is wheel.modes
    assert wheel.at(1e-12).shape == pytest.approx(wheel.modes.shape, abs=1e-9)


def test_rigid_rotation_moves_every_point_as_a_rigid_body() -> None:
    """Yaw about a longitudinal axis: u_r = a z, u_z = -a r; along the 1:20 tread du_r/ds = a, du_z/ds = a/20."""
    wheel = read_wheelset(DATA / "generic840.toml")
    assert wheel.slope is not None
    i = wheel.modes.labels.index("rigid n=1 antisymmetric cosine")
    a = -wheel.modes.shape[i, VER] / 0.75
    assert wheel.slope[i, VER] == pytest.approx(-a, rel=1e-4)
    assert wheel.slope[i, LAT] == pytest.approx(-a / 20, rel=1e-3)


def test_a_wheel_without_slopes_says_so(tmp_path: Path) -> None:
    """A table from elsewhere is known at its nominal point only."""
    text = (DATA / "straight840.csv").read_text(encoding="utf-8").replace("du_r_ds", "other", 1)
    (tmp_path / "straight840.csv").write_text(text, encoding="utf-8")
    (tmp_path / "straight840.toml").write_text(
        (DATA / "straight840.toml").read_text(encoding="utf-8"), encoding="utf-8"
    )
    wheel = read_wheelset(tmp_path / "straight840.toml")
    assert len(wheel.at(0.0)) == len(wheel.modes)
    with pytest.raises(ValueError, match=r"5\.0 mm from the nominal point, and the table of modes has no columns"):
        wheel.at(5e-3)
