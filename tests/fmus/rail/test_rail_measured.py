"""A rail from measured point functions: noise told from signal, active data refused, passive modes out."""

from __future__ import annotations

import numpy as np
import pytest
from frf_files import F as LINES
from frf_files import noisy, true_receptance
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.measured.noise import averaged, good_band, relative_noise
from fmus.modal.modes import Modes, mobility, receptance
from fmus.rail.fit import fit_errors
from fmus.rail.measured import rail_from_frf

F = np.geomspace(25.0, 4000.0, 60)
TRUTH = Modes(
    omega=2 * np.pi * np.array([150.0, 200.0, 80.0, 600.0, 300.0]),
    zeta=np.array([0.4, 0.3, 0.5, 0.1, 0.6]),
    shape=np.array([[0.04, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 0.05, 0], [0, 0, 0.09, 0], [0, 0, 0, 0.4]]),
)
POWER = {"receptance": 0, "mobility": 1, "accelerance": 2}


def _point(quantity: str, frequency_hz: NDArray[np.float64] = F) -> dict[str, NDArray[np.complex128]]:
    alpha = receptance(2 * np.pi * frequency_hz, TRUTH)
    factor = (2j * np.pi * frequency_hz) ** POWER[quantity]
    return {d: alpha[:, j, j] * factor for j, d in enumerate(DIRECTIONS)}


@pytest.mark.parametrize("quantity", list(POWER))
def test_a_modal_measurement_is_found_again(quantity: str) -> None:
    """Data without noise: the fit stops at half the promised 0.5 dB and 3 degrees, in four directions."""
    rail = rail_from_frf(F, _point(quantity), quantity=quantity)
    assert list(rail.quality) == list(DIRECTIONS)
    for error in rail.quality.values():
        assert error["rms_db"] <= 0.25
        assert error["rms_degrees"] <= 1.5
        assert error["active_degrees"] == 0.0
        assert (error["from_hz"], error["to_hz"]) == (F[0], F[-1])
    assert (rail.modes.zeta > 0).all()


def test_noisy_data_give_a_passive_rail_with_its_quality() -> None:
    """5 % of noise: what is left is the noise, 0.05 / sqrt(2) in each part, 0.3 dB and 2 degrees.

    Against the truth less is left: modes cannot follow noise.
    """
    rng = np.random.default_rng(3)
    noise = 1 + 0.05 / np.sqrt(2) * (rng.standard_normal(F.size) + 1j * rng.standard_normal(F.size))
    true = _point("receptance")["ver"]
    rail = rail_from_frf(F, {"ver": true * noise}, most_modes=2)
    assert list(rail.quality) == ["ver"]
    # 1.3: the noise of 60 samples scatters
    assert rail.quality["ver"]["rms_db"] < 1.3 * 0.31
    assert rail.quality["ver"]["rms_degrees"] < 1.3 * 2.03
    found = receptance(2 * np.pi * F, rail.modes)[:, 2, 2]
    assert np.sqrt((20 * np.log10(np.abs(found / true)) ** 2).mean()) < 0.31
    Y = mobility(2 * np.pi * np.geomspace(0.1, 1e5, 500), rail.modes)
    assert (Y[:, 2, 2].real > 0).all()
    assert not Y[:, 1, 1].any()


def test_the_noise_of_an_impact_test_is_seen() -> None:
    """A floor of 0.3 % of the largest accelerance: estimate and truth within a fifth, octave by octave, in good data.

    The band begins where the estimate passes 20 %. A fifth: 25 lines tell a standard deviation within a tenth, and an
    octave has one to twenty such windows.
    """
    f, accelerance = noisy()
    estimate = relative_noise(accelerance)
    actual = 3e-3 * np.abs(accelerance).max() / np.abs(2 * np.pi * f) ** 2 / np.abs(true_receptance(f))
    for low in (200.0, 400.0, 800.0, 1600.0, 3200.0):
        octave = (f >= low) & (f < 2 * low)
        assert np.median(estimate[octave]) == pytest.approx(np.median(actual[octave]), rel=0.2)
    inside = good_band(f, estimate)
    assert 40 < f[inside][0] < 120
    assert f[inside][-1] == 6400.0
    assert actual[inside].max() < 0.4


