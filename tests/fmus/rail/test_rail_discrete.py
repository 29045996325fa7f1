"""The rail on discrete sleepers: limits, order of convergence, pinned-pinned resonance, an independent program."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from fmus.modal.data import read_modal_data
from fmus.modal.modes import receptance
from fmus.rail import discrete
from fmus.rail.component import DATA, shipped_rail
from fmus.rail.discrete import DiscreteTrack, discrete_receptance
from fmus.rail.fit import error_frequencies, fit_errors
from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, read_track

LON, LAT, VER, SPIN = range(4)
TRACK = read_track(TRACKS / "default.toml")
OMEGA = 2 * np.pi * np.array([30.0, 79.0, 215.0, 700.0, 1070.0, 2000.0, 5000.0])


def _error(model: DiscreteTrack, omega: NDArray[np.float64] = OMEGA) -> NDArray[np.float64]:
    """Return the largest relative deviation from the analytical track in each direction."""
    ratio = discrete_receptance(omega, model) / np.where(np.eye(4), track_receptance(omega, model.track), 1.0)
    return np.asarray(np.abs(np.einsum("mii->mi", ratio) - 1).max(axis=0))


def test_a_smeared_support_gives_the_analytical_track() -> None:
    """All directions and frequencies; what is left are the ends (longitudinal) and the elements (lateral, 5 kHz)."""
    lon, lat, ver, spin = _error(DiscreteTrack(TRACK, smeared=True))
    assert lon < 0.02  # waves of 17 m at 300 Hz, and 8.4 m of absorbing end
    assert lat < 0.005  # torsion at 5 kHz on elements of 0.1 m; measured 0.4 %
    assert ver < 1e-3
    assert spin < 1e-3


def test_longer_rails_come_nearer_to_the_infinite_one() -> None:
    """What the ends send back falls with the length of rail between."""
    omega = 2 * np.pi * np.array([300.0])
    errors = [_error(DiscreteTrack(TRACK, spans=n, end_spans=n // 2, smeared=True), omega)[LON] for n in (12, 24, 48)]
    assert errors[2] < 0.3 * errors[1] < 0.3 * errors[0]


def test_elements_converge(monkeypatch: pytest.MonkeyPatch) -> None:
    """Cubic elements: halving them reduces the error of a point receptance by 2^4 at least (theory: 2^6 for energy)."""
    omega = 2 * np.pi * np.array([3000.0])
    errors = []
    for elements in (2, 4):
        monkeypatch.setattr(discrete, "ELEMENTS_PER_SPAN", elements)
        errors.append(_error(DiscreteTrack(TRACK, smeared=True), omega)[VER])
    assert errors[1] < errors[0] / 16


def test_the_pinned_pinned_resonance_is_there() -> None:
    """Near 1 kHz half a wave fits between two sleepers: a peak at mid-span, a dip above a sleeper."""
    f = np.arange(900.0, 1251.0, 10.0)
    middle, above = (
        np.abs(discrete_receptance(2 * np.pi * f, DiscreteTrack(TRACK, position))[:, VER, VER])
        for position in (0.5, 0.0)
    )
    continuous = np.abs(track_receptance(2 * np.pi * f, TRACK)[:, VER, VER])
    peak, dip = int(np.argmax(middle)), int(np.argmin(above))
    assert 1000 < f[peak] < 1150
    assert 1050 < f[dip] < 1200
    assert middle[peak] > 2 * continuous[peak]
    assert above[dip] < 0.5 * continuous[dip]


def test_the_pinned_pinned_frequency_is_that_of_a_beam_on_pins() -> None:
    """With rigid pads the mid-span peak is the first mode of a Timoshenko beam of one span between pins."""
    hard = replace(TRACK.ver, pad_stiffness=1e13, ballast_stiffness=1e13)
    track = replace(TRACK, ver=hard, section=replace(TRACK.section, loss_factor=2e-3))
    rail, k = track.section, np.pi / track.spacing
    S = rail.shear_coefficient_ver * rail.shear_modulus * rail.area
    B, m = rail.bending_stiffness_ver, rail.mass_per_length
    inertia = rail.density * B / rail.young_modulus
    # roots of (S k^2 - m w^2)(B k^2 + S - J w^2) = S^2 k^2 in w^2
    roots = np.roots([m * inertia, -(S * k**2 * inertia + m * (B * k**2 + S)), S * B * k**4])
    pinned = np.sqrt(roots.real.min()) / (2 * np.pi)
    f = np.linspace(0.97, 1.03, 61) * pinned
    alpha = np.abs(discrete_receptance(2 * np.pi * f, DiscreteTrack(track, 0.5))[:, VER, VER])
    # 0.2 %: two steps of the frequencies
    assert f[np.argmax(alpha)] == pytest.approx(pinned, rel=2e-3)


def test_the_receptance_is_reciprocal_passive_and_symmetric_along_the_track() -> None:
    """At a quarter of the span lateral and spin couple; the other quarter is its mirror image."""
    here = discrete_receptance(OMEGA, DiscreteTrack(TRACK, 0.25))
    there = discrete_receptance(OMEGA, DiscreteTrack(TRACK, 0.75))
    scale = np.abs(np.einsum("mii->mi", here))
    scale = np.sqrt(scale[:, :, None] * scale[:, None, :])
    # rounding of a banded solution
    np.testing.assert_allclose(here / scale, here.transpose(0, 2, 1) / scale, atol=1e-9)
    mirrored = here * np.outer([-1, 1, 1, -1], [-1, 1, 1, -1])
    # the contact at 0.75 is half a span farther from the left end than the one at 0.25 from the right: ends differ
    np.testing.assert_allclose(there / scale, mirrored / scale, atol=0.02)
    assert np.abs(here[:, LAT, SPIN] / scale[:, LAT, SPIN]).max() > 0.1
    Y = 1j * OMEGA[:, None, None] * here / scale
    assert (np.linalg.eigvalsh((Y + Y.conj().transpose(0, 2, 1)) / 2) > 0).all()


def test_an_independent_implementation_agrees() -> None:
    """Rolland's Timoshenko beam on discrete sleepers (Green's functions), above a sleeper and at mid-span."""
    reason = "rolland needs Python >= 3.12"
    parts = pytest.importorskip("rolland.components", reason=reason)
    beams = pytest.importorskip("rolland.methods.semi_analytical", reason=reason)
    tracks = pytest.importorskip("rolland.track", reason=reason)
    UIC60 = pytest.importorskip("rolland.database.rail.db_rail", reason=reason).UIC60
    assert TRACK.ver.ballast_stiffness is not None
    pad = parts.DiscrPad(
        sp_z=TRACK.ver.pad_stiffness, sp_y=5e7, sp_x=5e7, wdthp=0.15, etap_z=0.25, etap_y=0.25,
        etap_x=0.25, etap_r=0.25,
    )  # fmt: skip
    sleeper = parts.Sleeper(
        ms=TRACK.sleeper_mass, Is_x=1.0, Is_y=1.0, Is_z=1.0, rhos=2500.0, lengs=2.5, wdths=0.2, heights=0.2, z_st=0.1,
        z_sb=0.1, equi_sm=False,
    )  # fmt: skip
    ballast = parts.Ballast(
        sb_z=TRACK.ver.ballast_stiffness, sb_y=4e7, sb_x=5e7, etab_z=1.0, etab_y=1.0, etab_x=1.0, etab_r=1.0
    )
    theirs = tracks.SimplePeriodicBallastedSingleRailTrack(
        rail=UIC60, pad=pad, sleeper=sleeper, ballast=ballast, num_mount=101, distance=TRACK.spacing, z_f=0.081, y_f=0.0
    )
    rail = replace(
        TRACK.section, mass_per_length=UIC60.mr, area=UIC60.Ar, shear_modulus=UIC60.G, shear_coefficient_ver=UIC60.kapz,
        bending_stiffness_ver=UIC60.E * UIC60.Iyr, loss_factor=UIC60.etar,
    )  # fmt: skip
    f = np.geomspace(50.0, 3000.0, 25)
    mounts = np.array(list(theirs.mount_prop))
    for position in (0.0, 0.5):
        x = float(mounts[50] + position * TRACK.spacing)
        other = beams.TSBDiscr2L(track=theirs, f=f, x_excit=x, damp_type="hysteretic").receptance
        ours = discrete_receptance(2 * np.pi * f, DiscreteTrack(replace(TRACK, section=rail), position))[:, VER, VER]
        # 1 %: their rail density (7860) is not mass over area (7849), and their supports end after 50 spans
        np.testing.assert_allclose(ours, other, rtol=0.01)


@pytest.mark.parametrize("direction", ["lon", "lat", "spin"])
def test_the_shipped_discrete_rail_follows_the_finite_elements(direction: str) -> None:
    """What is promised of the accurate rail: 0.5 dB and 3 degrees, here with up to 16 modes."""
    error = _shipped_error()[direction]
    assert error["rms_db"] <= 0.5
    assert error["rms_degrees"] <= 3.0
    assert error["modes"] <= 16


@pytest.mark.xfail(
    strict=True, reason="0.57 dB and 4.4 degrees with 16 modes: hysteretic losses of two kinds, see docs"
)
def test_the_shipped_discrete_rail_follows_the_finite_elements_vertically() -> None:
    error = _shipped_error()["ver"]
    assert error["rms_db"] <= 0.5
    assert error["rms_degrees"] <= 3.0


def test_the_shipped_discrete_rail_keeps_the_resonance() -> None:
    """The pinned-pinned peak at mid-span is at its frequency and within 1.5 dB of its height (measured: 1.0)."""
    f = np.arange(900.0, 1251.0, 10.0)
    exact = np.abs(discrete_receptance(2 * np.pi * f, DiscreteTrack(TRACK, 0.5))[:, VER, VER])
    modal = np.abs(receptance(2 * np.pi * f, read_modal_data(DATA / "rail-discrete.toml").modes)[:, VER, VER])
    assert f[np.argmax(modal)] == f[np.argmax(exact)]
    assert abs(20 * np.log10(modal.max() / exact.max())) < 1.5
    assert shipped_rail("rail-discrete").name == "rail_discrete"


@functools.cache
def _shipped_error() -> dict[str, dict[str, float]]:
    """Return the errors of the shipped modal rail against the finite elements, every fourth of the 200 frequencies."""
    omega = 2 * np.pi * error_frequencies()[::4]
    modes = read_modal_data(DATA / "rail-discrete.toml").modes
    return fit_errors(omega, discrete_receptance(omega, DiscreteTrack(TRACK, 0.5)), modes)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position": 1.5}, "position = 1.5; must be from 0 to 1 of the span"),
        ({"spans": 1}, r"1 \+ 2 x 14 spans; must be at least 2 \+ 2 x 1"),
        ({"track": replace(TRACK, contact_offset=0.01)}, "contact_offset = 0.01 m; must be 0"),
    ],
)
def test_faults_are_named(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        replace(DiscreteTrack(TRACK), **changes)


def test_frequencies_must_be_positive() -> None:
    with pytest.raises(ValueError, match="must be finite and > 0"):
        discrete_receptance([0.0], DiscreteTrack(TRACK))
