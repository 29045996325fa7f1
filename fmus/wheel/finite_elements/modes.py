"""Modes of a wheelset by finite elements: cross-section in, table of modes at the contact point out.

`python -m fmus.wheel.finite_elements` makes the tables in `data/` again; with names of cross-section files it makes
theirs. Half a wheelset is meshed and solved with both conditions at mid-axle.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..wheelset import DATA
from .harmonics import AXIAL, RADIAL, TANGENTIAL, Body, harmonic_modes, make_body
from .mesh import mesh_section
from .observation import Observer, observe
from .section import Section, read_section

Real = NDArray[np.float64]

HARMONICS = tuple(range(9))
BELOW_HZ = 6500.0
REFINEMENT = 2
SHIPPED = ("generic840", "straight840")

_DIGITS = 6
_NOISE = 1e-7
"""Amplitudes below this share of the row's largest are numerical noise and are written as 0."""

_MINOR = 0.1
"""Share of the largest amplitude that u_z, then u_r, must have to decide the sign of a shape."""


@dataclass(frozen=True)
class WheelMode:
    """One row of a table of modes; a doublet has one row.

    Attributes
    ----------
    n : number of nodal diameters
    symmetry : 'symmetric' or 'antisymmetric' about mid-axle
    frequency_hz : natural frequency, 0 for rigid-body modes
    u_r, u_theta, u_z : shape at the contact point, outwards, tangential, away from mid-axle [kg^-1/2]
    du_theta_dz : axial derivative of u_theta there [kg^-1/2/m]
    area_axial, area_radial : surface integrals of u_z^2 and u_r^2 over one wheel, projected [m2/kg]
    du_r_ds, du_z_ds, d2u_r_ds2, d2u_z_ds2 : derivatives of u_r and u_z along the tread, by the length to the field side
        [kg^-1/2/m, kg^-1/2/m2]
    label : 'rigid', 'axle' or (n,m): m nodal circles, or r (radial), c (circumferential), t (torsion)
    """

    n: int
    symmetry: str
    frequency_hz: float
    u_r: float
    u_theta: float
    u_z: float
    du_theta_dz: float
    area_axial: float
    area_radial: float
    du_r_ds: float
    du_z_ds: float
    d2u_r_ds2: float
    d2u_z_ds2: float
    label: str


def wheelset_modes(
    section: Section, refinement: int = REFINEMENT, harmonics: Iterable[int] = HARMONICS, below_hz: float = BELOW_HZ
) -> list[WheelMode]:
    """Return the modes of a wheelset, ordered by n, symmetry and frequency.

    Parameters
    ----------
    section : Section
        Half the wheelset.
    refinement : int
        Fineness of the mesh, see `mesh_section`.
    harmonics : numbers of nodal diameters wanted
    below_hz : frequency up to which modes are wanted [Hz]

    Notes
    -----
    Shapes of n = 0 and 1 are mass-normalised over the complete wheelset: those of the half with 1/sqrt(2). From n = 2
    the axle hardly moves, symmetric and antisymmetric modes coincide, and the symmetric ones stand for both with shapes
    normalised over one wheel.
    """
    _, shapes = wheelset_shapes(section, refinement, harmonics, below_hz)
    return [mode for mode, _ in shapes]


def wheelset_shapes(
    section: Section, refinement: int = REFINEMENT, harmonics: Iterable[int] = HARMONICS, below_hz: float = BELOW_HZ
) -> tuple[Body, list[tuple[WheelMode, Real]]]:
    """Return the meshed body and its modes with their shapes on it; see `wheelset_modes`.

    The shapes are mass-normalised over half the wheelset, with any sign.
    """
    cut = mesh_section(section, refinement)
    body = make_body(cut.mesh, section.material)
    observer = observe(body, cut)
    return body, [
        found
        for n in harmonics
        for symmetry in (("symmetric", "antisymmetric") if n < 2 else ("symmetric",))
        for found in sorted(_modes(observer, n, symmetry, below_hz), key=lambda found: found[0].frequency_hz)
    ]


