"""A wheel from modes of finite elements or a modal test: files or arrays in, `Modes` in the contract's axes out.

Files are read by `fmus.measured`. Nothing is guessed: units, axes and damping that a file does not say must be said.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import DataError
from ..interface import DIRECTIONS
from ..measured.shapes.nodal import ContactModes, Extent, at_contact, complete_axes
from ..measured.shapes.read import is_shapes, read_shapes
from ..measured.tables import read_csv_rows
from ..modal.data import AREAS, read_modal_data
from ..modal.modes import Modes

Real = NDArray[np.float64]

CSV_COLUMNS = ("label", "frequency_hz", "damping_ratio", *DIRECTIONS)

_SAME_DOUBLET = 1e-4


@dataclass(frozen=True)
class ModalChoice:
    """What a user says about files of mode shapes.

    Attributes
    ----------
    node : number of the contact's node
    axes : direction of each signed direction code: 1, 2, 3 are x, y, z
    units : units of length and force, 'mm,N', where the file does not say them
    damping : damping ratio by number of nodal diameters, the last for all above, where the file has none
    """

    node: int | None = None
    axes: Mapping[int, str] = field(default_factory=dict)
    units: str | None = None
    damping: tuple[float, ...] = ()


@dataclass(frozen=True)
class ImportedWheel:
    """A wheel from elsewhere.

    Attributes
    ----------
    modes : in the contract's axes
    notes : sentences on what was taken as what
    origin : what the files say about themselves, '' if nothing
    areas : (n, 2) axial and radial radiating area of each mode [m2/kg], None where they are not known
    """

    modes: Modes
    notes: tuple[str, ...] = ()
    origin: str = ""
    areas: Real | None = None


def wheel_from_modes(
    frequency_hz: ArrayLike, damping_ratio: ArrayLike, shape: ArrayLike, labels: Sequence[str] = ()
) -> Modes:
    """Return the modes of a wheel from arrays.

    Parameters
    ----------
    frequency_hz : (n,) array_like
        Natural frequencies in rising order, >= 0 [Hz].
    damping_ratio : (n,) array_like
        >= 0.
    shape : (n, 4) array_like
        Mass-normalised amplitudes at the contact: lon, lat, ver [kg^-1/2], spin [kg^-1/2/m].
    labels : n names, optional
        Such as '(3,0) cosine'.

    Examples
    --------
    >>> wheel_from_modes([417.1], [1e-4], [[0, -0.115, 0.001, 0]], ["(2,0)"]).labels
    ('(2,0)',)
    """
    table = np.asarray(shape, dtype=float)
    omega = 2 * np.pi * np.asarray(frequency_hz, dtype=float)
    modes = Modes(omega, np.asarray(damping_ratio, dtype=float), table.reshape(-1, 4), tuple(labels))
    return _rising("modes", modes)


def read_modes(files: Path | Sequence[Path], choice: ModalChoice | None = None) -> ImportedWheel:
    """Return the modes in CSV, TOML, universal files or results of CalculiX and Nastran.

    Several universal files or results are parts of one wheelset. TOML is the project's own format, which `wheel
    measured` writes, too: its modes may stand in any order, and directions in which none moves are rigid.

    Raises
    ------
    DataError
        For what cannot be read, or parts that do not make a whole: says which are missing.
    """
    chosen = choice or ModalChoice()
    paths = [files] if isinstance(files, Path) else list(files)
    heads = [_head(path) for path in paths]
    if len(paths) == 1 and not is_shapes(heads[0]):
        path = paths[0]
        if path.suffix.lower() == ".toml" or b"[[mode]]" in path.read_bytes():
            data = read_modal_data(path)
            rigid = [d for j, d in enumerate(DIRECTIONS) if not data.modes.shape[:, j].any()]
            notes = (f"no mode moves in {', '.join(rigid)}: the wheel is rigid there",) if rigid else ()
            return ImportedWheel(data.modes, notes, areas=data.areas)
        modes, areas = read_csv(path)
        return ImportedWheel(_complete(path.name, modes), areas=areas)
    parts = [_part(path, head, chosen) for path, head in zip(paths, heads, strict=True)]
    return _whole(paths, parts, chosen)


def read_csv(path: Path) -> tuple[Modes, Real | None]:
    """Return the modes of a table with the columns `CSV_COLUMNS`, in the contract's axes and units.

    With the columns `area_axial` and `area_radial` [m2/kg], also (n, 2) radiating areas.
    """
    headers, rows = read_csv_rows(path)
    names, head = [header.name for header in headers], f"{path.name}, line {headers[0].line}"
    missing = [c for c in CSV_COLUMNS if c not in names]
    if missing:
        raise DataError(f"{head}: column {missing[0]!r} is missing; wanted are {', '.join(CSV_COLUMNS)}")
    with_areas = [c for c in AREAS if c in names]
    if len(with_areas) == 1:
        raise DataError(f"{head}: has {with_areas[0]} alone; must be {' and '.join(AREAS)}, or none of them")
    numbers = [*CSV_COLUMNS[1:], *with_areas]
    table, labels = [], []
    for line, texts in rows:
        row = dict(zip(names, texts, strict=False))
        try:
            table.append([float(row[c]) for c in numbers])
        except (KeyError, ValueError):
            raise DataError(f"{path.name}, line {line}: every column but label must be a number; got {texts}") from None
        labels.append(row["label"])
    if not table:
        raise DataError(f"{path.name}: there are no modes in it")
    values = np.array(table)
    areas = values[:, 6:] if with_areas else None
    bad = np.flatnonzero(~((values[:, 6:] >= 0) & np.isfinite(values[:, 6:])).all(axis=1))
    if bad.size:
        raise DataError(f"{path.name}, line {rows[bad[0]][0]}: areas are {values[bad[0], 6:].tolist()}; must be >= 0")
    try:
        modes = _rising(path.name, _modes(path.name, values[:, 0], values[:, 1], values[:, 2:6], tuple(labels)))
    except DataError as error:  # which says the number of the mode
        number = re.search(r"mode (\d+)", str(error))
        place = f", line {rows[int(number[1]) - 1][0]}" if number else ""
        raise DataError(str(error).replace(path.name, f"{path.name}{place}", 1)) from None
    return modes, areas


def _head(path: Path) -> bytes:
    if not path.is_file():
        raise DataError(f"{path}: no such file")
    with path.open("rb") as file:
        return file.read(4096)


def _part(path: Path, head: bytes, choice: ModalChoice) -> ContactModes:
    """Return the modes of one file of shapes at the contact."""
    nodal = read_shapes(path, head, choice.units)
    return at_contact(nodal, choice.node, complete_axes(choice.axes, path.name))


def _whole(paths: Sequence[Path], parts: Sequence[ContactModes], choice: ModalChoice) -> ImportedWheel:
    """Return the modes of all parts by frequency; parts that are missing are named."""
    name = ", ".join(path.name for path in paths)
    missing = missing_parts([part.extent for part in parts])
    if missing:
        raise DataError(f"{name}: {missing}")
    frequency_hz = np.concatenate([part.frequency_hz for part in parts])
    order = np.argsort(frequency_hz, kind="stable")
    diameters = np.concatenate([part.diameters for part in parts])[order]
    zeta = _damped(name, np.concatenate([part.damping_ratio for part in parts])[order], diameters, choice.damping)
    labels = tuple(label for part in parts for label in labelled(part))
    shape = np.concatenate([part.shape for part in parts])[order]
    zeta = np.where(frequency_hz[order] == 0, 0.0, zeta)
    modes = _modes(name, frequency_hz[order], zeta, shape, tuple(labels[i] for i in order))
    notes = []
    if any(part.spin_from == "none" for part in parts):
        notes.append("spin is neither in the data nor told by nodes near the contact: the wheel is rigid in spin")
    if any(part.spin_from == "neighbours" for part in parts):
        notes.append("spin is the rotation of the nodes within 50 mm of the contact")
    origin = "; ".join(dict.fromkeys(part.origin for part in parts if part.origin))
    return ImportedWheel(_complete(name, modes, tuple(d for d in DIRECTIONS if d != "spin")), tuple(notes), origin)


def missing_parts(extents: Sequence[Extent]) -> str:
    """Return a sentence on the parts of a wheelset that are missing, '' if it is whole."""
    circles = {extent.circle for extent in extents}
    axles = {extent.axle for extent in extents}
    wanted = {(c, a) for c in _both(circles, ("cosine", "sine")) for a in _both(axles, ("symmetric", "antisymmetric"))}
    there = {(e.circle, e.axle) for e in extents}
    words = {
        "cosine": "motion across the plane of the half circle held (lat and ver)",
        "sine": "motion in the plane of the half circle held (direction lon is missing)",
        "symmetric": "motion along the axle held at mid-axle",
        "antisymmetric": "motion across the axle held at mid-axle",
    }
    missing = [" and ".join(words[part] for part in pair if part != "whole") for pair in sorted(wanted - there)]
    return f"is a part of a wheelset; give the other runs, too: {'; '.join(missing)}" if missing else ""


def _both(found: set[str], halves: tuple[str, str]) -> tuple[str, ...]:
    return halves if found & set(halves) else ("whole",)


def labelled(part: ContactModes) -> tuple[str, ...]:
    """Return labels by nodal diameters and kind: (n,0) for the first axial mode of n, else n and a count."""
    if (part.diameters < 0).all():
        return part.labels
    count: dict[tuple[int, str], int] = {}
    seen: dict[int, float] = {}
    labels = []
    for n, axial, frequency in zip(
        part.diameters.tolist(), part.axial.tolist(), part.frequency_hz.tolist(), strict=True
    ):
        words = " ".join(word for word in (part.extent.axle, part.extent.circle) if word != "whole")
        if frequency == 0:
            labels.append(f"rigid n={n} {words}".strip())
            continue
        if axial and n >= 2 and (n not in seen or abs(frequency / seen[n] - 1) < _SAME_DOUBLET):
            seen.setdefault(n, frequency)
            labels.append(f"({n},0) {words}".strip())
            continue
        key = (n, words)
        count[key] = count.get(key, 0) + 1
        labels.append(f"n={n} {words} #{count[key]}".replace("  ", " "))
    return tuple(labels)


def _damped(name: str, own: Real, diameters: NDArray[np.int64], given: tuple[float, ...]) -> Real:
    """Return the damping ratios of a file, or the given ones by number of nodal diameters."""
    bare = np.isnan(own)
    if not bare.any():
        return own
    if not given:
        raise DataError(
            f"{name}: has no damping; give it with the option damping: one ratio, or those of n = 0, 1, 2 ..."
        )
    if len(given) > 1 and (diameters[bare] < 0).any():
        raise DataError(f"{name}: the numbers of nodal diameters are not known; give one damping ratio for all modes")
    by_n = np.array([given[min(max(int(n), 0), len(given) - 1)] for n in diameters])
    return np.where(bare, by_n, own)


def _modes(name: str, frequency_hz: Real, zeta: Real, shape: Real, labels: tuple[str, ...]) -> Modes:
    """Return checked modes; errors name the file."""
    try:
        return Modes(2 * np.pi * frequency_hz, zeta, shape, labels)
    except ValueError as error:
        raise DataError(f"{name}: {error}") from None


def _rising(name: str, modes: Modes) -> Modes:
    """Return the modes if their frequencies ascend."""
    falls = np.flatnonzero(np.diff(modes.omega) < 0)
    if falls.size:
        first, second = modes.omega[falls[0] : falls[0] + 2] / (2 * np.pi)
        raise DataError(f"{name}: mode {falls[0] + 2} has {second:g} Hz after {first:g} Hz; must be in rising order")
    return modes


def _complete(name: str, modes: Modes, wanted: Sequence[str] = DIRECTIONS) -> Modes:
    """Return the modes if every wanted direction moves in one of them."""
    for j, direction in enumerate(DIRECTIONS):
        if direction in wanted and not modes.shape[:, j].any():
            raise DataError(f"{name}: direction {direction} is missing: no mode moves in it")
    return modes
