"""What is read off a shape on the mesh: motion of the contact point, radiating areas, energies, nodal circles.

Linear and quadratic forms are matrices on the unknowns of `harmonics.Body`; they carry no factor of the angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix
from skfem import Basis, BilinearForm

from .harmonics import AXIAL, RADIAL, Body, make_body
from .mesh import SectionMesh

Real = NDArray[np.float64]

_ON_THE_TREAD = 1e-7
"""Distance from the running profile within which an unknown belongs to it [m]."""

TREAD = 0.025
"""Half the width of the tread that the change of amplitudes is read from [m]."""

_SMALL = 1e-3
"""Share of the largest u_z below which its sign does not count as that of a nodal circle's side."""


@dataclass(frozen=True)
class Observer:
    """Matrices that read shapes, for unknowns of one meshed wheelset.

    Attributes
    ----------
    value, slope : (3, unknowns) amplitudes and their axial derivatives at the contact point
    tread, tread_bend : (3, unknowns) first and second derivative of the amplitudes along the tread, by axial length
    axial, radial : (unknowns, unknowns) integrals of u_z^2 |n_z| and u_r^2 |n_r| over the wheel's section [m2 per pi]
    meridian : (points, unknowns) mean u_z across the web, from hub to rim
    body, axle : matrices of the whole and of the axle alone
    """

    value: csr_matrix
    slope: csr_matrix
    tread: csr_matrix
    tread_bend: csr_matrix
    axial: csr_matrix
    radial: csr_matrix
    meridian: csr_matrix
    body: Body
    axle: Body

    def axle_share(self, n: int, shape: Real) -> float:
        """Return the axle's share of the energy of an elastic mode, kinetic and elastic taken together."""
        kinetic, elastic = (
            float(shape @ (a @ shape)) / float(shape @ (b @ shape))
            for a, b in (
                (self.axle.mass_of(n), self.body.mass_of(n)),
                (self.axle.stiffness_of(n), self.body.stiffness_of(n)),
            )
        )
        return (kinetic + elastic) / 2

    def wheel_masses(self, shape: Real) -> tuple[float, float, float]:
        """Return the wheel's modal mass in radial, tangential and axial motion, without the factor of the angle."""
        wheel = self.body.mass - self.axle.mass
        parts = [np.where(self.body.component == c, shape, 0.0) for c in range(3)]
        radial, tangential, axial = (float(p @ (wheel @ p)) for p in parts)
        return radial, tangential, axial

    def nodal_circles(self, shape: Real) -> int:
        """Return how often u_z changes sign from the hub along the web to the contact point."""
        u_z = np.append(self.meridian @ shape, (self.value @ shape)[AXIAL])
        clear = u_z[np.abs(u_z) > _SMALL * np.abs(u_z).max()]
        return int(np.count_nonzero(clear[1:] * clear[:-1] < 0))


def observe(body: Body, cut: SectionMesh) -> Observer:
    """Return what reads shapes of the meshed wheelset.

    Notes
    -----
    The radiating surface is that of rim, web and hub; the axle is left out.
    """
    axle = np.setdiff1d(np.arange(cut.part.size), cut.wheel_elements)
    value, slope = _contact_rows(body, cut)
    return Observer(
        value, slope, *_tread_rows(body, cut), *_surface_forms(body, cut), _web_rows(body, cut),
        body, make_body(cut.mesh, cut.section.material, axle),
    )  # fmt: skip


