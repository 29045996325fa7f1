"""The equivalent modal rails: passive by construction, exact where the target is modal, goals met, paper's claim."""

from __future__ import annotations

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.modal.data import ModalData, read_modal_data, write_modal_data
from fmus.modal.modes import Modes, mobility, receptance
from fmus.rail import shipped as regenerate
from fmus.rail.component import DATA
from fmus.rail.direction_fit import Goal
from fmus.rail.fit import error_frequencies, fit_errors, fit_modes
from fmus.rail.paper_fit import cut_on, paper_modes
from fmus.rail.shipped import modal_rail
from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, Track, read_track

LON, LAT, VER, SPIN = range(4)
OMEGA = 2 * np.pi * np.geomspace(30, 5000, 120)


def _track(name: str = "default") -> Track:
    return read_track(TRACKS / f"{name}.toml")


def _errors(modes: Modes, low: float = 30.0, high: float = 5000.0) -> dict[str, dict[str, float]]:
    omega = 2 * np.pi * np.geomspace(low, high, 200)
    return fit_errors(omega, track_receptance(omega, _track()), modes)


@functools.cache
def _slab() -> tuple[NDArray[np.complex128], Modes]:
    """Return a receptance in one direction and a fit to it."""
    target = np.zeros((OMEGA.size, 4, 4), dtype=complex)
    target[:, LON, LON] = track_receptance(OMEGA, _track("slab"))[:, LON, LON]
    return target, fit_modes(OMEGA, target, 4, Goal(0.5, 3.0))


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_accurate_rail_meets_the_goal(direction: str) -> None:
    """0.5 dB and 3 degrees rms, 30 Hz to 5 kHz, with at most 8 modes: in every direction, spin included."""
    error = _errors(read_modal_data(DATA / "rail.toml").modes)[direction]
    assert error["rms_db"] <= 0.5
    assert error["rms_degrees"] <= 3.0
    assert 1 <= error["modes"] <= 8


def test_errors_are_taken_at_200_frequencies_from_30_hz_to_5_khz() -> None:
    f = error_frequencies()
    assert f.size == 200
    assert (f[0], f[-1]) == (30.0, pytest.approx(5000.0, rel=1e-12))
    np.testing.assert_allclose(np.diff(np.log(f)), np.log(5000 / 30) / 199, rtol=1e-9)


def test_errors_of_a_known_deviation() -> None:
    """A receptance doubled in one direction is 6.02 dB off in it and nowhere out of phase."""
    modes = read_modal_data(DATA / "rail.toml").modes
    target = receptance(OMEGA, modes)
    target[:, VER, VER] /= 2
    errors = fit_errors(OMEGA, target, modes)
    assert errors["ver"]["rms_db"] == pytest.approx(20 * np.log10(2), rel=1e-12)
    assert errors["ver"]["rms_degrees"] == pytest.approx(0.0, abs=1e-9)
    # rounding of the sums, taken in different order
    assert all(e["rms_db"] < 1e-12 for d, e in errors.items() if d != "ver")


def test_a_modal_target_is_found_again() -> None:
    """Two well-separated modes in one direction: the fit is those two modes."""
    truth = Modes(2 * np.pi * np.array([120.0, 900.0]), np.array([0.3, 0.1]), np.zeros((2, 4)))
    truth.shape[:, VER] = 0.05, 0.1
    found = fit_modes(OMEGA, receptance(OMEGA, truth), goal=Goal(1e-4, 1e-3))
    assert found.labels == ("ver 1", "ver 2")
    # 1e-5: the fit stops within 1e-3 degrees
    np.testing.assert_allclose(found.omega, truth.omega, rtol=1e-5)
    np.testing.assert_allclose(found.zeta, truth.zeta, rtol=1e-4)
    np.testing.assert_allclose(found.shape, truth.shape, rtol=1e-4)


@pytest.mark.parametrize("name", ["rail.toml", "rail-paper.toml", "rail-discrete.toml"])
def test_the_shipped_rails_take_energy_at_all_frequencies(name: str) -> None:
    """Positive real far beyond the band: Re Y is a sum of psi psi^T times a positive number."""
    modes = read_modal_data(DATA / name).modes
    assert (modes.zeta > 0).all()
    assert (np.count_nonzero(modes.shape, axis=1) == 1).all()
    Y = mobility(2 * np.pi * np.geomspace(1e-2, 1e6, 2000), modes)
    assert (np.diagonal(Y, axis1=1, axis2=2).real > 0).all()


def test_even_a_fit_to_nonsense_is_passive() -> None:
    """Data with random phase, mostly active, still give positive masses and damping."""
    rng = np.random.default_rng(7)
    target = np.zeros((OMEGA.size, 4, 4), dtype=complex)
    target[:, LON, LON] = 1e-8 * np.exp(2j * np.pi * rng.random(OMEGA.size))
    modes = fit_modes(OMEGA, target, most_modes=3)
    assert (modes.zeta > 0).all()
    Y = mobility(2 * np.pi * np.geomspace(1e-2, 1e6, 2000), modes)
    assert (Y[:, LON, LON].real >= 0).all()


def test_a_fit_needs_few_modes_and_leaves_empty_directions_empty() -> None:
    target, modes = _slab()
    errors = fit_errors(OMEGA, target, modes)
    assert errors["lon"]["modes"] <= 4
    assert errors["lon"]["rms_db"] <= 0.5
    assert errors["lat"]["modes"] == 0
    assert not modes.shape[:, [LAT, VER, SPIN]].any()


def test_a_fit_is_deterministic() -> None:
    target, modes = _slab()
    again = fit_modes(OMEGA, target, 4, Goal(0.5, 3.0))
    np.testing.assert_array_equal(again.omega, modes.omega)
    np.testing.assert_array_equal(again.shape, modes.shape)


