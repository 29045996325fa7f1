"""The analytical track: closed forms, an independent route over the wavenumber, limits and the paper's peaks."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fmus.rail.track import support_stiffness, tilting_stiffness, track_mobility, track_receptance
from fmus.rail.track_data import TRACKS, Track, read_track

LON, LAT, VER, SPIN = range(4)

NAMES = ("default", "soft-pads", "rail-dampers", "bs113a", "slab")

OMEGA = 2 * np.pi * np.array([30.0, 79.0, 215.0, 700.0, 1100.0, 3000.0, 5000.0])


def _track(name: str = "default") -> Track:
    return read_track(TRACKS / f"{name}.toml")


def _by_quadrature(w: float, track: Track, offset: float) -> NDArray[np.complex128]:
    """Integrate the inverse of the dynamic stiffness over the wavenumber by the trapezoidal rule, k = sinh(t).

    The rule converges exponentially; the nearest pole is 0.01 off the axis (loss factor 0.02), so a step of 0.002
    leaves exp(-2 pi 0.01 / 0.002) = 2e-14.
    """
    rail = track.section
    eta = 1 + 1j * rail.loss_factor
    t = np.arange(-24.0, 24.0, 0.002)
    k, dk = np.sinh(t), np.cosh(t) * 0.002
    s = {d: support_stiffness(np.array([w]), getattr(track, d), track)[0] for d in ("lon", "lat", "ver")}
    D = np.zeros((k.size, 6, 6), dtype=complex)  # u_lon, u_ver, rotation of ver, u_lat, rotation of lat, torsion
    D[:, 0, 0] = rail.young_modulus * rail.area * eta * k**2 + s["lon"] - rail.mass_per_length * w**2
    for first, d in ((1, "ver"), (3, "lat")):
        bending = getattr(rail, f"bending_stiffness_{d}")
        shear = getattr(rail, f"shear_coefficient_{d}") * rail.shear_modulus * rail.area * eta
        D[:, first, first] = shear * k**2 + s[d] - rail.mass_per_length * w**2
        D[:, first + 1, first + 1] = bending * eta * k**2 + shear
        D[:, first + 1, first + 1] -= rail.density * bending / rail.young_modulus * w**2
        D[:, first, first + 1] = -1j * k * shear
        D[:, first + 1, first] = 1j * k * shear
    D[:, 5, 5] = rail.shear_modulus * rail.torsion_constant * eta * k**2
    D[:, 5, 5] += rail.young_modulus * rail.warping_constant * eta * k**4
    D[:, 5, 5] += s["lat"] * rail.foot_depth**2 + tilting_stiffness(track) - rail.density * rail.polar_moment * w**2
    e = np.zeros((6, 4))
    e[0, LON] = e[1, VER] = e[3, LAT] = e[4, SPIN] = 1.0
    if track.lateral_model == "torsion":
        D[:, 3, 5] = D[:, 5, 3] = -s["lat"] * rail.foot_depth
        e[5, LAT], e[5, VER] = rail.head_height, -offset
    balance = 1 / np.sqrt(np.abs(np.einsum("kii->ki", D)))
    flexibility = np.linalg.inv(D * balance[:, :, None] * balance[:, None, :])
    flexibility *= balance[:, :, None] * balance[:, None, :]
    integral: NDArray[np.complex128] = np.einsum("ij,kil,lm,k->jm", e, flexibility, e, dk) / (2 * np.pi)
    return integral


@pytest.mark.parametrize("lateral_model", ["torsion", "bending"])
@pytest.mark.parametrize("name", NAMES)
def test_residues_equal_the_integral_over_the_wavenumber(name: str, lateral_model: str) -> None:
    """Two routes to the inverse Fourier transform, in all pairs of directions."""
    offset = 0.012
    track = replace(_track(name), contact_offset=offset, lateral_model=lateral_model)
    for w in (2 * np.pi * 75.0, 2 * np.pi * 2100.0):
        residues = track_receptance([w], track)[0]
        quadrature = _by_quadrature(w, track, offset)
        scale = np.sqrt(np.outer(np.abs(np.diag(residues)), np.abs(np.diag(residues))))
        # rounding: 48000 terms whose matrices have entries of 1e-3 to 1e20 before balancing
        np.testing.assert_allclose(residues / scale, quadrature / scale, rtol=0, atol=1e-8)


def test_static_receptance_is_that_of_the_beam_on_elastic_foundation() -> None:
    """Without shear: 1 / (2 sqrt(2) (EI)^(1/4) s^(3/4)), hysteretic losses included."""
    track = _track()
    stiff = replace(track, section=replace(track.section, shear_coefficient_ver=1e6))
    w = np.array([1e-3])
    s = support_stiffness(w, stiff.ver, stiff)[0]
    EI = stiff.section.bending_stiffness_ver * (1 + 1j * stiff.section.loss_factor)
    expected = 1 / (2 * np.sqrt(2) * EI**0.25 * s**0.75)
    # the shear left over is sqrt(s EI) / S = 7e-8 of the bending
    assert track_receptance(w, stiff)[0, VER, VER] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_high_frequency_mobility_is_that_of_the_free_waves(name: str) -> None:
    """Shear wave and rod wave alone: 1 / (2 sqrt(kappa G A m)) = 4.1e-6, 1 / (2 sqrt(E A m)) = 1.61e-6 for UIC 60."""
    track = _track(name)
    rail, w = track.section, np.array([2 * np.pi * 2e6])
    eta = 1 + 1j * rail.loss_factor
    m = rail.mass_per_length
    shear = rail.shear_coefficient_ver * rail.shear_modulus * rail.area * eta
    mobility = track_mobility(w, track)[0]
    # both neglect terms in (cut-on / frequency)^2: below (13 kHz / 2 MHz)^2 = 4e-5 in shear, 1e-8 in the rod
    assert mobility[VER, VER] == pytest.approx(1 / (2 * np.sqrt(shear * m)), rel=1e-3)
    assert mobility[LON, LON] == pytest.approx(1 / (2 * np.sqrt(rail.young_modulus * rail.area * eta * m)), rel=1e-6)
    if name not in {"bs113a", "rail-dampers"}:  # the numbers are those of UIC 60 with little loss
        assert abs(mobility[VER, VER]) == pytest.approx(4.1e-6, rel=0.01)  # two digits were given
        assert abs(mobility[LON, LON]) == pytest.approx(1.61e-6, rel=0.005)


def test_a_foot_on_the_shear_centre_leaves_bending_and_torsion_apart() -> None:
    """Head = bending beam + h^2 times a torsion bar, 1 / (2 sqrt(GJ (s_theta - rho Ip w^2)))."""
    track = _track()
    rail = replace(track.section, foot_depth=1e-9, warping_constant=0.0)
    apart = replace(track, section=rail)
    bending = track_receptance(OMEGA, replace(apart, lateral_model="bending"))
    GJ = rail.shear_modulus * rail.torsion_constant * (1 + 1j * rail.loss_factor)
    wavenumber = np.sqrt((tilting_stiffness(track) - rail.density * rail.polar_moment * OMEGA**2) / GJ)
    bar = 1 / (2 * GJ * wavenumber)
    both = track_receptance(OMEGA, apart)
    # 1e-8: the coupling left over is of the order of foot_depth / head_height
    np.testing.assert_allclose(both[:, LAT, LAT], bending[:, LAT, LAT] + rail.head_height**2 * bar, rtol=1e-7)
    np.testing.assert_allclose(both[:, SPIN, SPIN], bending[:, SPIN, SPIN], rtol=1e-7)


@pytest.mark.parametrize("offset", [0.0, 0.015])
@pytest.mark.parametrize("lateral_model", ["torsion", "bending"])
@pytest.mark.parametrize("name", NAMES)
def test_the_track_takes_energy_in_every_direction(name: str, lateral_model: str, offset: float) -> None:
    """Re Y > 0 in four directions and the Hermitian part positive definite; a wrong branch would flip the sign."""
    track = replace(_track(name), lateral_model=lateral_model, contact_offset=offset)
    Y = track_mobility(2 * np.pi * np.geomspace(10, 6000, 800), track)
    assert (np.einsum("mii->mi", Y).real > 0).all()
    scale = np.array([1.0, 1.0, 1.0, 0.1])  # spin in the size of the others, for the eigenvalues' rounding
    assert (np.linalg.eigvalsh(Y.real * scale[:, None] * scale) > 0).all()


@given(
    pad=st.floats(1e6, 2e9), ballast=st.floats(1e6, 1e9), loss=st.floats(0.0, 2.0),
    rail_loss=st.floats(1e-3, 0.5), frequency=st.floats(10.0, 6e3),
)  # fmt: skip
def test_any_track_takes_energy(pad: float, ballast: float, loss: float, rail_loss: float, frequency: float) -> None:
    """Re Y > 0 whatever the stiffness and the losses: no branch is left on the wrong side."""
    track = _DEFAULT
    supports = {
        d: replace(
            getattr(track, d), pad_stiffness=pad, ballast_stiffness=ballast, pad_loss_factor=loss,
            ballast_loss_factor=loss,
        )
        for d in ("lon", "lat", "ver")
    }  # fmt: skip
    changed = replace(track, section=replace(track.section, loss_factor=rail_loss), **supports)
    assert (np.diagonal(track_mobility([2 * np.pi * frequency], changed)[0]).real > 0).all()


_DEFAULT = _track()


def test_the_vertical_peaks_are_those_of_figure_3() -> None:
    """79 and 700 Hz (printed: 80 and 700 Hz), 8.9e-9 and 3.0e-9 m/N."""
    f = np.arange(20.0, 2000.0, 0.5)
    magnitude = np.abs(track_receptance(2 * np.pi * f, _track())[:, VER, VER])
    peaks = [i for i in range(1, f.size - 1) if magnitude[i - 1] < magnitude[i] > magnitude[i + 1]]
    assert len(peaks) == 2
    assert f[peaks[0]] == pytest.approx(79, abs=2)
    assert f[peaks[1]] == pytest.approx(700, abs=5)
    # two digits were given
    assert magnitude[peaks[0]] == pytest.approx(8.9e-9, rel=0.01)
    assert magnitude[peaks[1]] == pytest.approx(3.0e-9, rel=0.02)


def test_torsion_brings_the_extra_lateral_modes() -> None:
    """The head's receptance has a third peak, where the rail turns on its pads (the paper: more modes in lateral)."""
    f = np.arange(20.0, 2000.0, 0.5)

    def peaks(track: Track) -> list[float]:
        magnitude = np.abs(track_receptance(2 * np.pi * f, track)[:, LAT, LAT])
        return [float(f[i]) for i in range(1, f.size - 1) if magnitude[i - 1] < magnitude[i] > magnitude[i + 1]]

    track, rail = _track(), _track().section
    assert len(peaks(replace(track, lateral_model="bending"))) == 2
    assert len(peaks(track)) == 3
    # without losses a peak is where a wave cuts on: there the rail moves as a rigid section on the two layers
    low = {d: replace(getattr(track, d), pad_loss_factor=1e-3, ballast_loss_factor=1e-3) for d in ("lon", "lat", "ver")}
    clear = replace(track, section=replace(rail, loss_factor=1e-3), **low)
    pad, ballast, h = track.lat.pad_stiffness, track.lat.ballast_stiffness or 0.0, rail.foot_depth
    K = np.array([[pad, -pad * h, -pad], [-pad * h, pad * h**2, pad * h], [-pad, pad * h, pad + ballast]])
    K[1, 1] += tilting_stiffness(track).real * track.spacing
    M = np.array([rail.mass_per_length, rail.density * rail.polar_moment, track.sleeper_mass / track.spacing])
    cut_on = np.sqrt(np.linalg.eigvalsh(K / track.spacing / np.sqrt(np.outer(M, M)))) / (2 * np.pi)
    found = peaks(clear)
    # 0.5 Hz: the grid
    assert min(abs(np.array(found) - cut_on[2])) <= 0.5
    assert min(abs(np.array(found) - cut_on[0])) <= 0.5


