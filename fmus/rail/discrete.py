"""The rail on discrete sleepers: `Track` and a position in the span in, point receptance and `Modes` out. No files.

Finite elements of a long piece of rail: rod, vertical and lateral Timoshenko beam, torsion with warping, on springs at
the sleepers. Towards both ends the rail's loss factor rises, so that waves leave and do not come back.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import Basis, BilinearForm, ElementLineHermite, ElementLinePp, MeshLine
from skfem.helpers import dd, grad

from ..errors import DataError
from ..modal.modes import Modes
from .fit import FIT_BAND_HZ, fit_modes
from .track import LAT, LON, SPIN, VER, support_stiffness, tilting_stiffness
from .track_data import Track

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Matrix = Any
"""A SciPy sparse matrix."""

_Part = tuple[Basis | None, float]
"""A field and its weight, or None and a number of unknowns."""

ELEMENTS_PER_SPAN = 6
"""Elements of 0.1 m, cubic: about 12 unknowns on the shortest wave at 5 kHz (0.35 m)."""

END_LOSS_FACTOR = 1.0
"""Loss factor that the ends' reaches at the last sleeper, growing with the square of the distance."""


@dataclass(frozen=True)
class DiscreteTrack:
    """A piece of track with a contact somewhere near its middle.

    Attributes
    ----------
    position : of the contact in the span [-]: 0 above a sleeper, 0.5 at mid-span
    spans, end_spans : number of sleeper spans in the clear and in each absorbing end
    smeared : whether the support is spread along the rail as in the analytical track
    """

    track: Track
    position: float = 0.5
    spans: int = 36
    end_spans: int = 14
    smeared: bool = False

    def __post_init__(self) -> None:
        """Check the ranges."""
        if not 0 <= self.position <= 1:
            raise DataError(f"discrete track: position = {self.position:g}; must be from 0 to 1 of the span")
        if self.spans < 2 or self.end_spans < 1:
            raise DataError(f"discrete track: {self.spans} + 2 x {self.end_spans} spans; must be at least 2 + 2 x 1")
        if self.track.contact_offset:
            raise DataError(f"discrete track: contact_offset = {self.track.contact_offset:g} m; must be 0")

    @property
    def sleepers(self) -> Real:
        """Positions of the sleepers [m], the middle one at 0."""
        half = self.spans // 2 + self.end_spans
        return np.arange(-half, half + 1, dtype=float) * self.track.spacing

    @property
    def contact(self) -> float:
        """Position of the contact [m]."""
        return self.position * self.track.spacing

    @cached_property
    def beams(self) -> _Beams:
        """The assembled matrices."""
        return _assemble(self)


def discrete_receptance(omega: ArrayLike, model: DiscreteTrack) -> Complex:
    """Return displacement per unit force at the contact, (m, 4, 4), laid out as `fmus.modal.receptance`.

    Notes
    -----
    Off the planes of symmetry (above a sleeper, mid-span) a lateral force also turns the rail: the lateral-spin term is
    there, and left out by the modal fit.
    """
    w = np.atleast_1d(np.asarray(omega, dtype=float))
    if w.ndim != 1 or not np.isfinite(w).all() or (w <= 0).any():
        raise DataError("discrete_receptance: angular frequencies must be finite and > 0")
    alpha = np.zeros((w.size, 4, 4), dtype=complex)
    for directions, stiffness, mass, loads, feet in model.beams.systems:
        supports = [_springs(w, model, direction) for direction, _ in feet]
        for i, frequency in enumerate(w):
            K = stiffness - frequency**2 * mass
            for (_, foot), spring in zip(feet, supports, strict=True):
                K = K + spring[i] * foot
            shapes = splu(K.tocsc()).solve(loads.astype(complex))
            alpha[np.ix_([i], directions, directions)] = loads.T @ shapes
    return alpha