def test_means_have_less_noise() -> None:
    """N equal lines in a band: the noise falls by the root of N, and the mean of a constant is the constant."""
    f = np.linspace(1000.0, 1010.0, 16)
    mean = averaged(f, np.full(16, 2.0 + 1j), np.full(16, 0.1))
    assert mean.values == pytest.approx([2 + 1j], rel=1e-12)
    assert mean.noise == pytest.approx([0.1 / 4], rel=1e-12)
    weighed = averaged(f, np.arange(16).astype(complex), np.full(16, 0.1), np.where(np.arange(16) < 8, 0.0, 0.999))
    assert weighed.values.real[0] == pytest.approx(11.5, rel=1e-3)  # only the coherent half counts


@pytest.mark.slow
@pytest.mark.parametrize("clean", [True, False])
def test_a_measured_track_is_the_true_track(clean: bool) -> None:
    """Against the true track, not the data: within 0.5 dB rms in the band that was used, with the noise, too."""
    if clean:
        rail = rail_from_frf(LINES, {"ver": true_receptance(LINES)})
    else:
        f, accelerance = noisy()
        rail = rail_from_frf(f, {"ver": accelerance}, quantity="accelerance")
    quality = rail.quality["ver"]
    omega = 2 * np.pi * np.geomspace(quality["from_hz"], quality["to_hz"], 200)
    target = np.zeros((200, 4, 4), dtype=complex)
    target[:, 2, 2] = true_receptance(omega / (2 * np.pi))
    with np.errstate(invalid="ignore", divide="ignore"):
        assert fit_errors(omega, target, rail.modes)["ver"]["rms_db"] < 0.5
    Y = mobility(2 * np.pi * np.geomspace(0.1, 1e5, 500), rail.modes)
    assert (Y[:, 2, 2].real > 0).all()


def test_active_data_are_refused_at_their_frequency() -> None:
    """A phase error that grows with frequency, as a time delay makes it, turns the mobility active."""
    late = {"ver": _point("receptance")["ver"] * np.exp(-1j * np.radians(40.0) * F / F[-1])}
    with pytest.raises(
        ValueError, match=r"ver mobility at \d+(\.\d+)? Hz has a phase of -\d+\.\d degrees; must be within"
    ):
        rail_from_frf(F, late)


def test_a_sign_error_is_refused() -> None:
    """A force taken with the wrong sign."""
    with pytest.raises(ValueError, match=r"lat mobility at .* must be within \+-90"):
        rail_from_frf(F, {"lat": -_point("receptance")["lat"]})


def test_noise_alone_is_refused() -> None:
    random = np.random.default_rng(1)
    noise = random.standard_normal(LINES.size) + 1j * random.standard_normal(LINES.size)
    with pytest.raises(ValueError, match=r"ver has \d+ frequencies with noise below 20% of the value, of 797; must be"):
        rail_from_frf(LINES, {"ver": noise})


def test_faults_of_the_data_are_named() -> None:
    good = _point("receptance")["ver"]
    broken = good.copy()
    broken[4] = np.nan
    swapped = F.copy()
    swapped[[3, 4]] = swapped[[4, 3]]
    cases = [
        (F, {}, "no direction; must be at least one of lon, lat, ver, spin"),
        (F, {"z": good}, "direction 'z'; must be one of lon, lat, ver, spin"),
        (-F, {"ver": good}, "frequency 1 is -25 Hz; must be finite and > 0"),
        (swapped, {"ver": good}, r"Hz comes after .* Hz; frequencies must increase"),
        (F, {"ver": broken}, r"ver at .* Hz is \(?nan.*; must be finite and not 0"),
        (F, {"ver": good[:-1]}, "59 values in ver for 60 frequencies"),
    ]
    for f, data, message in cases:
        with pytest.raises(ValueError, match=message):
            rail_from_frf(f, data)
    with pytest.raises(ValueError, match="has 10 frequencies"):
        rail_from_frf(F[:10], {"ver": good[:10]})
    with pytest.raises(ValueError, match="quantity is 'admittance'; must be one of receptance, mobility, accelerance"):
        rail_from_frf(F, {"ver": good}, quantity="admittance")