@pytest.mark.parametrize(
    ("direction", "frequency_hz", "magnitude"),
    [
        (VER, 150, 3.7e-6), (VER, 272, 1.7e-6), (VER, 418, 2.8e-6), (VER, 1102, 5.9e-6), (VER, 3977, 3.8e-6),
        (LAT, 272, 2.1e-5), (LAT, 1102, 6.4e-6), (LAT, 3977, 3.9e-6), (SPIN, 100, 7.8e-5), (SPIN, 1000, 3.1e-4),
        (SPIN, 4000, 7.8e-4),
    ],
)  # fmt: skip
def test_mobility_agrees_with_an_independent_calculation(direction: int, frequency_hz: float, magnitude: float) -> None:
    """Values of a separately written program for the same track, lateral bending only; two digits were given."""
    track = replace(_track(), lateral_model="bending")
    Y = track_mobility([2 * np.pi * frequency_hz], track)[0, direction, direction]
    assert abs(Y) == pytest.approx(magnitude, rel=0.03)


def test_cross_terms_vanish_but_for_an_offset_contact() -> None:
    """On the plane of symmetry none; beside it lateral-vertical, reciprocal and odd in the offset."""
    centred = track_receptance(OMEGA, _track())
    off_diagonal = ~np.eye(4, dtype=bool)
    assert not centred[:, off_diagonal].any()
    right = track_receptance(OMEGA, replace(_track(), contact_offset=0.01))
    left = track_receptance(OMEGA, replace(_track(), contact_offset=-0.01))
    np.testing.assert_array_equal(right, right.transpose(0, 2, 1))
    np.testing.assert_array_equal(right[:, LAT, VER], -left[:, LAT, VER])
    assert (np.abs(right[:, LAT, VER]) > 0).all()
    np.testing.assert_array_equal(right[:, LAT, LAT], centred[:, LAT, LAT])
    off_diagonal[LAT, VER] = off_diagonal[VER, LAT] = False
    assert not right[:, off_diagonal].any()


