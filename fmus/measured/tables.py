"""Measured functions in tables: CSV and NumPy archives in, functions with named directions out.

CSV has a column `frequency_hz` and, for a point function in direction d, `d_real` and `d_imag`; for motion in d due to
a force in e, `d_e_real` and `d_e_imag`; `d_coherence` if there is one. A header may end with a unit in brackets, such
as `ver_real [mm/s/N]`; without one the format's unit is SI. Separators are comma, semicolon or tab, the decimal sign of
the latter two point or comma; a byte order mark is passed over. Archives have the same names, with complex arrays.
"""

from __future__ import annotations

import csv
import re
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ..errors import DataError
from ..interface import DIRECTIONS
from .function import Complex, Contents, Function, Place, Real
from .units import frequency_factor

_SEPARATORS = (";", "\t", ",")
_COLUMN = re.compile(rf"({'|'.join(DIRECTIONS)})(?:_({'|'.join(DIRECTIONS)}))?_(real|imag|coherence)")
_FREQUENCY = re.compile(r"(?:frequency|freq|f)(?:_(k?hz))?")


class Header(NamedTuple):
    """A column's name and unit, and the line that says them."""

    name: str
    unit: str
    line: int = 1


def read_text(path: Path) -> str:
    """Return the text of a file, with or without a byte order mark.

    Raises
    ------
    DataError
        If it is no text.
    """
    data = path.read_bytes()
    encodings = ("utf-16",) if data[:2] in (b"\xff\xfe", b"\xfe\xff") else ("utf-8-sig", "cp1252")
    for encoding in encodings:
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if "\0" not in text:
            return text
    raise DataError(f"{path.name}: neither text nor one of the binary formats that are read")


