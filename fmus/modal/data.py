"""Modal data files: TOML in, `Modes` out, and back without loss. No FMI, no physics.

A file has a `title`, a `source` and one `[[mode]]` table per mode: `label`, `frequency_hz`, `damping_ratio`, `shape`
with the directions that it moves (`lon`, `lat`, `ver` [kg^-1/2], `spin` [kg^-1/2/m]; missing ones are 0) and, where it
differs from the file's, its own `source`. A wheel's modes may all have `area_axial` and `area_radial`, the surface
integrals of the squared motion of one wheel [m2/kg]. The same modes always make the same text.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..data_file import read_settings
from ..errors import DataError
from ..interface import DIRECTIONS
from .modes import Modes

_FILE_KEYS = frozenset({"title", "source", "mode"})
AREAS = ("area_axial", "area_radial")
_MODE_KEYS = frozenset({"label", "source", "frequency_hz", "damping_ratio", "shape", *AREAS})
_LARGEST = {"frequency_hz": 1e6, "damping_ratio": 1e3, "shape": 1e6, "area": 1e3}
"""What the component's parameters accept."""


@dataclass(frozen=True)
class ModalData:
    """The modes of a structure with the words that belong to them.

    Attributes
    ----------
    title : what structure this is
    source : where its numbers come from
    modes : at least one mode
    areas : (n, 2) axial and radial radiating area of each mode [m2/kg], None where they are not known
    """

    title: str
    source: str
    modes: Modes
    areas: NDArray[np.float64] | None = None


def read_modal_data(path: Path) -> ModalData:
    """Return what a modal data file says.

    Raises
    ------
    DataError
        One sentence with file, mode, quantity, what was wanted and what came.
    """
    settings = read_settings(path)
    _refuse_unknown(settings, _FILE_KEYS, path.name)
    words = {key: _text(settings.get(key), key, path.name) for key in ("title", "source")}
    tables = settings.get("mode")
    if not isinstance(tables, list) or not tables or not all(isinstance(t, dict) for t in tables):
        raise DataError(f"{path.name}: [[mode]] must be given at least once; got {_shown(tables)}")
    rows = [_mode(table, f"{path.name}, mode {number}") for number, table in enumerate(tables, start=1)]
    modes = Modes(
        omega=np.array([2 * np.pi * row["frequency_hz"] for row in rows]),
        zeta=np.array([row["damping_ratio"] for row in rows]),
        shape=np.array([row["shape"] for row in rows]),
        labels=tuple(row["label"] for row in rows),
    )
    return ModalData(words["title"], words["source"], modes, _areas(rows, path.name))


def format_modal_data(data: ModalData) -> str:
    """Return the text of the modal data file; equal data make equal text.

    Notes
    -----
    Numbers are written with as many digits as reading them back exactly takes. A frequency is written as that decimal
    whose product with 2 pi is `omega`, or, for the few values of `omega` that no double can reach this way, nearest.
    """
    modes = data.modes
    if not len(modes):
        raise DataError(f"{data.title}: a modal data file needs at least one mode; got 0")
    parts = [f"title = {_quoted(data.title)}\nsource = {_quoted(data.source)}\n"]
    for i in range(len(modes)):
        moved = [f"{d} = {float(modes.shape[i, j])!r}" for j, d in enumerate(DIRECTIONS) if modes.shape[i, j] != 0]
        parts.append(
            "[[mode]]\n"
            f"label = {_quoted(modes.labels[i] if modes.labels else f'mode {i + 1}')}\n"
            f"frequency_hz = {_frequency_hz(float(modes.omega[i]))!r}\n"
            f"damping_ratio = {float(modes.zeta[i])!r}\n"
            f"shape = {{ {', '.join(moved)} }}\n" + _area_lines(data.areas, i)
        )
    return "\n".join(parts)


def write_modal_data(path: Path, data: ModalData) -> None:
    """Write the modal data file."""
    path.write_text(format_modal_data(data), encoding="utf-8", newline="\n")


def _mode(table: dict[str, Any], where: str) -> dict[str, Any]:
    """Return the checked values of one `[[mode]]` table."""
    label = table.get("label", "")
    if not isinstance(label, str):
        raise DataError(f"{where}: label must be a text; got {_shown(label)}")
    if label:
        where = f"{where} ({label})"
    _refuse_unknown(table, _MODE_KEYS, where)
    if "source" in table:
        _text(table["source"], "source", where)
    row: dict[str, Any] = {"label": label}
    for key in ("frequency_hz", "damping_ratio"):
        row[key] = _number(table.get(key), key, where, lowest=0.0, largest=_LARGEST[key])
    shape = table.get("shape")
    if not isinstance(shape, dict):
        raise DataError(f"{where}: shape must be a table of directions; got {_shown(shape)}")
    _refuse_unknown(shape, frozenset(DIRECTIONS), f"{where}, shape")
    bound = _LARGEST["shape"]
    areas = [_number(table[key], key, where, 0.0, _LARGEST["area"]) for key in AREAS if key in table]
    if len(areas) == 1:
        raise DataError(f"{where}: has one of {' and '.join(AREAS)}; must be both or none")
    row["areas"] = areas or None
    row["shape"] = [_number(shape.get(d, 0.0), f"shape {d}", where, lowest=-bound, largest=bound) for d in DIRECTIONS]
    return row


def _area_lines(areas: NDArray[np.float64] | None, mode: int) -> str:
    return "" if areas is None else "".join(f"{k} = {float(a)!r}\n" for k, a in zip(AREAS, areas[mode], strict=True))


def _areas(rows: list[dict[str, Any]], where: str) -> NDArray[np.float64] | None:
    """Return the areas of all modes, None without any; those of some modes alone are refused."""
    known = [row["areas"] is not None for row in rows]
    if not any(known):
        return None
    if not all(known):
        raise DataError(f"{where}, mode {known.index(False) + 1}: has no {' and '.join(AREAS)}; others have them")
    return np.array([row["areas"] for row in rows])


def _number(value: Any, quantity: str, where: str, lowest: float, largest: float) -> float:
    """Return `value` as a float if it is a number in the range."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        number = float(value)
        if math.isfinite(number) and lowest <= number <= largest:
            return number
    raise DataError(f"{where}: {quantity} must be a number from {lowest:g} to {largest:g}; got {_shown(value)}")


def _text(value: Any, quantity: str, where: str) -> str:
    """Return `value` if it is a text that says something."""
    if isinstance(value, str) and value.strip():
        return value
    raise DataError(f"{where}: {quantity} must be a text; got {_shown(value)}")


def _refuse_unknown(table: dict[str, Any], known: frozenset[str], where: str) -> None:
    """Raise for a key that the format does not have."""
    unknown = sorted(set(table) - known)
    if unknown:
        raise DataError(f"{where}: {unknown[0]!r} is unknown; must be one of {', '.join(sorted(known))}")


def _shown(value: Any) -> str:
    """Return a value as a message shows it."""
    return "nothing" if value is None else repr(value)


def _quoted(text: str) -> str:
    """Return a TOML basic string; its escapes are JSON's but for the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _frequency_hz(omega: float) -> float:
    """Return the double that 2 pi times comes nearest to `omega`, of several the shortest to write."""
    neighbours = [omega / (2 * math.pi)]
    for end in (0.0, math.inf):
        value = neighbours[0]
        for _ in range(3):
            value = math.nextafter(value, end)
            neighbours.append(value)
    return min(neighbours, key=lambda f: (abs(2 * math.pi * f - omega), len(repr(f)), f))
