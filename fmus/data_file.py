"""Data files that people write: TOML in, settings out, each number with its unit and where it comes from."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from .errors import DataError


def read_settings(path: Path) -> dict[str, Any]:
    """Return what a TOML file says.

    Raises
    ------
    DataError
        If it is none; the sentence names the file.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise DataError(f"{path.name}: not a TOML file: {error}") from None


def title_of(settings: dict[str, Any]) -> str:
    """Take the title out of settings and return it.

    Raises
    ------
    DataError
        If there is none.
    """
    title = settings.pop("title", None)
    if not isinstance(title, str) or not title.strip():
        raise DataError(f"title must be a text; got {title!r}")
    return title


def sourced_number(entry: Any, unit: str, where: str) -> float:
    """Return the number of a table `{ value = ..., unit = ..., source = ... }`.

    Parameters
    ----------
    unit : the one that it must be in; nothing is converted
    where : what the sentence of a fault calls it

    Raises
    ------
    DataError
        If a key is missing or another is there, the value is no number, the unit another, or the source empty.
    """
    if not isinstance(entry, dict) or set(entry) != {"value", "unit", "source"}:
        raise DataError(f"{where} must be {{ value = ..., unit = ..., source = ... }}; got {entry!r}")
    value, source = entry["value"], entry["source"]
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{where}: value must be a number; got {value!r}")
    if entry["unit"] != unit:
        raise DataError(f"{where}: unit must be {unit!r}; got {entry['unit']!r}")
    if not isinstance(source, str) or not source.strip():
        raise DataError(f"{where}: source must be a text; got {source!r}")
    return float(value)