def _modes(observer: Observer, n: int, symmetry: str, below_hz: float) -> Iterator[tuple[WheelMode, Real]]:
    """Yield the modes of one harmonic and symmetry with their shapes."""
    for motion in ("axial", "torsion") if n == 0 else ("all",):
        found = harmonic_modes(observer.body, n, symmetry, below_hz, motion)
        for frequency, shape in zip(found.frequency_hz, found.vectors.T, strict=True):
            yield _mode(observer, n, symmetry, float(frequency), shape), shape


def _mode(observer: Observer, n: int, symmetry: str, frequency: float, shape: Real) -> WheelMode:
    """Return one row: what the observer reads off the shape, with its sign fixed."""
    u, tread, bend = (matrix @ shape for matrix in (observer.value, observer.tread, observer.tread_bend))
    angle = np.pi if n else 2 * np.pi
    share = 0.5 if n < 2 else 1.0
    factor = np.sqrt(share) * _sign(u)
    return WheelMode(
        n=n, symmetry=symmetry, frequency_hz=frequency,
        u_r=factor * u[RADIAL], u_theta=factor * u[TANGENTIAL], u_z=factor * u[AXIAL],
        du_theta_dz=factor * (observer.slope @ shape)[TANGENTIAL],
        du_r_ds=factor * tread[RADIAL], du_z_ds=factor * tread[AXIAL],
        d2u_r_ds2=factor * bend[RADIAL], d2u_z_ds2=factor * bend[AXIAL],
        area_axial=share * angle * float(shape @ (observer.axial @ shape)),
        area_radial=share * angle * float(shape @ (observer.radial @ shape)),
        label="rigid" if frequency == 0 else _label(observer, n, shape),
    )  # fmt: skip


def _sign(u: Real) -> float:
    """Return the sign that makes the shape's lateral, else radial, else tangential amplitude positive."""
    for component in (AXIAL, RADIAL):
        if abs(u[component]) > _MINOR * np.abs(u).max():
            return float(np.sign(u[component]))
    return float(np.sign(u[TANGENTIAL]))


def _label(observer: Observer, n: int, shape: Real) -> str:
    """Return the name of a mode from where its energy is and how the wheel moves."""
    if observer.axle_share(n, shape) > 0.5:
        return "axle"
    radial, tangential, axial = observer.wheel_masses(shape)
    if axial > radial + tangential:
        return f"({n},{observer.nodal_circles(shape)})"
    if radial > tangential:
        return f"({n},r)"
    return f"({n},{'c' if n else 't'})"


def write_table(path: Path, modes: Iterable[WheelMode]) -> None:
    """Write modes as a table that `read_wheelset` reads.

    Notes
    -----
    Six significant digits: more would differ between machines. Amplitudes below 1e-7 of the row's largest are noise
    of the eigenvalue solution and are written as 0.
    """
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([field.name for field in fields(WheelMode)])
        writer.writerows(_texts(mode) for mode in modes)


def _texts(mode: WheelMode) -> list[str]:
    """Return the texts of a row."""
    amplitude = max(abs(mode.u_r), abs(mode.u_theta), abs(mode.u_z))
    area = max(mode.area_axial, mode.area_radial)
    size = {"area_axial": area, "area_radial": area}  # fmt: skip
    texts = []
    for name, value in zip((field.name for field in fields(WheelMode)), astuple(mode), strict=True):
        if isinstance(value, float):
            texts.append(f"{value:.{_DIGITS}g}" if abs(value) > _NOISE * size.get(name, amplitude) else "0")
        else:
            texts.append(str(value))
    return texts


def make_table(section_path: Path) -> Path:
    """Write the table of modes of `NAME-section.toml` to `NAME.csv` beside it, and return its path."""
    path = section_path.with_name(section_path.stem.removesuffix("-section") + ".csv")
    write_table(path, wheelset_modes(read_section(section_path)))
    return path


def main(paths: Sequence[str]) -> None:
    """Make the tables of the given cross-sections, or of those in `data/`."""
    for path in [Path(p) for p in paths] or [DATA / f"{name}-section.toml" for name in SHIPPED]:
        sys.stdout.write(f"{make_table(path)}\n")
