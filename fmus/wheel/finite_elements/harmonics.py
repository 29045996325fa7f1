"""Vibration of elastic bodies of revolution, one Fourier harmonic at a time: mesh and material in, modes out.

A displacement with n nodal diameters is (u_r cos n theta, u_theta sin n theta, u_z cos n theta); its three amplitudes
are functions of the cross-section alone, so that a two-dimensional mesh in (z, r) carries the three-dimensional body.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.linalg import eigsh
from skfem import Basis, BilinearForm, ElementQuad2, ElementVector, MeshQuad2
from skfem.helpers import dot

from ...errors import DataError
from .section import Material

Real = NDArray[np.float64]
Index = NDArray[np.int64]

AXIAL, RADIAL, TANGENTIAL = 2, 0, 1
"""Places of u_z, u_r and u_theta among the components of a displacement."""

SYMMETRIES = ("symmetric", "antisymmetric", "free")
MOTIONS = {"all": (RADIAL, TANGENTIAL, AXIAL), "axial": (RADIAL, AXIAL), "torsion": (TANGENTIAL,)}

_ON_THE_LINE = 1e-9
_FIRST_GUESS = 12
_SHIFT_HZ = 100.0


@dataclass(frozen=True)
class Body:
    """The matrices of a body of revolution for all harmonics.

    Attributes
    ----------
    basis : second-order quadrilaterals with the three amplitudes as unknowns
    stiffness : K_0, K_1, K_2 of K = K_0 + n K_1 + n^2 K_2 [N/m], without the factor of the angle
    mass : M [kg], without it
    """

    basis: Basis
    stiffness: tuple[csr_matrix, csr_matrix, csr_matrix]
    mass: csr_matrix

    def stiffness_of(self, n: int) -> csr_matrix:
        """Return K of harmonic n, with the factor of the angle [N/m]."""
        return _angle(n) * (self.stiffness[0] + n * self.stiffness[1] + n * n * self.stiffness[2])

    def mass_of(self, n: int) -> csr_matrix:
        """Return M of harmonic n, with the factor of the angle [kg]."""
        return _angle(n) * self.mass

    @property
    def component(self) -> Index:
        """(unknowns,) which amplitude each unknown is of: RADIAL, TANGENTIAL or AXIAL."""
        component = np.zeros(self.basis.N, dtype=np.int64)
        for dofs in (self.basis.nodal_dofs, self.basis.facet_dofs, self.basis.interior_dofs):
            component[dofs] = np.arange(3)[:, None]
        return component


@dataclass(frozen=True)
class HarmonicModes:
    """Modes of one harmonic.

    Attributes
    ----------
    n : number of nodal diameters
    frequency_hz : (k,) natural frequencies, ascending; 0 for rigid-body modes
    vectors : (unknowns, k) shapes [kg^-1/2], mass-normalised over the body
    """

    n: int
    frequency_hz: Real
    vectors: Real


def make_body(mesh: MeshQuad2, material: Material, elements: Index | None = None) -> Body:
    """Return the matrices of the body whose cross-section is meshed, or those of some of its elements.

    Notes
    -----
    Strains of the amplitudes, in the order rr, theta theta, zz, r theta, theta z, rz: e = e_0 + n e_1 with
    e_0 = (u_r,r; u_r/r; u_z,z; u_theta,r - u_theta/r; u_theta,z; u_r,z + u_z,r) and
    e_1 = (0; u_theta/r; 0; -u_r/r; -u_z/r; 0). The integral over the angle gives pi, for n = 0 it gives 2 pi.
    """
    basis = Basis(mesh, ElementVector(ElementQuad2(), 3), intorder=5, elements=elements)
    D = elasticity_matrix(material)

    def energy(a: Any, b: Any, r: Real) -> Real:
        return np.asarray(np.einsum("i...,ij,j...->...", a, D, b) * r)

    @BilinearForm
    def k_0(u: Any, v: Any, w: Any) -> Real:
        return energy(_strain_0(v, w.x[1]), _strain_0(u, w.x[1]), w.x[1])

    @BilinearForm
    def k_1(u: Any, v: Any, w: Any) -> Real:
        r = w.x[1]
        return energy(_strain_0(v, r), _strain_1(u, r), r) + energy(_strain_1(v, r), _strain_0(u, r), r)

    @BilinearForm
    def k_2(u: Any, v: Any, w: Any) -> Real:
        return energy(_strain_1(v, w.x[1]), _strain_1(u, w.x[1]), w.x[1])

    @BilinearForm
    def mass(u: Any, v: Any, w: Any) -> Real:
        return np.asarray(material.density * dot(u, v) * w.x[1])

    return Body(basis, (k_0.assemble(basis), k_1.assemble(basis), k_2.assemble(basis)), mass.assemble(basis))


def elasticity_matrix(material: Material) -> Real:
    """Return the 6 x 6 matrix from strains (shear strains as angles) to stresses [Pa]."""
    E, nu = material.young_modulus, material.poisson_ratio
    shear = E / (2 * (1 + nu))
    D = np.diag([2 * shear] * 3 + [shear] * 3)
    D[:3, :3] += E * nu / ((1 + nu) * (1 - 2 * nu))
    return D


def harmonic_matrices(body: Body, n: int, symmetry: str, motion: str = "all") -> tuple[csr_matrix, ...]:
    """Return K and M of harmonic n on the free unknowns, and T from these to all unknowns.

    Parameters
    ----------
    n : number of nodal diameters, >= 0
    symmetry : {'symmetric', 'antisymmetric', 'free'}
        About the plane z = 0; 'free' leaves that plane unsupported.
    motion : {'all', 'axial', 'torsion'}
        For n = 0, whose torsion is independent of the rest.
    """
    if n < 0 or symmetry not in SYMMETRIES or (motion != "all" and n > 0):
        raise DataError(f"harmonic n = {n}, {symmetry}, {motion}; n must be >= 0, {SYMMETRIES}, parts for n = 0 only")
    T = _constraints(body, n, symmetry, motion)
    return (T.T @ body.stiffness_of(n) @ T).tocsc(), (T.T @ body.mass_of(n) @ T).tocsc(), T


def harmonic_modes(
    body: Body, n: int, symmetry: str = "free", below_hz: float = 6500.0, motion: str = "all"
) -> HarmonicModes:
    """Return all modes of harmonic n below a frequency; see `harmonic_matrices` for the parameters.

    Notes
    -----
    Shifted inverse Lanczos iteration from a fixed start vector, so that results repeat. More modes are asked for
    until one lies above `below_hz`. What comes out below 1 Hz is a rigid-body mode and is given frequency 0.
    """
    K, M, T = harmonic_matrices(body, n, symmetry, motion)
    count = _FIRST_GUESS
    while True:
        count = min(count, K.shape[0] - 1)
        squared, vectors = eigsh(
            K, count, M, sigma=-((2 * np.pi * _SHIFT_HZ) ** 2), v0=np.linspace(1.0, 2.0, K.shape[0])
        )
        frequency = np.sqrt(np.maximum(squared, 0)) / (2 * np.pi)
        if frequency.max() >= below_hz or count == K.shape[0] - 1:
            break
        count *= 2
    order = np.argsort(frequency)
    order = order[frequency[order] < below_hz]
    return HarmonicModes(n, np.where(frequency < 1.0, 0.0, frequency)[order], T @ vectors[:, order])


def _angle(n: int) -> float:
    """Return the integral of the squared harmonic over the angle."""
    return np.pi if n else 2 * np.pi


def _strain_0(u: Any, r: Real) -> Real:
    """Return the strains that do not depend on n."""
    (r_z, r_r), (t_z, t_r), (z_z, z_r) = u.grad
    return np.stack([r_r, u[0] / r, z_z, t_r - u[1] / r, t_z, r_z + z_r])


def _strain_1(u: Any, r: Real) -> Real:
    """Return the strains per n."""
    zero = np.zeros_like(u[0])
    return np.stack([zero, u[1] / r, zero, -u[0] / r, -u[2] / r, zero])


def _constraints(body: Body, n: int, symmetry: str, motion: str) -> csr_matrix:
    """Return T from the free unknowns to all: supports at z = 0, regularity on the axis, and the chosen motion.

    On the axis a displacement must not depend on theta: for n = 0 only u_z is left, for n = 1 only u_theta = -u_r,
    for n >= 2 nothing.
    """
    component = body.component
    z, r = body.basis.doflocs
    plane = np.abs(z) < _ON_THE_LINE
    axis = np.abs(r) < _ON_THE_LINE
    held = ~np.isin(component, MOTIONS[motion])
    if symmetry == "symmetric":
        held |= plane & (component == AXIAL)
    elif symmetry == "antisymmetric":
        held |= plane & (component != AXIAL)
    held |= axis & (component != AXIAL) if n == 0 else axis & (component == AXIAL if n == 1 else True)
    leader = np.arange(component.size)
    if n == 1:
        leader[axis & (component == TANGENTIAL)] = np.flatnonzero(axis & (component == RADIAL))
        if not (z[leader] == z).all():
            raise RuntimeError("unknowns on the axis are not in matching order")
    free = np.flatnonzero(~held & (leader == np.arange(component.size)))
    column = np.full(component.size, -1)
    column[free] = np.arange(free.size)
    rows = np.flatnonzero(~held)
    sign = np.where(leader[rows] == rows, 1.0, -1.0)
    return coo_matrix((sign, (rows, column[leader[rows]])), (component.size, free.size)).tocsr()
