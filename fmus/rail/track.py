"""The analytical track: `Track` and frequencies in, point receptance in four directions out. No files.

An infinite rail on a continuous two-layer support with hysteretic damping, time factor exp(+j omega t). Each direction
is a rational function of the squared wavenumber, whose inverse Fourier transform at the contact is a sum of residues.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import DataError
from .track_data import Section, Support, Track

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

LON, LAT, VER, SPIN = range(4)


def track_receptance(omega: ArrayLike, track: Track) -> Complex:
    """Return displacement per unit force at the contact.

    Parameters
    ----------
    omega : (m,) array_like
        Angular frequencies [rad/s], > 0.
    track : Track
        Rail and supports.

    Returns
    -------
    (m, 4, 4) complex array
        Laid out as `fmus.modal.receptance`: displacement in the second index's direction per force in the third's.

    Notes
    -----
    Cross terms vanish as in the paper, with one exception: a contact beside the rail's axis of symmetry couples lateral
    and vertical motion through torsion (only with `lateral_model` 'torsion'). Longitudinal motion is that of a rod, the
    same for every point of the section, so that neither height nor offset of the contact enters it.
    """
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    if w.ndim != 1 or not np.isfinite(w).all() or (w <= 0).any():
        raise DataError("track_receptance: angular frequencies must be finite and > 0")
    alpha = np.zeros((w.size, 4, 4), dtype=complex)
    alpha[:, LON, LON] = _residue_sum(*_rod(w, track))
    alpha[:, VER, VER] = _residue_sum(*_vertical(w, track))
    if track.lateral_model == "bending":
        numerators, denominator = _lateral_bending(w, track)
    else:
        numerators, denominator = _lateral_torsion(w, track)
    lateral = {name: _residue_sum(numerator, denominator) for name, numerator in numerators.items()}
    alpha[:, LAT, LAT] = lateral["head"]
    alpha[:, SPIN, SPIN] = lateral["rotation"]
    if track.contact_offset and "torsion" in lateral:  # the head turns to +lat: a point at +offset sinks
        alpha[:, VER, VER] += track.contact_offset**2 * lateral["torsion"]
        alpha[:, LAT, VER] = alpha[:, VER, LAT] = -track.contact_offset * lateral["head_torsion"]
    return alpha


def track_mobility(omega: ArrayLike, track: Track) -> Complex:
    """Return velocity per unit force at the contact, (m, 4, 4); see `track_receptance`."""
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    return np.asarray(1j * w[:, None, None] * track_receptance(w, track))


def decay_rates(omega: ArrayLike, track: Track) -> Real:
    """Return how quickly lateral and vertical vibration die away along the rail, (m, 2) [1/m].

    Parameters
    ----------
    omega : (m,) array_like
        Angular frequencies [rad/s], > 0.

    Notes
    -----
    The amplitude goes as exp(-beta |x|) where one wave carries all. With several, near fields among them, beta is what
    EN 15461 makes of a measurement: one over the integral of |a(x)/a(0)|^2 over the whole rail, 8.686 beta in dB/m.
    """
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    if track.lateral_model == "bending":
        numerators, denominator = _lateral_bending(w, track)
    else:
        numerators, denominator = _lateral_torsion(w, track)
    return np.stack([_decay(numerators["head"], denominator), _decay(*_vertical(w, track))], axis=1)


def support_stiffness(omega: Real, support: Support, track: Track) -> Complex:
    """Return the dynamic stiffness of the support per length [N/m2]: pad, sleeper mass, ballast in series."""
    pad = support.pad_stiffness * (1 + 1j * support.pad_loss_factor) / track.spacing
    if support.ballast_stiffness is None:
        return np.full(omega.shape, pad)
    ballast = support.ballast_stiffness * (1 + 1j * support.ballast_loss_factor) / track.spacing
    sleeper = ballast - omega**2 * track.sleeper_mass / track.spacing
    return np.asarray(pad * sleeper / (pad + sleeper))


def tilting_stiffness(track: Track) -> complex:
    """Return the stiffness per length [N] of the vertical pads against rotation of the rail about its axis."""
    pad = track.ver.pad_stiffness * (1 + 1j * track.ver.pad_loss_factor) / track.spacing
    return pad * track.section.foot_width**2 / 12


# Polynomials in the squared wavenumber, lowest power first: (m, degree + 1).


def _rod(w: Real, track: Track) -> tuple[Complex, Complex]:
    """Return numerator and denominator of the longitudinal rod."""
    rail = track.section
    stiffness = rail.young_modulus * rail.area * _loss(rail)
    q = support_stiffness(w, track.lon, track) - rail.mass_per_length * w**2
    return _polynomial(w, 1.0), _polynomial(w, q, stiffness)


def _timoshenko(w: Real, support: Complex, rail: Section, direction: str) -> tuple[Complex, Complex, complex]:
    """Return the diagonal entries for displacement and rotation of a Timoshenko beam, and its shear stiffness."""
    bending = getattr(rail, f"bending_stiffness_{direction}")
    shear = getattr(rail, f"shear_coefficient_{direction}") * rail.shear_modulus * rail.area * _loss(rail)
    rotary_inertia = rail.density * bending / rail.young_modulus
    displacement = _polynomial(w, support - rail.mass_per_length * w**2, shear)
    rotation = _polynomial(w, shear - rotary_inertia * w**2, bending * _loss(rail))
    return displacement, rotation, shear


def _vertical(w: Real, track: Track) -> tuple[Complex, Complex]:
    """Return numerator and denominator of the vertical Timoshenko beam."""
    u, r, shear = _timoshenko(w, support_stiffness(w, track.ver, track), track.section, "ver")
    return r, _product(u, r) - _polynomial(w, 0.0, shear**2, 0.0)


def _lateral_bending(w: Real, track: Track) -> tuple[dict[str, Complex], Complex]:
    """Return numerators and denominator of the lateral Timoshenko beam."""
    u, r, shear = _timoshenko(w, support_stiffness(w, track.lat, track), track.section, "lat")
    return {"head": r, "rotation": u}, _product(u, r) - _polynomial(w, 0.0, shear**2, 0.0)


def _lateral_torsion(w: Real, track: Track) -> tuple[dict[str, Complex], Complex]:
    """Return numerators and denominator of lateral bending coupled to torsion by the support under the foot.

    Notes
    -----
    Unknowns: lateral displacement of the centroid u, rotation of the section about the vertical axis r, torsion t.
    With the matrix D(k) the numerators are entries of its adjugate, the denominator is its determinant:
    D = [[u, -jkS, c], [jkS, r, 0], [c, 0, t]].
    """
    rail = track.section
    s = support_stiffness(w, track.lat, track)
    u, r, shear = _timoshenko(w, s, rail, "lat")
    torsion = s * rail.foot_depth**2 + tilting_stiffness(track) - rail.density * rail.polar_moment * w**2
    t = _polynomial(
        w, torsion, rail.shear_modulus * rail.torsion_constant * _loss(rail),
        rail.young_modulus * rail.warping_constant * _loss(rail),
    )  # fmt: skip
    if rail.warping_constant == 0:
        t = t[:, :2]
    coupling = _polynomial(w, -s * rail.foot_depth)
    bending = _sum(_product(u, r), -_polynomial(w, 0.0, shear**2))
    mixed: Complex = -_product(coupling, r)
    head = rail.head_height
    numerators = {
        "head": _sum(_product(r, t), 2 * head * mixed, head**2 * bending),
        "rotation": _sum(_product(u, t), -_product(coupling, coupling)),
        "torsion": bending,
        "head_torsion": _sum(mixed, head * bending),
    }
    return numerators, _sum(_product(bending, t), -_product(_product(coupling, coupling), r))


def _loss(rail: Section) -> complex:
    """Return the factor that hysteretic damping puts on the rail's moduli."""
    return 1 + 1j * rail.loss_factor