def discrete_modes(model: DiscreteTrack, most_modes: int = 16) -> Modes:
    """Return a passive modal rail of the discrete track, at most `most_modes` in each direction.

    Notes
    -----
    Losses differ from part to part and are hysteretic, so that the damping is not proportional: the undamped modes do
    not decouple the equations, and the damped ones are not of the contract's form. So the receptance at the contact is
    computed exactly and modes are fitted to it, as for the analytical track; near 1 kHz the frequencies are closer, for
    the sake of the pinned-pinned resonance.
    """
    f = np.union1d(np.geomspace(*FIT_BAND_HZ, 150), np.geomspace(700.0, 1500.0, 60))
    omega = 2 * np.pi * f
    return fit_modes(omega, discrete_receptance(omega, model), most_modes)


@dataclass(frozen=True)
class _Beams:
    """Uncoupled systems: directions, stiffness, mass, contact vectors (columns) and the springs' matrices."""

    systems: tuple[tuple[list[int], Matrix, Matrix, Real, list[tuple[str, Matrix]]], ...]


@dataclass(frozen=True)
class _Line:
    """Integrals over the rail of products of shape functions; `stiff` ones with the factor 1 + j eta(x)."""

    slope_slope: Matrix
    slope_value: Matrix
    value_value_stiff: Matrix
    value_value: Matrix


def _assemble(model: DiscreteTrack) -> _Beams:
    """Return the matrices of rod, vertical beam and lateral beam with torsion."""
    track, rail = model.track, model.track.section
    basis, twist = _bases(model)
    line = _line(basis, model)
    contact, contact_twist = (b.probes(np.array([[model.contact]])).T.toarray() for b in (basis, twist))
    none = np.zeros_like(contact)
    rod = (
        [LON], rail.young_modulus * rail.area * line.slope_slope, rail.mass_per_length * line.value_value, contact,
        [("lon", _feet(model, [(basis, 1.0)])), ("end", _at(model.sleepers[[0, -1]], [(basis, 1.0)]))],
    )  # fmt: skip
    K_ver, M_ver = _timoshenko(line, model, "ver")
    ver = ([VER], K_ver, M_ver, np.vstack([contact, none]), [("ver", _feet(model, [(basis, 1.0), (None, basis.N)]))])
    turning = track.lateral_model == "torsion"
    depth, height = (rail.foot_depth, rail.head_height) if turning else (0.0, 0.0)
    K_lat, M_lat = _timoshenko(line, model, "lat")
    K_twist, M_twist = _torsion(twist, model)
    foot = _feet(model, [(basis, 1.0), (None, basis.N), (twist, -depth)])
    tilt = _feet(model, [(None, 2 * basis.N), (twist, 1.0)])
    loads = np.block([[contact, none], [none, contact], [height * contact_twist, np.zeros_like(contact_twist)]])
    lat = (
        [LAT, SPIN], sparse.block_diag([K_lat, K_twist]), sparse.block_diag([M_lat, M_twist]), loads,
        [("lat", foot), ("tilt", tilt)],
    )  # fmt: skip
    return _Beams((rod, ver, lat))


def _bases(model: DiscreteTrack) -> tuple[Basis, Basis]:
    """Return cubic shape functions for displacements and C1 ones for torsion, on elements that end at sleepers."""
    sleepers = model.sleepers
    mesh = MeshLine(np.linspace(sleepers[0], sleepers[-1], (sleepers.size - 1) * ELEMENTS_PER_SPAN + 1))
    return Basis(mesh, ElementLinePp(3), intorder=8), Basis(mesh, ElementLineHermite(), intorder=8)


def _end_loss(x: Real, model: DiscreteTrack) -> Real:
    """Return the loss factor that the absorbing ends add to the rail's."""
    clear = model.spans // 2 * model.track.spacing
    share = np.clip((np.abs(x) - clear) / (model.end_spans * model.track.spacing), 0.0, 1.0)
    return END_LOSS_FACTOR * share**2


def _integral(form: Any, basis: Basis, model: DiscreteTrack | None, test: Basis | None = None) -> Matrix:
    """Return the integral of form(u, v), with the factor 1 + j eta(x) if a model is given."""
    plain = BilinearForm(lambda u, v, _: form(u, v)).assemble(basis, test or basis)
    if model is None:
        return plain
    ends = BilinearForm(lambda u, v, w: _end_loss(w.x[0], model) * form(u, v)).assemble(basis, test or basis)
    return (1 + 1j * model.track.section.loss_factor) * plain + 1j * ends


