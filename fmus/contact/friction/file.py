"""Friction curves in files: CSV in, parameter values of the contact out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from ...errors import DataError
from ...measured.tables import Header, read_csv_rows
from ...measured.units import velocity_factor
from ..friction_parameters import TABLE_POINTS
from .named import check_points, friction_table

_WORDS = {
    "creepage": re.compile(r"creepage|creep|gamma|slip_ratio"),
    "velocity": re.compile(r"(?:sliding_)?velocity|(?:sliding_|slip_)?speed|slip_velocity"),
    "friction": re.compile(r"friction(?:_coefficient)?|mu|cof"),
}
_CREEPAGE_UNITS = {"": 1.0, "-": 1.0, "1": 1.0, "%": 0.01}


def read_friction(path: Path) -> dict[str, float]:
    """Return the parameter values of a contact whose friction a file has.

    The file has a header and two columns: `creepage` (its unit `-` or `%` in brackets, without one `-`) or `velocity`
    with its unit in brackets, such as `velocity [mm/s]`; and `friction`. Others are passed over.

    Raises
    ------
    DataError
        For a column or unit that is missing, and for points that make no table, with their line.
    """
    headers, rows = read_csv_rows(path)
    over, column = _column(path, headers, ("creepage", "velocity"))
    _, friction = _column(path, headers, ("friction",))
    factor = _factor(path, over, headers[column])
    if headers[friction].unit not in {"", "-", "1"}:
        raise DataError(
            f"{path.name}, line {headers[friction].line}: friction is in {headers[friction].unit!r}; must be a ratio "
            "of forces, without unit"
        )
    places = [f"{path.name}, line {line}" for line, _ in rows]
    x, y = (np.array([_number(p, r, i) for p, (_, r) in zip(places, rows, strict=True)]) for i in (column, friction))
    if not 2 <= x.size <= TABLE_POINTS:
        raise DataError(f"{path.name}: must have 2 to {TABLE_POINTS} points; has {x.size}")
    check_points(factor * x, y, over, places)
    return friction_table(factor * x, y, over)


def _column(path: Path, headers: list[Header], wanted: tuple[str, ...]) -> tuple[str, int]:
    """Return which of the wanted quantities a file has, and its column."""
    found = [(word, i) for word in wanted for i, h in enumerate(headers) if _WORDS[word].fullmatch(h.name)]
    if len(found) != 1:
        has = ", ".join(h.name or "nothing" for h in headers)
        raise DataError(f"{path.name}, line {headers[0].line}: must have one column {' or '.join(wanted)}; has {has}")
    return found[0]


def _factor(path: Path, over: str, header: Header) -> float:
    """Return what the abscissa is multiplied with to be a ratio or in m/s."""
    if over == "creepage":
        if header.unit not in _CREEPAGE_UNITS:
            raise DataError(f"{path.name}, line {header.line}: creepage is in {header.unit!r}; must be in - or %")
        return _CREEPAGE_UNITS[header.unit]
    if not header.unit:
        raise DataError(
            f"{path.name}, line {header.line}: {header.name} has no unit; must be one such as {header.name} [m/s]"
        )
    try:
        return velocity_factor(header.unit)
    except DataError as error:
        raise DataError(f"{path.name}, line {header.line}: {header.name}: {error}") from None


def _number(place: str, row: list[str], column: int) -> float:
    """Return a number of a row."""
    try:
        return float(row[column])
    except (ValueError, IndexError):
        got = repr(row[column]) if column < len(row) else "nothing"
        raise DataError(f"{place}: must have a number in column {column + 1}; got {got}") from None