def _polynomial(w: Real, *coefficients: ArrayLike) -> Complex:
    """Return a polynomial for each frequency."""
    return np.stack([np.broadcast_to(np.asarray(c, dtype=complex), w.shape) for c in coefficients], axis=1)


def _product(a: Complex, b: Complex) -> Complex:
    """Return the product of polynomials."""
    out = np.zeros((a.shape[0], a.shape[1] + b.shape[1] - 1), dtype=complex)
    for i in range(b.shape[1]):
        out[:, i : i + a.shape[1]] += a * b[:, i : i + 1]
    return out


def _sum(*terms: Complex) -> Complex:
    """Return the sum of polynomials of any degrees."""
    out = np.zeros((terms[0].shape[0], max(term.shape[1] for term in terms)), dtype=complex)
    for term in terms:
        out[:, : term.shape[1]] += term
    return out


def _decay(numerator: Complex, denominator: Complex) -> Real:
    """Return one over the integral of |a(x)/a(0)|^2 over all x, (m,)."""
    k, a = _waves(numerator, denominator)
    pairs = a[:, :, None] * a[:, None, :].conj() / (1j * (k[:, :, None] - k[:, None, :].conj()))
    return np.asarray(np.abs(a.sum(axis=1)) ** 2 / (2 * pairs.sum(axis=(1, 2)).real))


def _residue_sum(numerator: Complex, denominator: Complex) -> Complex:
    """Return (1/2 pi) times the integral over all wavenumbers k of numerator(k^2) / denominator(k^2)."""
    return np.asarray(_waves(numerator, denominator)[1].sum(axis=1))


def _waves(numerator: Complex, denominator: Complex) -> tuple[Complex, Complex]:
    """Return wavenumbers k_i and amplitudes a_i, (m, waves) each, of the response sum a_i exp(-j k_i |x|).

    Notes
    -----
    With k_i the roots in the lower half plane: a_i = -j N(k_i^2) / (2 k_i P'(k_i^2)). The roots are found as squares;
    Im k < 0 fixes the sign of the square root. Writing the root of the whole product instead, as the textbook form of
    the rod invites to, crosses the branch cut where stiffness and loss factor put it and turns the mobility over.
    """
    degree = denominator.shape[1] - 1
    scale = np.abs(denominator[:, :1] / denominator[:, -1:]) ** (1 / degree)
    powers = scale ** np.arange(degree + 1)
    monic = denominator * powers / (denominator[:, -1:] * powers[:, -1:])
    companion = np.zeros((denominator.shape[0], degree, degree), dtype=complex)
    companion[:, np.arange(1, degree), np.arange(degree - 1)] = 1.0
    companion[:, :, -1] = -monic[:, :-1]
    x: Complex = np.linalg.eigvals(companion).astype(complex)
    slope = monic[:, 1:] * np.arange(1, degree + 1)
    for _ in range(2):  # a Newton step or two brings companion roots of different size to rounding
        x = x - _value(monic, x) / _value(slope, x)
    k = np.sqrt(x * scale)
    k = np.where(k.imag > 0, -k, k)
    prime = _value(slope, x) * denominator[:, -1:] * powers[:, -1:] / scale
    return k, np.asarray(-1j * _value(numerator, x * scale) / (2 * k * prime))


def _value(polynomial: Complex, x: Complex) -> Complex:
    """Return the polynomials at several points each, (m, points)."""
    out = np.zeros_like(x)
    for i in range(polynomial.shape[1] - 1, -1, -1):
        out = out * x + polynomial[:, i : i + 1]
    return out