def test_a_vertical_force_beside_the_axis_turns_the_head_outwards() -> None:
    """At rest, an upward force on the gauge side lifts that side, so the head moves to the field side: negative."""
    static = track_receptance([1e-3], replace(_track(), contact_offset=0.02))[0]
    assert static[LAT, VER].real < 0


def test_an_independent_implementation_agrees() -> None:
    """Rolland's Euler beam on two continuous layers, of which ours is the limit without shear and rotary inertia.

    Rolland gives the rail no loss factor and needs Python 3.12 or later.
    """
    reason = "rolland needs Python >= 3.12"
    parts = pytest.importorskip("rolland.components", reason=reason)
    beams = pytest.importorskip("rolland.methods.analytical", reason=reason)
    tracks = pytest.importorskip("rolland.track", reason=reason)
    UIC60 = pytest.importorskip("rolland.database.rail.db_rail", reason=reason).UIC60
    track, d = _track(), _track().spacing
    pad = parts.ContPad(
        sp_z=track.ver.pad_stiffness / d, sp_y=1e8, sp_x=1e8, wdthp=0.15, etap_z=track.ver.pad_loss_factor, etap_y=0.25,
        etap_x=0.25, etap_r=0.25,
    )  # fmt: skip
    assert track.ver.ballast_stiffness is not None
    eta = track.ver.ballast_loss_factor
    ballast = parts.Ballast(
        sb_z=track.ver.ballast_stiffness / d, sb_y=1e8, sb_x=1e8, etab_z=eta, etab_y=eta, etab_x=eta, etab_r=eta,
    )  # fmt: skip
    slab = parts.Slab(
        ms=track.sleeper_mass / d, Is_x=1.0, Is_y=1.0, Is_z=1.0, rhos=2500.0, lengs=2.5, equ_wdths=0.2, heights=0.2,
        z_st=0.1, z_sb=0.1, equi_sm=False,
    )  # fmt: skip
    theirs = tracks.ContBallastedSingleRailTrack(rail=UIC60, pad=pad, slab=slab, ballast=ballast, z_f=0.081, y_f=0.0)
    f = np.geomspace(20.0, 2000.0, 40)
    other = beams.EBBCont2L(track=theirs, f=f, damp_type="hysteretic").receptance
    rail = replace(
        track.section, mass_per_length=UIC60.mr, bending_stiffness_ver=UIC60.E * UIC60.Iyr, loss_factor=1e-9,
        shear_coefficient_ver=1e-3, area=1e6,
    )  # fmt: skip
    factor = float(theirs.E[1])  # equivalence factor of their sleeper, 1 when it is switched off
    assert factor == 1.0
    ours = track_receptance(2 * np.pi * f, replace(track, section=rail))[:, VER, VER]
    # an area of 1e6 m2 leaves shear and rotary inertia of the order of 1e-6
    np.testing.assert_allclose(ours, other, rtol=1e-4)
