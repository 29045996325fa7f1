"""The sound of the rail against closed forms: cylinder, decaying line, one wave along the rail."""

from __future__ import annotations

import json

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from synthetic_results import vibrating

from fmus.modal.data import read_modal_data
from fmus.rail import track
from fmus.rail.component import DATA
from fmus.rail.track_data import TRACKS, read_track
from orchestrator.sound.levels import RailSound, sound_of
from orchestrator.sound.radiation import Radiation
from orchestrator.sound.rail import RailRadiation, cylinder_ratio, line_factor, rail_of, rail_power, rail_pressure

DEFAULT = read_track(TRACKS / "default.toml")
HOW = RailRadiation(DEFAULT, Radiation())


def test_a_narrow_cylinder_is_a_line_dipole() -> None:
    """Radiation ratio pi (k a)^3/2 for k a << 1, to terms of (k a)^2 ln(k a)."""
    ka = 2 * np.pi * 20.0 * 0.05 / 343.0
    assert float(cylinder_ratio(20.0, 0.1, 343.0)) == pytest.approx(np.pi * ka**3 / 2, rel=5e-3)


def test_a_wide_cylinder_radiates_like_a_plane() -> None:
    assert float(cylinder_ratio(50_000.0, 0.15, 343.0)) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("decay", [1e-3, 0.1, 1.0, 6.6, 6.7, 50.0])
def test_line_factor_is_its_integral(decay: float) -> None:
    """The closed form against quadrature, on both sides of the switch to the series, 2e-7 apart there."""
    d = 7.5
    wanted = decay * quad(lambda x: 2 * np.exp(-2 * decay * x) * d * d / (d * d + x * x), 0, np.inf, limit=500)[0]
    assert float(line_factor(decay, d)) == pytest.approx(wanted, rel=1e-6)


def test_line_factor_between_point_and_endless_line() -> None:
    """One for a source that dies away at once; pi beta d, 3 dB per doubling of distance, for one that never does."""
    assert float(line_factor(1e3, 7.5)) == pytest.approx(1.0, abs=1e-6)
    assert float(line_factor(1e-5, 7.5)) == pytest.approx(np.pi * 1e-5 * 7.5, rel=2e-3)
    assert float(line_factor(0.0, 7.5)) == 0.0


@given(st.floats(1e-6, 1e4), st.floats(0.5, 200))
def test_a_line_is_quieter_than_a_point_of_the_same_power(decay: float, distance: float) -> None:
    assert 0 < float(line_factor(decay, distance)) <= 1 + 1e-12


def test_rail_power_is_that_of_the_formula() -> None:
    """Rho c pi (w/2) sigma v^2 / beta with the decay of the track, direction by direction."""
    f = np.array([500.0, 1100.0, 2000.0])
    beta = track.decay_rates(2 * np.pi * f, DEFAULT)
    lateral, vertical = rail_power(np.array([[1.0, 2.0, 3.0], [0.0, 1.0, 0.0]]), f, HOW)
    assert lateral[1] == pytest.approx(
        1.2 * 343 * np.pi * 0.172 / 2 * float(cylinder_ratio(1100.0, 0.172, 343.0)) * 2.0 / beta[1, 0]
    )
    assert vertical[1] == pytest.approx(
        1.2 * 343 * np.pi * 0.15 / 2 * float(cylinder_ratio(1100.0, 0.15, 343.0)) / beta[1, 1]
    )
    assert vertical[0] == vertical[2] == 0.0


@pytest.mark.parametrize("frequency_hz", [300.0, 1000.0, 3000.0])
def test_decay_rate_is_what_a_measurement_along_the_rail_gives(frequency_hz: float) -> None:
    """EN 15461: one over the integral of |a(x)/a(0)|^2, here summed over 1 mm steps of 60 m to both sides."""
    omega = np.array([2 * np.pi * frequency_hz])
    x = np.linspace(0, 60, 60_001)
    k, a = track._waves(*track._vertical(omega, DEFAULT))
    response = (a[0] * np.exp(-1j * np.outer(x, k[0]))).sum(axis=1)
    assert response[0] == pytest.approx(track.track_receptance(omega, DEFAULT)[0, 2, 2])
    measured = 1 / (2 * np.trapezoid(np.abs(response / response[0]) ** 2, x))
    assert track.decay_rates(omega, DEFAULT)[0, 1] == pytest.approx(measured, rel=1e-3)


def with_rail(velocity: float, modes: str | None = "rail.toml") -> xr.Dataset:
    """Return results in which the rail moves vertically at 1000 Hz."""
    data = vibrating({"(3,0)": (1102.0, 0.1)})
    time = data["time"].to_numpy()
    values = json.loads(data.attrs["all_parameters"])
    if modes is not None:
        omega = read_modal_data(DATA / modes).modes.omega
        values["rail"] = {f"frequency_{i + 1:03d}": w / (2 * np.pi) for i, w in enumerate(omega)}
    moving = velocity * np.sin(2 * np.pi * 1000.0 * time)
    return data.assign(
        {
            "rail.v_ver": ("time", moving, {"units": "m/s"}),
            "rail.v_lat": ("time", 0 * moving, {"units": "m/s"}),
        }
    ).assign_attrs(all_parameters=json.dumps(values))


def test_level_of_a_rail_that_vibrates_with_one_tone() -> None:
    """Power, decay and distance by hand; wheel and rail add by mean square."""
    sound = sound_of(with_rail(0.01))
    assert isinstance(sound.rail, RailSound)
    f = np.array([1000.0])
    power = rail_power(np.array([[0.0], [0.5 * 0.01**2]]), f, HOW)
    assert sound.rail.power_db == pytest.approx(10 * np.log10(power.sum() / 1e-12), abs=0.01)
    level = 10 * np.log10(rail_pressure(power, f, HOW)[0] / 4e-10)
    assert sound.rail.level_dba == pytest.approx(level, abs=0.02)  # A-weighting is 0 dB at 1 kHz
    assert sound.total_dba == pytest.approx(
        10 * np.log10(10 ** (sound.level_dba / 10) + 10 ** (sound.rail.level_dba / 10)), abs=1e-6
    )


def test_a_rail_at_rest_is_silent() -> None:
    sound = sound_of(with_rail(0.0))
    assert sound.rail == RailSound(-np.inf, -np.inf)
    assert sound.total_dba == pytest.approx(sound.level_dba)


def test_a_rail_of_unknown_track_has_no_level() -> None:
    sound = sound_of(with_rail(0.01, None))
    assert isinstance(sound.rail, str)
    assert "decay rates of its rail are not known" in sound.rail
    assert sound.total_dba is None
    assert rail_of(vibrating({}), 2.0) == "the results have no rail.v_lat"
