"""Wheelset modes from a table of finite-element results: files in, `Modes` in the contract's axes out.

The table has one row per mode of an axisymmetric wheelset, with amplitudes in cylindrical coordinates at the nominal
contact point: `u_r` outwards, `u_z` away from mid-axle, `u_theta`. A row with n >= 1 is a doublet: its cosine family
moves the contact laterally and vertically, its sine family longitudinally and in spin. `finite_elements.py` writes such
tables.

Optional columns `du_r_ds`, `du_z_ds`, `d2u_r_ds2`, `d2u_z_ds2` say how the amplitudes change along the tread, to the
field side: with them a wheelset can be read where a curve puts the contact.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data_file import read_settings
from ..errors import DataError
from ..modal.modes import Modes

DATA = Path(__file__).parent / "data"

COLUMNS = (
    "n", "symmetry", "frequency_hz", "u_r", "u_theta", "u_z", "du_theta_dz", "area_axial", "area_radial",
)  # fmt: skip


TREAD_COLUMNS = ("du_r_ds", "du_z_ds", "d2u_r_ds2", "d2u_z_ds2")

TREAD = 0.025
"""Distance from the nominal contact point within which amplitudes are parabolas [m]."""


@dataclass(frozen=True)
class Wheelset:
    """The modes of a wheelset and what sound radiation needs of them.

    Attributes
    ----------
    modes : the n modes in the contract's axes, doublets as two modes
    nodal_diameters : (n,) number of nodal diameters
    area_axial, area_radial : (n,) surface integrals of the squared axial and radial motion of one wheel [m2/kg]
    title : what wheelset this is
    slope, bend : (n, 4) first and second derivative of the shapes along the tread, by the length to the field side;
        None where they are not known
    """

    modes: Modes
    nodal_diameters: NDArray[np.int64]
    area_axial: NDArray[np.float64]
    area_radial: NDArray[np.float64]
    title: str
    slope: NDArray[np.float64] | None = None
    bend: NDArray[np.float64] | None = None

    def at(self, position: float) -> Modes:
        """Return the modes read beside the nominal contact point, `position` to the field side [m].

        Raises
        ------
        DataError
            Away from the nominal point, if the change along the tread is not known.
        """
        if position == 0.0:
            return self.modes
        if self.slope is None or self.bend is None:
            raise DataError(
                f"{self.title}: the contact is {1e3 * position:.1f} mm from the nominal point, and the table of modes "
                f"has no columns {', '.join(TREAD_COLUMNS)}, which say how the shapes change along the tread"
            )
        change = position * self.slope + 0.5 * position**2 * self.bend
        return replace(self.modes, shape=self.modes.shape + change)


def read_wheelset(path: Path) -> Wheelset:
    """Return the wheelset that a TOML file describes.

    Parameters
    ----------
    path : Path
        File such as `data/generic840.toml`: names the table of modes and gives damping, rigid-body treatment and
        imposed frequencies, each with its source.

    Raises
    ------
    DataError
        For a missing column, a value that is no number, or an imposed frequency whose mode is not in the table.
    """
    settings = read_settings(path)
    rows = _read_table(path.parent / settings["modes"])
    _impose(rows, settings, path)
    radius = settings["radius"]["value_m"]
    families = [(row, family) for row in rows for family in _families(row)]
    modes = Modes(
        omega=np.array([2 * np.pi * row["frequency_hz"] for row, _ in families]),
        zeta=np.array([row["damping_ratio"] for row, _ in families]),
        shape=np.array([contact_shape(row, family, radius) for row, family in families]),
        labels=tuple(f"{row['label']} {family}" for row, family in families),
    )
    return Wheelset(
        modes=modes,
        nodal_diameters=np.array([row["n"] for row, _ in families]),
        area_axial=np.array([row["area_axial"] for row, _ in families]),
        area_radial=np.array([row["area_radial"] for row, _ in families]),
        title=settings["title"],
        **_along_the_tread(families, radius),
    )


def contact_shape(row: dict[str, Any], family: str, radius: float) -> list[float]:
    """Return the shape at the contact point in lon, lat, ver, spin.

    Notes
    -----
    The contact point is the lowest point of the wheel (theta = 0), so upwards is -u_r; the lateral axis points to the
    gauge side, so it is -u_z. The sine family is the cosine family turned by a quarter of a period, here with the sign
    (-u_r sin, u_theta cos, -u_z sin); its rotation about the vertical, -1/2 (du_z/(r dtheta) - du_theta/dz), is
    1/2 (n u_z/R + du_theta/dz). A wheelset that yaws rigidly has it equal to its yaw; the difference in place of the
    sum would be a shear strain.
    """
    if family == "cosine":
        return [0.0, -row["u_z"], -row["u_r"], 0.0]
    return [row["u_theta"], 0.0, 0.0, 0.5 * (row["n"] * row["u_z"] / radius + row["du_theta_dz"])]


def _along_the_tread(families: list[tuple[dict[str, Any], str]], radius: float) -> dict[str, NDArray[np.float64]]:
    """Return first and second derivative of the shapes along the tread; nothing if the table has no columns of them.

    Of the rotation about the vertical what the axial derivative of u_theta changes is left out.
    """
    if any(c not in row for row, _ in families for c in TREAD_COLUMNS):
        return {}

    def shape(row: dict[str, Any], family: str, u_r: str, u_z: str, u_theta: float) -> list[float]:
        if family == "cosine":
            return [0.0, -row[u_z], -row[u_r], 0.0]
        return [u_theta, 0.0, 0.0, 0.5 * row["n"] * row[u_z] / radius]

    return {
        "slope": np.array([shape(r, f, "du_r_ds", "du_z_ds", r["du_theta_dz"]) for r, f in families]),
        "bend": np.array([shape(r, f, "d2u_r_ds2", "d2u_z_ds2", 0.0) for r, f in families]),
    }


def _families(row: dict[str, Any]) -> tuple[str, ...]:
    """Return the families of a row: both for a doublet, else the one that moves."""
    if row["n"] > 0:
        return ("cosine", "sine")
    return ("sine",) if abs(row["u_theta"]) > abs(row["u_r"]) + abs(row["u_z"]) else ("cosine",)


def _read_table(path: Path) -> list[dict[str, Any]]:
    """Return the rows of the table with numbers converted and names checked."""
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        missing = set(COLUMNS) - set(reader.fieldnames or ())
        if missing:
            raise DataError(f"{path.name}: column {sorted(missing)[0]!r} is missing")
        columns = [c for c in (*COLUMNS, *TREAD_COLUMNS) if c != "symmetry" and c in (reader.fieldnames or ())]
        rows: list[dict[str, Any]] = []
        for line, text in enumerate(reader, start=2):
            try:
                row: dict[str, Any] = {c: float(text[c]) for c in columns}
            except (TypeError, ValueError) as error:
                raise DataError(f"{path.name}, line {line}: {error}") from None
            rows.append({**row, "n": int(row["n"]), "symmetry": text["symmetry"], "label": text.get("label") or ""})
    return rows


def _impose(rows: list[dict[str, Any]], settings: dict[str, Any], path: Path) -> None:
    """Add damping, labels, rigid-body values and imposed frequencies to the rows."""
    damping = settings["damping_ratio"]["n"]
    rigid = settings["rigid_body"]
    imposed = {(i["n"], i["symmetry"], i["order"]): i for i in settings.get("imposed", [])}
    order: dict[tuple[int, str], int] = {}
    for row in rows:
        key = (row["n"], row["symmetry"])
        row["damping_ratio"] = damping[min(row["n"], len(damping) - 1)]
        if row["frequency_hz"] < rigid["below_hz"]:
            row.update(frequency_hz=rigid["frequency_hz"], damping_ratio=rigid["damping_ratio"])
            row["label"] = f"rigid n={row['n']} {row['symmetry']}"
            continue
        order[key] = order.get(key, 0) + 1
        name = row["label"] if row["label"].startswith("(") else f"{row['label']} n={row['n']}".strip()
        row["label"] = f"{name} {row['symmetry']} #{order[key]}"
        found = imposed.pop((*key, order[key]), None)
        if found:
            row.update(frequency_hz=found["frequency_hz"], label=found["label"])
    if imposed:
        n, symmetry, number = next(iter(imposed))
        raise DataError(f"{path.name}: no mode n = {n}, {symmetry}, number {number} to impose a frequency on")
