"""Bodies of revolution against closed forms, and the order of convergence."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import iv, jv, kv, yv

from fmus.wheel.finite_elements.harmonics import (
    AXIAL,
    RADIAL,
    TANGENTIAL,
    Body,
    HarmonicModes,
    harmonic_matrices,
    harmonic_modes,
    make_body,
)
from fmus.wheel.finite_elements.mesh import structured_mesh
from fmus.wheel.finite_elements.section import Material

STEEL = Material(210e9, 0.3, 7850.0)
SLIM = Material(210e9, 0.0, 7850.0)


def elastic(
    body: Body, n: int, symmetry: str = "free", below_hz: float = 1e5, motion: str = "all"
) -> NDArray[np.float64]:
    """Return the elastic natural frequencies [Hz]."""
    frequency = harmonic_modes(body, n, symmetry, below_hz, motion).frequency_hz
    return frequency[frequency > 0]


def rod(elements: int, material: Material, length: float = 1.0, radius: float = 0.02) -> Body:
    return make_body(structured_mesh(np.linspace(0, length, elements + 1), [0.0, radius]), material)


def test_torsion_of_a_free_rod_is_the_closed_form() -> None:
    """Free circular rod, twist W = r cos(k pi z/L): f_k = k/(2 L) sqrt(G/rho), exact in three dimensions.

    40 second-order elements: the error of the k-th frequency is (pi k/40)^4/1440, 2.2e-6 for k = 3.
    """
    speed = np.sqrt(STEEL.young_modulus / (2 * 1.3) / STEEL.density)
    found = elastic(rod(40, STEEL), 0, motion="torsion")[:3]
    np.testing.assert_allclose(found, speed / 2 * np.arange(1, 4), rtol=3e-6)


def test_longitudinal_vibration_of_a_free_rod_without_lateral_contraction_is_the_closed_form() -> None:
    """For nu = 0 the bar frequencies k/(2 L) sqrt(E/rho) are exact; tolerance as for torsion."""
    speed = np.sqrt(SLIM.young_modulus / SLIM.density)
    found = elastic(rod(40, SLIM), 0, motion="axial")[:3]
    np.testing.assert_allclose(found, speed / 2 * np.arange(1, 4), rtol=3e-6)


def test_longitudinal_vibration_of_a_free_rod_has_rayleighs_correction() -> None:
    """With lateral inertia f_k = k c/(2 L) (1 - (k pi nu a/L)^2/4), Rayleigh; what is left out is of the fourth power.

    (k pi a/L)^4 = 4e-6 for k = 2, a/L = 0.02 at most enters; 2e-6 is asked of both.
    """
    k = np.arange(1, 3)
    speed = np.sqrt(STEEL.young_modulus / STEEL.density)
    rayleigh = k * speed / 2 * (1 - (k * np.pi * 0.3 * 0.02) ** 2 / 4)
    np.testing.assert_allclose(elastic(rod(40, STEEL), 0, motion="axial")[:2], rayleigh, rtol=2e-6)


def test_bending_of_a_slender_free_rod_is_timoshenkos_beam() -> None:
    """A rod with n = 1 and a radius of 1/200 of its length: Euler's frequency less shear and rotary inertia.

    f = 4.730041^2/(2 pi) sqrt(EI/(rho A L^4)) (1 - (49.48 + 12.30 E/(kappa G)) I/(2 A L^2)): 49.48 and 12.30 are the
    integrals of the squared slope of the free and the clamped mode, kappa = 6 (1 + nu)/(7 + 6 nu) is Cowper's. The
    correction is 2.7e-4, its square 1e-7; 80 elements are 1e-5 off their limit.
    """
    radius = 0.005
    euler = 4.730041**2 / (2 * np.pi) * np.sqrt(STEEL.young_modulus / STEEL.density) * radius / 2
    shear = 2 * 1.3 * (7 + 6 * 0.3) / (6 * 1.3)
    expected = euler * (1 - (49.48 + 12.30 * shear) * radius**2 / 8)
    found = elastic(rod(80, STEEL, radius=radius), 1, below_hz=500.0)[0]
    assert found == pytest.approx(expected, rel=3e-5)


def thin_ring(side: float = 0.004, radius: float = 0.4) -> Body:
    """Return a ring with 4 x 4 elements across: with 2 x 2 its torsional stiffness is 0.3 % too high."""
    lines = np.linspace(-side / 2, side / 2, 5)
    return make_body(structured_mesh(lines, radius + lines), STEEL)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_in_plane_bending_of_a_thin_ring_is_the_closed_form(n: int) -> None:
    """Ring of square section: f = n (n^2-1)/sqrt(n^2+1) sqrt(EI/(rho A R^4))/(2 pi), Love.

    For side/R = 1/100 shear and rotary inertia are of order n^2 (side/R)^2 (1 + 1.2 E/G)/24 = 3e-4 for n = 4.
    """
    side, radius = 0.004, 0.4
    scale = np.sqrt(STEEL.young_modulus / STEEL.density / 12) * side / radius**2 / (2 * np.pi)
    expected = n * (n**2 - 1) / np.sqrt(n**2 + 1) * scale
    ring = thin_ring()
    modes = harmonic_modes(ring, n, below_hz=2000.0)
    in_plane = _in_plane(ring, modes)
    assert modes.frequency_hz[in_plane][0] == pytest.approx(expected, rel=3e-4)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_out_of_plane_bending_of_a_thin_ring_is_the_closed_form(n: int) -> None:
    """Ring of square section: f = n (n^2-1)/sqrt(n^2 + EI/GJ) sqrt(EI/(rho A R^4))/(2 pi), Love; J = 0.140577 side^4.

    Tolerance as in plane.
    """
    side, radius = 0.004, 0.4
    scale = np.sqrt(STEEL.young_modulus / STEEL.density / 12) * side / radius**2 / (2 * np.pi)
    expected = n * (n**2 - 1) / np.sqrt(n**2 + 2 * 1.3 / 12 / 0.140577) * scale
    ring = thin_ring()
    modes = harmonic_modes(ring, n, below_hz=2000.0)
    in_plane = _in_plane(ring, modes)
    assert modes.frequency_hz[~in_plane][0] == pytest.approx(expected, rel=3e-4)


def _in_plane(body: Body, modes: HarmonicModes) -> NDArray[np.bool_]:
    axial = np.where((body.component == AXIAL)[:, None], modes.vectors, 0.0)
    return np.asarray(np.linalg.norm(axial, axis=0) < 0.5 * np.linalg.norm(modes.vectors, axis=0))


def plate_frequency(n: int, thickness: float, outer: float, inner: float, first: float) -> float:
    """Return a frequency of a free annular Kirchhoff plate [Hz], from the root of its determinant next to `first`."""
    nu = STEEL.poisson_ratio
    b = inner / outer

    def edge(k: float, x: float) -> NDArray[np.float64]:
        """Moment and shear of J, Y, I, K of order n at radius x (outer radius 1)."""
        rows = []
        for function, sign in ((jv, -1), (yv, -1), (iv, 1), (kv, 1)):
            f = function(n, k * x)
            h = 1e-4
            slope = k * (function(n, k * x + h) - function(n, k * x - h)) / (2 * h)
            curvature = sign * k**2 * f - slope / x + n**2 * f / x**2
            moment = curvature + nu * (slope / x - n**2 * f / x**2)
            shear = sign * k**2 * slope - (1 - nu) * n**2 / x**2 * (slope - f / x)
            rows.append((moment, shear))
        return np.array(rows).T

    def determinant(k: float) -> float:
        matrix = np.vstack([edge(k, 1.0), edge(k, b)])
        return float(np.linalg.det(matrix / np.abs(matrix).max(axis=0)))

    k = brentq(determinant, first * 0.97, first * 1.03)
    rigidity = STEEL.young_modulus * thickness**3 / (12 * (1 - nu**2))
    return float(k**2 / (2 * np.pi * outer**2) * np.sqrt(rigidity / (STEEL.density * thickness)))


@pytest.mark.parametrize("n", [2, 3, 4])
def test_bending_of_a_free_annular_plate_is_kirchhoffs(n: int) -> None:
    """Plate with inner radius half the outer one, thickness 1/200 of it: roots of the determinant of Bessel functions.

    Kirchhoff's free edges lack a strip of the width of the thickness in torsion, 0.63 h/(R - r) = 0.6 % of the part of
    the stiffness that is twist, half of that in the frequency; 1e-3 is asked, 3e-4 found.
    """
    thickness, outer, inner = 0.002, 0.4, 0.2
    body = make_body(
        structured_mesh(np.linspace(-thickness / 2, thickness / 2, 2), np.linspace(inner, outer, 17)), STEEL
    )
    found = elastic(body, n, below_hz=2000.0)[0]
    rigidity = STEEL.young_modulus * thickness**2 / (12 * (1 - 0.09) * STEEL.density)
    k = np.sqrt(found * 2 * np.pi * outer**2 / np.sqrt(rigidity))
    assert found == pytest.approx(plate_frequency(n, thickness, outer, inner, k), rel=1e-3)


def test_frequencies_converge_with_the_fourth_power_of_the_element_size() -> None:
    """Torsion of a rod: second-order elements give eigenvalues of order 4.

    The observed order differs from 4 by a term in h^2: 0.034 from 4 to 8 elements, a quarter of that from 8 to 16.
    """
    speed = np.sqrt(STEEL.young_modulus / (2 * 1.3) / STEEL.density)
    errors = [elastic(rod(k, STEEL), 0, motion="torsion")[0] / (speed / 2) - 1 for k in (4, 8, 16)]
    order = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(order, 4.0, atol=0.05)


def thick_ring(lines: int = 4) -> Body:
    return make_body(structured_mesh(np.linspace(0.1, 0.2, lines), np.linspace(0.3, 0.4, lines + 1)), STEEL)


@pytest.mark.parametrize("n", range(5))
def test_mode_shapes_are_orthonormal_over_the_body(n: int) -> None:
    """Phi^T M Phi = I and Phi^T K Phi = diag(omega^2), to the accuracy of the eigenvalue solution (1e-8)."""
    body = thick_ring()
    modes = harmonic_modes(body, n, below_hz=2e4)
    scale = (2 * np.pi * 2e4) ** 2
    eye = np.eye(modes.frequency_hz.size)
    omega = 2 * np.pi * modes.frequency_hz
    np.testing.assert_allclose(modes.vectors.T @ body.mass_of(n) @ modes.vectors, eye, atol=1e-8)
    product = modes.vectors.T @ body.stiffness_of(n) @ modes.vectors
    np.testing.assert_allclose(product / scale, np.diag(omega**2) / scale, atol=1e-8)


@pytest.mark.parametrize(("n", "count"), [(0, 2), (1, 2), (2, 0), (3, 0)])
def test_a_free_body_has_its_rigid_body_modes(n: int, count: int) -> None:
    """Axial translation and rotation for n = 0; a translation and a rotation across the axis for n = 1; else none."""
    assert np.count_nonzero(harmonic_modes(thick_ring(), n, below_hz=2e4).frequency_hz == 0) == count


def test_rigid_translation_has_no_strain_energy() -> None:
    """u_r = cos, u_theta = -sin is a translation: K u = 0 relative to the largest entry of K."""
    body = thick_ring()
    u = np.select([body.component == RADIAL, body.component == TANGENTIAL], [1.0, -1.0], 0.0)
    K = body.stiffness_of(1)
    assert np.abs(K @ u).max() < 1e-12 * np.abs(K).max()


def test_mass_of_a_ring_is_pappus() -> None:
    """A unit axial translation has the kinetic energy of the mass rho 2 pi R A."""
    body = thick_ring()
    u = (body.component == AXIAL).astype(float)
    assert u @ body.mass_of(0) @ u == pytest.approx(7850 * 2 * np.pi * 0.35 * 0.01, rel=1e-12)


def test_symmetric_and_antisymmetric_modes_are_those_of_the_whole() -> None:
    """A ring about z = 0, whole, has the frequencies of its half with both conditions, mesh for mesh."""
    whole = make_body(structured_mesh(np.linspace(-0.05, 0.05, 5), np.linspace(0.3, 0.4, 4)), STEEL)
    half = make_body(structured_mesh(np.linspace(0, 0.05, 3), np.linspace(0.3, 0.4, 4)), STEEL)
    halves = np.sort(np.concatenate([elastic(half, 2, s, 2e4) for s in ("symmetric", "antisymmetric")]))
    np.testing.assert_allclose(halves, elastic(whole, 2, below_hz=2e4), rtol=1e-9)


def test_modal_sum_is_the_direct_solution() -> None:
    """Two routes to a receptance: modes with the rest taken as static, or (K - omega^2 M)^-1.

    Lanczos leaves out the highest mode of the mesh, whose dynamic part is (omega/omega_top)^2, some 1e-4, of its static
    one, which is itself a small part of the whole: 1e-6 is asked.
    """
    body = make_body(structured_mesh([0.0, 0.1], [0.3, 0.4]), STEEL)
    K, M, T = (matrix.toarray() for matrix in harmonic_matrices(body, 3, "free"))
    modes = harmonic_modes(body, 3, below_hz=1e9)
    omega = 2 * np.pi * 1500.0
    direct = np.linalg.solve(K - omega**2 * M, np.eye(K.shape[0])[:, :2])[:2]
    shapes = (np.linalg.pinv(T) @ modes.vectors)[:2]
    stiff = np.linalg.solve(K, np.eye(K.shape[0])[:, :2])[:2]
    squares = (2 * np.pi * modes.frequency_hz) ** 2
    by_modes = (shapes / (squares - omega**2)) @ shapes.T + stiff - (shapes / squares) @ shapes.T
    np.testing.assert_allclose(by_modes, direct, rtol=1e-6)


def test_an_unknown_symmetry_is_refused() -> None:
    with pytest.raises(ValueError, match="harmonic n = 2, sideways"):
        harmonic_modes(thick_ring(), 2, "sideways")
