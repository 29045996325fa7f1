"""Modal data from elsewhere: CSV, TOML or UFF in, `Modes` in the contract's axes out.

Nothing is guessed: units must be SI, shapes mass-normalised or with their modal mass, and the axes of a UFF file are
mapped by the caller. What is refused is refused in one sentence that names the file, the quantity and what was wanted.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from ..errors import DataError
from ..interface import DIRECTIONS
from ..modal.data import read_modal_data
from ..modal.modes import Modes

CSV_COLUMNS = ("label", "frequency_hz", "damping_ratio", *DIRECTIONS)

_UFF_AXES = ("x", "y", "z", "rx", "ry", "rz")
_NODAL_DATA, _UNITS = 55, 164
_NORMAL_MODE, _DISPLACEMENT, _SI = 2, 8, 1


@dataclass(frozen=True)
class UffAxes:
    """Where the directions of the contract are found in a UFF file.

    Attributes
    ----------
    node : number of the contact node
    lon, lat, ver : '+x', '-x', ... '-z', or 'none' for a direction in which the data have no motion
    spin : '+rx', '-rx', ... '-rz', or 'none'; the same axis as ver, with the same sign

    Examples
    --------
    A file with x along the track, y to the field side and z downwards, without rotations:

    >>> UffAxes(node=12, lon="+x", lat="-y", ver="-z", spin="none").column("lat")
    (-1.0, 'y')
    """

    node: int
    lon: str
    lat: str
    ver: str
    spin: str = field(default="none")

    def __post_init__(self) -> None:
        """Check that each direction has an axis of its own."""
        used: dict[str, str] = {}
        for direction in DIRECTIONS:
            allowed = _UFF_AXES[3:] if direction == "spin" else _UFF_AXES[:3]
            text = getattr(self, direction)
            if text == "none":
                continue
            if text[:1] not in {"+", "-"} or text[1:] not in allowed:
                raise DataError(
                    f"axes: {direction} = {text!r}; must be '+' or '-' and one of {', '.join(allowed)}, or 'none'"
                )
            other = used.setdefault(text[1:], direction)
            if other != direction:
                raise DataError(f"axes: {other} and {direction} are both {text[1:]!r}; must differ")

    def column(self, direction: str) -> tuple[float, str] | None:
        """Return the sign and the name of the axis of a direction, or None."""
        text = getattr(self, direction)
        return None if text == "none" else (-1.0 if text[0] == "-" else 1.0, text[1:])


def read_modes(path: Path, axes: UffAxes | None = None) -> Modes:
    """Return the modes of a file, by its suffix: `.csv`, `.toml`, or `.uff`, `.unv`, `.uf`.

    Parameters
    ----------
    path : Path
    axes : UffAxes, optional
        Needed for UFF, whose axes are anybody's; CSV and TOML are in the contract's axes.

    Raises
    ------
    DataError
        For another suffix, or what the reader of the format or `Modes` refuses.
    """
    suffix = path.suffix.lower()
    if suffix in {".uff", ".unv", ".uf"}:
        if axes is None:
            raise DataError(f"{path.name}: a UFF file needs the contact node and its axes")
        return read_uff(path, axes)
    if suffix == ".csv":
        return read_csv(path)
    if suffix == ".toml":
        return _checked(path.name, read_modal_data(path).modes, DIRECTIONS)
    raise DataError(f"{path.name}: suffix {suffix!r} is unknown; must be .csv, .toml, .uff, .unv or .uf")


def read_csv(path: Path) -> Modes:
    """Return the modes of a table with the columns `CSV_COLUMNS`, in the contract's axes and units.

    Raises
    ------
    DataError
        For a missing column, a value that is no number, and what every import refuses.
    """
    with path.open(encoding="utf-8", newline="") as file:
        reader = csv.DictReader(file)
        missing = [c for c in CSV_COLUMNS if c not in (reader.fieldnames or ())]
        if missing:
            raise DataError(f"{path.name}: column {missing[0]!r} is missing; wanted are {', '.join(CSV_COLUMNS)}")
        labels, rows = [], []
        for line, text in enumerate(reader, start=2):
            try:
                rows.append([float(text[c]) for c in CSV_COLUMNS[1:]])
            except (TypeError, ValueError):
                raise DataError(f"{path.name}, line {line}: every column but label must be a number") from None
            labels.append(text["label"])
    table = np.array(rows).reshape(-1, len(CSV_COLUMNS) - 1)
    return _make(path.name, table[:, 0], table[:, 1], table[:, 2:], labels, DIRECTIONS)


def read_uff(path: Path, axes: UffAxes) -> Modes:
    """Return the normal modes at one node of a UFF file.

    Notes
    -----
    Data sets 55 (data at nodes) of analysis type 2 are read, with data set 164 (units), which must say SI. Shapes are
    divided by the root of the modal mass. The damping ratio is the viscous one plus half the hysteretic one.
    """
    sets = _uff_sets(path)
    _check_units(path.name, [s for s in sets if s["type"] == _UNITS])
    modal = [s for s in sets if s["type"] == _NODAL_DATA]
    if not modal:
        raise DataError(f"{path.name}: there is no data set 55 in it")
    rows = [_uff_mode(f"{path.name}, mode {i}", data, axes) for i, data in enumerate(modal, start=1)]
    return _make(
        path.name,
        np.array([data["freq"] for data in modal]),
        np.array([data["modal_damp_vis"] + data["modal_damp_his"] / 2 for data in modal]),
        np.array(rows),
        [f"mode {data['mode_n']}" for data in modal],
        tuple(d for d in DIRECTIONS if axes.column(d)),
    )


def _uff_sets(path: Path) -> list[Mapping[str, Any]]:
    """Return the data sets 55 and 164 of a file."""
    if not path.is_file():
        raise FileNotFoundError(path)
    try:
        file = pyuff.UFF(str(path))
        wanted = np.flatnonzero(np.isin(file.get_set_types(), (_NODAL_DATA, _UNITS)))
        return [file.read_sets(int(i)) for i in wanted]
    except Exception as error:  # pyuff raises bare Exception
        raise DataError(f"{path.name}: not a readable UFF file: {error}") from error


def _check_units(name: str, sets: list[Mapping[str, Any]]) -> None:
    """Check that the file says that it is in SI."""
    if not sets:
        raise DataError(f"{name}: data set 164 (units) is missing; must say SI")
    for units in sets:
        factors = (units["length"], units["force"])
        if units["units_code"] != _SI or not np.allclose(factors, 1.0, rtol=1e-9, atol=0.0):
            raise DataError(
                f"{name}: units are code {units['units_code']} with {factors[0]:g} per metre and {factors[1]:g} per "
                "newton; must be SI, code 1 with 1 and 1"
            )


def _uff_mode(where: str, data: Mapping[str, Any], axes: UffAxes) -> list[float]:
    """Return the mass-normalised shape of one data set at the contact node."""
    if data["analysis_type"] != _NORMAL_MODE or np.iscomplexobj(data["r1"]):
        raise DataError(f"{where}: analysis type is {data['analysis_type']}; must be 2, a real normal mode")
    if data["spec_data_type"] != _DISPLACEMENT:
        raise DataError(f"{where}: data type is {data['spec_data_type']}; must be 8, displacement")
    if not data["modal_m"] > 0:
        raise DataError(f"{where}: modal mass is {data['modal_m']:g}; must be > 0")
    place = np.flatnonzero(np.asarray(data["node_nums"]) == axes.node)
    if not place.size:
        raise DataError(f"{where}: node {axes.node} is not in it")
    shape = []
    for direction in DIRECTIONS:
        column = axes.column(direction)
        if column is None:
            shape.append(0.0)
            continue
        sign, axis = column
        values = data.get(f"r{_UFF_AXES.index(axis) + 1}")
        if values is None:
            raise DataError(f"{where}: direction {direction} is missing: the data have no {axis!r}")
        shape.append(sign * float(values[place[0]]) / math.sqrt(data["modal_m"]))
    return shape


def _make(
    name: str, frequency_hz: Any, damping_ratio: Any, shape: Any, labels: list[str], wanted: tuple[str, ...]
) -> Modes:
    """Return checked modes; errors name the file."""
    if not len(labels):
        raise DataError(f"{name}: there are no modes in it")
    try:
        modes = Modes(2 * np.pi * frequency_hz, damping_ratio, shape, tuple(labels))
    except ValueError as error:
        raise DataError(f"{name}: {error}") from None
    return _checked(name, modes, wanted)


def _checked(name: str, modes: Modes, wanted: tuple[str, ...]) -> Modes:
    """Return the modes if their frequencies ascend and every wanted direction moves in one of them."""
    falls = np.flatnonzero(np.diff(modes.omega) < 0)
    if falls.size:
        first, second = modes.omega[falls[0] : falls[0] + 2] / (2 * np.pi)
        raise DataError(f"{name}: mode {falls[0] + 2} has {second:g} Hz after {first:g} Hz; must be in rising order")
    for j, direction in enumerate(DIRECTIONS):
        if direction in wanted and not modes.shape[:, j].any():
            raise DataError(f"{name}: direction {direction} is missing: no mode moves in it")
    return modes