def _surface_forms(body: Body, cut: SectionMesh) -> tuple[csr_matrix, csr_matrix]:
    """Return the integrals of u_z^2 |n_z| r and u_r^2 |n_r| r along the wheel's free surface.

    Along an edge of the outline n_z ds = dr and n_r ds = -dz, so that no normal is needed.
    """

    @BilinearForm
    def axial(u: Any, v: Any, w: Any) -> Real:
        return np.asarray(u[AXIAL] * v[AXIAL] * w.per_area[1] * w.x[1])

    @BilinearForm
    def radial(u: Any, v: Any, w: Any) -> Real:
        return np.asarray(u[RADIAL] * v[RADIAL] * w.per_area[0] * w.x[1])

    exposed = np.isin(cut.mesh.t2f, cut.mesh.boundary_facets()) & (cut.part != "axle")
    s, weights = np.polynomial.legendre.leggauss(4)
    s, weights = (s + 1) / 2, weights / 2
    totals = [csr_matrix((body.basis.N, body.basis.N)) for _ in range(2)]
    for edge, place in enumerate(([s, 0 * s], [0 * s + 1, s], [s, 0 * s + 1], [0 * s, s])):
        elements = np.flatnonzero(exposed[edge])
        if elements.size:
            basis = Basis(cut.mesh, body.basis.elem, elements=elements, quadrature=(np.array(place), weights))
            along = basis.mapping.DF(np.array(place), tind=elements)[:, edge % 2]
            per_area = np.abs(along) / np.abs(basis.mapping.detDF(np.array(place), tind=elements))
            totals = [
                t + form.assemble(basis, per_area=per_area) for t, form in zip(totals, (axial, radial), strict=True)
            ]
    return totals[0], totals[1]


def _contact_rows(body: Body, cut: SectionMesh) -> tuple[csr_matrix, csr_matrix]:
    """Return the matrices to amplitudes and axial derivatives at the contact point, means over elements."""
    point = np.array([cut.section.contact_position, cut.section.contact_radius])
    vertex = int(np.argmin(np.linalg.norm(cut.mesh.p - point[:, None], axis=0)))
    touching = np.flatnonzero((cut.mesh.t == vertex).any(axis=0))
    corners = np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]])
    basis = Basis(cut.mesh, body.basis.elem, elements=touching, quadrature=(corners, np.ones(4)))
    distance = np.linalg.norm(np.asarray(basis.global_coordinates()) - point[:, None, None], axis=0)
    value, slope = np.zeros((2, 3, body.basis.N))
    for dofs, (function,) in zip(basis.element_dofs, basis.basis, strict=True):
        for element, corner in enumerate(distance.argmin(axis=1)):
            value[:, dofs[element]] += np.asarray(function)[:, element, corner] / len(touching)
            slope[:, dofs[element]] += function.grad[:, 0, element, corner] / len(touching)
    return csr_matrix(value), csr_matrix(slope)


def _tread_rows(body: Body, cut: SectionMesh) -> tuple[csr_matrix, csr_matrix]:
    """Return the matrices to the first and second derivative along the tread, of the parabola that fits it best.

    The parabola goes through the contact point; the fit is over `TREAD` to either side.
    """
    z, r = body.basis.doflocs
    distance = z - cut.section.contact_position
    near = (np.abs(distance) < TREAD + _ON_THE_TREAD) & (r > cut.section.rim_inner_radius)
    near &= np.abs(r - cut.section.profile_radius(z)) < _ON_THE_TREAD
    first, second = np.zeros((2, 3, body.basis.N))
    for component in range(3):
        own = np.flatnonzero(near & (body.component == component))
        s = distance[own]
        contact = own[np.abs(s).argmin()]
        for rows, weights in zip((first, second), np.linalg.pinv(np.column_stack([s, s**2 / 2])), strict=True):
            rows[component, own] = weights
            rows[component, contact] -= weights.sum()
    return csr_matrix(first), csr_matrix(second)


def _web_rows(body: Body, cut: SectionMesh) -> csr_matrix:
    """Return the matrix to the mean of u_z over each row of nodes of the web."""
    r = body.basis.doflocs[1]
    section = cut.section
    inside = (r > section.hub_radius - 1e-6) & (r < section.rim_inner_radius + 1e-6)
    unknowns = np.flatnonzero(inside & (body.component == AXIAL))
    _, row, count = np.unique(np.round(r[unknowns], 6), return_inverse=True, return_counts=True)
    return coo_matrix((1.0 / count[row], (row, unknowns)), (count.size, body.basis.N)).tocsr()