def _line(basis: Basis, model: DiscreteTrack) -> _Line:
    """Return the integrals that beams are made of."""
    return _Line(
        slope_slope=_integral(lambda u, v: grad(u)[0] * grad(v)[0], basis, model),
        slope_value=_integral(lambda u, v: u * grad(v)[0], basis, model),
        value_value_stiff=_integral(lambda u, v: u * v, basis, model),
        value_value=_integral(lambda u, v: u * v, basis, None),
    )


def _timoshenko(line: _Line, model: DiscreteTrack, direction: str) -> tuple[Matrix, Matrix]:
    """Return stiffness and mass of a Timoshenko beam, displacements before rotations."""
    rail = model.track.section
    bending = getattr(rail, f"bending_stiffness_{direction}")
    shear = getattr(rail, f"shear_coefficient_{direction}") * rail.shear_modulus * rail.area
    coupling = -shear * line.slope_value
    rotation = bending * line.slope_slope + shear * line.value_value_stiff
    K = sparse.bmat([[shear * line.slope_slope, coupling], [coupling.T, rotation]])
    inertia = rail.density * bending / rail.young_modulus
    return K, sparse.block_diag([rail.mass_per_length * line.value_value, inertia * line.value_value])


def _torsion(twist: Basis, model: DiscreteTrack) -> tuple[Matrix, Matrix]:
    """Return stiffness (St Venant and warping) and polar inertia of the rail in torsion."""
    rail = model.track.section
    venant = _integral(lambda u, v: grad(u)[0] * grad(v)[0], twist, model)
    warping = _integral(lambda u, v: dd(u)[0, 0] * dd(v)[0, 0], twist, model)
    K = rail.shear_modulus * rail.torsion_constant * venant + rail.young_modulus * rail.warping_constant * warping
    return K, rail.density * rail.polar_moment * _integral(lambda u, v: u * v, twist, None)


def _feet(model: DiscreteTrack, parts: list[_Part]) -> Matrix:
    """Return the matrix of unit springs under a foot whose displacement is a weighted sum of fields.

    Parameters
    ----------
    parts : list of (basis, weight), or (None, n) for n unknowns that do not move the foot
    """
    if model.smeared:
        return sparse.bmat([[_product(row, column) for column in parts] for row in parts]).tocsr()
    return _at(model.sleepers, parts)


def _at(x: Real, parts: list[_Part]) -> Matrix:
    """Return the matrix of unit springs at some places."""
    rows = sparse.hstack(
        [sparse.csr_matrix((x.size, int(s))) if b is None else s * b.probes(x[None, :]) for b, s in parts]
    )
    return (rows.T @ rows).tocsr()


def _product(row: _Part, column: _Part) -> Matrix:
    """Return the block of the smeared support that couples two fields."""
    (a, s), (b, t) = row, column
    if a is None or b is None:
        return sparse.csr_matrix((int(s) if a is None else a.N, int(t) if b is None else b.N))
    return s * t * _integral(lambda u, v: u * v, b, None, a)


def _springs(w: Real, model: DiscreteTrack, direction: str) -> Complex:
    """Return the dynamic stiffness of one sleeper's support, or of a unit length if smeared."""
    if direction == "end":
        return _beyond_the_end(w, model)
    share = 1.0 if model.smeared else model.track.spacing
    if direction == "tilt":
        return np.full(w.shape, tilting_stiffness(model.track) * share)
    return support_stiffness(w, getattr(model.track, direction), model.track) * share


def _beyond_the_end(w: Real, model: DiscreteTrack) -> Complex:
    """Return the longitudinal stiffness of the rail beyond an end: a rod on a smeared support, sqrt(E A (s - m w^2)).

    Notes
    -----
    Longitudinal waves are too long for absorbing ends: 17 m at 300 Hz in a free rail.
    """
    rail = model.track.section
    EA = rail.young_modulus * rail.area * (1 + 1j * (rail.loss_factor + END_LOSS_FACTOR))
    s = support_stiffness(w, model.track.lon, model.track)
    return np.asarray(EA * np.sqrt((s - rail.mass_per_length * w**2) / EA))
