"""The paper's equivalent modal rail: `Track` in, `Modes` out.

Natural frequencies are the cut-on frequencies of the track, damping follows from the losses (C = s eta / omega_0), and
one over-damped mode at 20 kHz stands for the waves that leave along the rail. Only modal masses are fitted, and what
the extra mode damps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..interface import DIRECTIONS
from ..modal.modes import Modes
from .fit import BAND_HZ, error_frequencies
from .track import tilting_stiffness, track_receptance
from .track_data import Support, Track

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

EXTRA_HZ = 20e3
WITHOUT_EXTRA_BAND_HZ = (30.0, 1000.0)
"""The paper finds the modal rail without the extra mode good up to 1 kHz: fitted there only."""


@dataclass(frozen=True)
class CutOn:
    """Cut-on frequencies of the waves in one direction, where the rail moves as a rigid section on its supports.

    Attributes
    ----------
    omega : (n,) angular frequencies without losses [rad/s]
    loss_factor : (n,) mean of the losses, weighted by the strain energy of each motion [-]
    """

    omega: Real
    loss_factor: Real


def cut_on(track: Track, direction: str) -> CutOn:
    """Return the cut-ons within the band; spin, whose own lies above, shows those of the lateral waves.

    Notes
    -----
    Eigenvalues of the section's motion at wavenumber 0: rail and sleeper, and lateral with torsion also the rotation.
    """
    if direction in ("lat", "spin"):
        support, turning = track.lat, track.lateral_model == "torsion"
    else:
        support, turning = {"lon": track.lon, "ver": track.ver}[direction], False
    K, M = _rigid_section(track, support, turning)
    root = 1 / np.sqrt(M)
    squared, vectors = np.linalg.eigh(K.real * np.outer(root, root))
    shapes = vectors * root[:, None]
    loss = np.einsum("ij,ik,kj->j", shapes, K.imag, shapes) / squared
    within = squared < (2 * np.pi * BAND_HZ[1]) ** 2
    return CutOn(np.sqrt(squared[within]), loss[within])


def paper_modes(track: Track, extra: bool = True) -> Modes:
    """Return the modal rail of a track by the paper's method.

    Parameters
    ----------
    extra : bool
        Whether to add the mode at 20 kHz in each direction.

    Notes
    -----
    Section 3.1 of the paper. C = s eta / omega_0 makes the damping ratio half the loss factor. The paper does not print
    how it finds modal masses: here by least squares of the logarithm of the complex receptance, 30 Hz to 5 kHz, or
    without the extra mode to 1 kHz. Every cut-on in the band makes a mode, in the direction of spin too.
    """
    omega = 2 * np.pi * (error_frequencies() if extra else np.geomspace(*WITHOUT_EXTRA_BAND_HZ, 150))
    target = track_receptance(omega, track)
    rows: list[list[float]] = []
    labels: list[str] = []
    for j, direction in enumerate(DIRECTIONS):
        found = cut_on(track, direction)
        natural, zeta, squared = _masses(omega, target[:, j, j], found, extra)
        for i in range(natural.size):
            rows.append([natural[i], zeta[i], *(np.sqrt(squared[i]) if k == j else 0.0 for k in range(4))])
            labels.append(f"{direction} extra" if i == found.omega.size else f"{direction} {i + 1}")
    table = np.array(rows)
    return Modes(table[:, 0], table[:, 1], table[:, 2:], tuple(labels))


def _rigid_section(track: Track, support: Support, turning: bool) -> tuple[Complex, Real]:
    """Return complex stiffness matrix and masses per length of displacement, sleeper if any, and rotation if wanted."""
    rail = track.section
    pad = support.pad_stiffness * (1 + 1j * support.pad_loss_factor) / track.spacing
    foot = np.array([1.0, -1.0, -rail.foot_depth])
    K = pad * np.outer(foot, foot)
    K[2, 2] += tilting_stiffness(track)
    M = np.array([rail.mass_per_length, track.sleeper_mass / track.spacing, rail.density * rail.polar_moment])
    used = [0]
    if support.ballast_stiffness is not None:
        K[1, 1] += support.ballast_stiffness * (1 + 1j * support.ballast_loss_factor) / track.spacing
        used.append(1)
    if turning:
        used.append(2)
    return K[np.ix_(used, used)], M[used]


def _masses(w: Real, target: Complex, found: CutOn, extra: bool) -> tuple[Real, Real, Real]:
    """Return frequencies, damping ratios and fitted psi^2; of the extra mode, the damping ratio is fitted too."""
    natural = np.append(found.omega, 2 * np.pi * EXTRA_HZ) if extra else found.omega
    n = natural.size

    def zeta_of(x: Real) -> Real:
        return np.append(found.loss_factor / 2, np.exp(x[n:]))

    def residual(x: Real) -> Real:
        damping = 2j * zeta_of(x) * natural * w[:, None]
        fitted = (np.exp(x[:n]) / (natural**2 - w[:, None] ** 2 + damping)).sum(axis=1)
        ratio = np.log(fitted / target)
        return np.concatenate([ratio.real, ratio.imag])

    best, cost = np.zeros(n), np.inf
    for start in (0.5, 5.0, 50.0) if extra else (1.0,):
        zeta = np.append(found.loss_factor / 2, start)[:n]
        size = np.abs(target).max() * 2 * np.minimum(zeta, 1) * natural**2
        first = np.append(np.log(size / n), [np.log(start)] if extra else [])
        bounds = (np.full(first.size, -30.0), np.append(np.full(n, 30.0), [np.log(300.0)] if extra else []))
        result = least_squares(residual, np.clip(first, -29.0, bounds[1] - 1e-3), bounds=bounds, max_nfev=300)
        if result.cost < cost:
            best, cost = result.x, result.cost
    return natural, zeta_of(best), np.exp(best[:n])