def read_csv_rows(path: Path) -> tuple[list[Header], list[tuple[int, list[str]]]]:
    """Return headers and rows (line number, texts) of a CSV file; numbers have a decimal point afterwards.

    Lines that are empty or begin with # are left out.
    """
    lines = [(i, line) for i, line in enumerate(read_text(path).splitlines(), start=1)]
    lines = [(i, line) for i, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise DataError(f"{path.name}: is empty")
    separator = next((s for s in _SEPARATORS if s in lines[0][1]), ",")
    rows = [(i, next(csv.reader([line], delimiter=separator))) for i, line in lines]
    if separator != ",":  # then a comma within a number is its decimal sign
        rows = [(i, [re.sub(r"^(\s*[-+]?\d*),(\d)", r"\1.\2", text) for text in row]) for i, row in rows]
    return [_header(text, rows[0][0]) for text in rows[0][1]], rows[1:]


def read_csv(path: Path) -> Contents:
    """Return the functions of a CSV file.

    Raises
    ------
    DataError
        For a column that is missing or a value that is no number, with its line.
    """
    headers, rows = read_csv_rows(path)
    names, head = [header.name for header in headers], f"{path.name}, line {headers[0].line}"
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise DataError(f"{head}: two columns {twice!r}; must be one")
    frequency = next((h for h in headers if _FREQUENCY.fullmatch(h.name)), None)
    if frequency is None:
        raise DataError(f"{head}: column 'frequency_hz' is missing; has {', '.join(names)}")
    table = _numbers(path, names, rows)
    used = {h.name: h.unit for h in headers}
    columns = {name: table[:, i] for i, name in enumerate(names)}
    frequency_hz = columns[frequency.name] * _hertz(path, frequency)
    pairs = dict.fromkeys(m.groups()[:2] for name in names if (m := _COLUMN.fullmatch(name)) and m[3] != "coherence")
    functions = []
    for response, force in pairs:
        stem = response if force is None else f"{response}_{force}"
        for part in ("real", "imag"):
            if f"{stem}_{part}" not in columns:
                raise DataError(f"{head}: column '{stem}_{part}' is missing; has {', '.join(names)}")
        units = {used[f"{stem}_{part}"] for part in ("real", "imag")}
        if len(units) > 1:
            raise DataError(f"{head}: {stem}_real is in {used[stem + '_real']!r}, {stem}_imag is not; must agree")
        values = columns[f"{stem}_real"] + 1j * columns[f"{stem}_imag"]
        function = _function(path, frequency_hz, values, (response, force or response), units.pop())
        functions.append(replace(function, lines=np.array([line for line, _ in rows])))
    return _contents(path, frequency_hz, functions, columns)


def read_archive(path: Path) -> Contents:
    """Return the functions of a NumPy archive (.npz); `quantity` and `units` in it are texts."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: np.asarray(archive[name]) for name in archive.files}
    except (ValueError, OSError, zipfile.BadZipFile, EOFError) as error:
        raise DataError(f"{path.name}: not a NumPy archive of plain arrays: {error}") from None
    if "frequency_hz" not in arrays:
        raise DataError(f"{path.name}: array 'frequency_hz' is missing; has {', '.join(arrays) or 'nothing'}")
    frequency_hz = arrays["frequency_hz"].astype(float)
    texts = {key: str(arrays[key]) for key in ("quantity", "units") if key in arrays}
    functions = []
    for name, values in arrays.items():
        match = _COLUMN.fullmatch(f"{name}_real")
        if match is None:
            continue
        if values.shape != frequency_hz.shape or not np.iscomplexobj(values):
            raise DataError(
                f"{path.name}: {name!r} is {values.dtype} {values.shape}; must be complex and as frequency_hz"
            )
        directions = (match[1], match[2] or match[1])
        functions.append(
            _function(path, frequency_hz, values, directions, texts.get("units", ""), texts.get("quantity"))
        )
    return _contents(path, frequency_hz, functions, arrays)


def _header(text: str, line: int) -> Header:
    """Return name and unit of a header such as 'ver_real [mm/s/N]'."""
    match = re.fullmatch(r"\s*([^\[\(]*?)\s*(?:[\[\(]\s*(.*?)\s*[\]\)])?\s*", text)
    name, unit = (match[1].lower().replace(" ", "_"), match[2] or "") if match else (text.strip(), "")
    return Header(name, unit, line)


def _hertz(path: Path, header: Header) -> float:
    """Return the factor of the frequency's unit, which its name or brackets give."""
    match = _FREQUENCY.fullmatch(header.name)
    unit = header.unit or {"hz": "Hz", "khz": "kHz"}.get((match[1] if match else None) or "", "")
    if not unit:
        raise DataError(
            f"{path.name}, line {header.line}: column {header.name!r} has no unit; must be frequency_hz or "
            "frequency [Hz]"
        )
    try:
        return frequency_factor(unit)
    except ValueError as error:
        raise DataError(f"{path.name}, line {header.line}: column {header.name!r}: {error}") from None


def _numbers(path: Path, names: list[str], rows: list[tuple[int, list[str]]]) -> Real:
    """Return the columns that are read as numbers, the others as 0; (rows, columns)."""
    used = [bool(_COLUMN.fullmatch(name) or _FREQUENCY.fullmatch(name)) for name in names]
    table = np.zeros((len(rows), len(names)))
    for k, (line, texts) in enumerate(rows):
        for i in np.flatnonzero(used):
            try:
                table[k, i] = float(texts[i])
            except (ValueError, IndexError):
                got = repr(texts[i]) if i < len(texts) else "nothing"
                raise DataError(f"{path.name}, line {line}: {names[i]} must be a number; got {got}") from None
    return table


def _function(
    path: Path, frequency_hz: Real, values: Complex, directions: tuple[str, str], unit: str, quantity: str | None = None
) -> Function:
    response, force = (Place(None, d) for d in directions)
    return Function(path.name, frequency_hz, values, response, force, quantity, (unit, ""))


def _contents(path: Path, frequency_hz: Real, functions: list[Function], arrays: dict[str, Real]) -> Contents:
    """Return the functions with the coherences that belong to them."""
    coherence = {}
    for f in functions:
        stem = str(f.response) if f.response == f.reference else f"{f.response}_{f.reference}"
        if f"{stem}_coherence" in arrays:
            coherence[f.response, f.reference] = (frequency_hz, arrays[f"{stem}_coherence"].astype(float))
    listing = tuple(f"{f.response} due to {f.reference}" for f in functions) or tuple(arrays)
    return Contents(path, tuple(functions), coherence, None, listing, si=True)