def test_fitted_modes_are_no_resonances_outside_the_data() -> None:
    """A lightly damped mode where no data are would ring in a simulation."""
    modes = read_modal_data(DATA / "rail.toml").modes
    outside = (modes.omega < 2 * np.pi * 20) | (modes.omega > 2 * np.pi * 7000)
    # the bound of 0.5 is a penalty, not a wall
    assert (modes.zeta[outside] > 0.4).all()


@pytest.mark.slow
def test_the_shipped_rails_are_what_their_methods_make() -> None:
    assert regenerate.differences() == []


def test_a_shipped_rail_that_is_not_what_its_method_makes_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Vertical masses 10 % too small are 20 lg(1 / 0.9) = 0.92 dB: named with file and direction."""
    data = modal_rail(_track(), "paper")
    monkeypatch.setattr(regenerate, "shipped", lambda: {"rail-paper.toml": data})
    write_modal_data(tmp_path / "rail-paper.toml", data)
    assert regenerate.differences(tmp_path) == []
    modes = data.modes
    lighter = Modes(modes.omega, modes.zeta, modes.shape * np.array([1.0, 1.0, 0.9**-0.5, 1.0]), modes.labels)
    write_modal_data(tmp_path / "rail-paper.toml", ModalData("another", data.source, lighter))
    title, vertical = regenerate.differences(tmp_path)
    assert title == "rail-paper.toml: title or source differs"
    assert vertical.startswith("rail-paper.toml: ver differs by 0.92 dB and 0.0 degrees rms; must be at most 0.05")


def test_the_cut_on_on_one_layer_is_that_of_a_mass_on_a_spring() -> None:
    """omega^2 = k / (m d), and the loss factor is the pad's."""
    track = _track("slab")
    found = cut_on(track, "ver")
    expected = np.sqrt(track.ver.pad_stiffness / track.spacing / track.section.mass_per_length)
    np.testing.assert_allclose(found.omega, [expected], rtol=1e-12)
    np.testing.assert_allclose(found.loss_factor, [track.ver.pad_loss_factor], rtol=1e-12)


def test_the_vertical_cut_ons_are_the_peaks_of_figure_3() -> None:
    """82 and 700 Hz without losses (printed: peaks at 80 and 700 Hz); zeta = eta / 2 of ballast and of pad."""
    found = cut_on(_track(), "ver")
    # two or three digits are known of each
    np.testing.assert_allclose(found.omega / (2 * np.pi), [82, 700], rtol=0.01)
    np.testing.assert_allclose(found.loss_factor, [1.0, 0.25], rtol=0.02)


def test_lateral_has_more_cut_ons() -> None:
    """Torsion adds one (the paper: "in the lateral direction more modes are included")."""
    assert cut_on(_track(), "lat").omega.size == 3
    assert cut_on(replace(_track(), lateral_model="bending"), "lat").omega.size == 2


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_extra_mode_mends_high_frequencies(direction: str) -> None:
    """The paper's claim: without the extra mode good to 1 kHz at most, with it better at higher frequencies."""
    without, with_extra = paper_modes(_track(), extra=False), paper_modes(_track())
    above = {"low": 1000.0, "high": 5000.0}
    assert _errors(without)[direction]["modes"] + 1 == _errors(with_extra)[direction]["modes"]
    assert _errors(with_extra, **above)[direction]["rms_db"] < 0.3 * _errors(without, **above)[direction]["rms_db"]
    assert _errors(without, high=1000.0)[direction]["rms_db"] < _errors(without, **above)[direction]["rms_db"]


@pytest.mark.parametrize("direction", DIRECTIONS)
def test_the_accurate_rail_is_better_than_the_papers(direction: str) -> None:
    accurate = _errors(read_modal_data(DATA / "rail.toml").modes)[direction]
    paper = _errors(read_modal_data(DATA / "rail-paper.toml").modes)[direction]
    assert accurate["rms_db"] < 0.5 * paper["rms_db"]
    assert accurate["rms_degrees"] < 0.5 * paper["rms_degrees"]


def test_faults_of_the_data_are_named() -> None:
    target = track_receptance(OMEGA, _track())

    def spoiled(i: int, value: float) -> NDArray[np.float64]:
        omega = OMEGA.copy()
        omega[i] = value
        return omega

    broken = target.copy()
    broken[3, LAT, LAT] = np.nan
    cases = [
        (OMEGA[:5], target[:5], r"fit: 5 frequencies; must be at least 20"),
        (spoiled(2, -6.283185307), target, r"fit: frequency 3 is -1 Hz; must be finite and > 0"),
        (spoiled(2, np.nan), target, r"fit: frequency 3 is nan Hz; must be finite and > 0"),
        (spoiled(1, OMEGA[0]), target, r"fit: 30 Hz comes after 30 Hz; frequencies must increase"),
        (OMEGA, broken, r"fit: lat receptance at 34.1\d* Hz is \(?nan.*; must be finite and not 0"),
        (OMEGA, target[:, :3], r"fit: receptance has the shape \(120, 3, 4\); must be \(120, 4, 4\)"),
    ]
    for omega, values, message in cases:
        with pytest.raises(ValueError, match=message):
            fit_modes(omega, values)
    with pytest.raises(ValueError, match="most_modes = 0; must be at least 1"):
        fit_modes(OMEGA, target, most_modes=0)


def test_an_unknown_method_is_refused() -> None:
    with pytest.raises(ValueError, match="method is 'best'; must be one of accurate, paper"):
        modal_rail(_track(), "best")
    with pytest.raises(ValueError, match="most_modes goes with method 'accurate'"):
        modal_rail(_track(), "paper", most_modes=3)
