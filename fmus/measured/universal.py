"""Universal files (UFF): data sets with their numbers and lines out; frequency responses, units and nodes out of them.

The library pyuff reads the data sets; this module finds their lines, so that a refusal can name them, and checks what
pyuff passes over: sets that are cut off, and numbers of values that are not what the header says.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyuff

from ..errors import DataError
from .function import Complex, Contents, Function, Place, Real
from .units import UnitSystem, frequency_factor

FUNCTION_TYPES = {
    0: "unknown function", 1: "time response", 2: "autospectrum", 3: "cross spectrum", 4: "frequency response",
    5: "transmissibility", 6: "coherence", 7: "autocorrelation", 8: "cross correlation", 9: "power spectral density",
    12: "spectrum", 18: "mode indicator", 25: "impulse response", 26: "multiple coherence",
}  # fmt: skip
_RESPONSE, _COHERENCE = 4, 6
_HEADER = 151

SET_NAMES = {
    15: "nodes", 2411: "nodes", 55: "data at nodes", 2414: "analysis data", 58: "function", 151: "header", 164: "units",
    82: "trace lines", 2412: "elements", 2420: "coordinate systems", 2467: "groups",
}  # fmt: skip

_TAG = re.compile(rb"^ {4}-1(?: {74,})?\r?$", re.MULTILINE)
_NUMERATOR = {8: "receptance", 11: "mobility", 12: "accelerance"}
_FORCE = (9, 13)
_FREQUENCY = 18

_CODES = {  # units in one metre and one newton
    1: (1.0, 1.0), 2: (3.28084, 0.224809), 3: (1.0, 0.101972), 4: (3.28084, 7.23301), 5: (1e3, 1e3), 6: (1e2, 1e2),
    7: (39.3701, 0.224809), 8: (1e3, 0.101972),
}  # fmt: skip
"""What the units codes of data set 164 mean; 9 is defined by the user."""


@dataclass(frozen=True)
class DataSet:
    """A data set of a universal file: its number in the file, first line, and content as pyuff gives it."""

    file: str
    number: int
    line: int
    content: dict[str, Any]

    @property
    def kind(self) -> int:
        """Return the number of the data set's format."""
        return int(self.content["type"])

    @property
    def where(self) -> str:
        """Return file, data set and line."""
        return f"{self.file}, data set {self.number} (line {self.line})"


def is_universal(head: bytes) -> bool:
    """Return whether a file that begins so is a universal file."""
    return re.match(rb"\s*^ {4}-1[ \r]*$", head, re.MULTILINE) is not None


def read_data_sets(path: Path, kinds: tuple[int, ...] | None = None) -> list[DataSet]:
    """Return the data sets of a universal file, others than `kinds` without content.

    Raises
    ------
    DataError
        For a data set that cannot be read, with its number and line.
    """
    lines = _first_lines(path)
    file = pyuff.UFF(str(path))
    types = [int(t) for t in file.get_set_types()]
    if not types or len(types) != len(lines):
        raise DataError(f"{path.name}: not a universal file: no data sets between lines with -1")
    found = []
    for i, (kind, line) in enumerate(zip(types, lines, strict=True)):
        content: dict[str, Any] = {"type": kind}
        if kinds is None or kind in kinds:
            try:
                content = file.read_sets(i)
            except Exception:
                if kind != _HEADER:  # words about the file: no number hangs on them
                    what = SET_NAMES.get(kind, "no known kind")
                    raise DataError(
                        f"{path.name}, data set {i + 1} (line {line}): is not a readable data set {kind} ({what})"
                    ) from None
        found.append(DataSet(path.name, i + 1, line, content))
    return found


def read_universal(path: Path) -> Contents:
    """Return the functions of a universal file."""
    functions, listing = [], []
    coherence: dict[tuple[Place, Place], tuple[Real, Real]] = {}
    sets = read_data_sets(path, (58, 151, 164))
    for data in sets:
        listing.append(f"data set {data.number} (line {data.line}): {_words(data)}")
        if data.kind != 58:
            continue
        kind, places = int(data.content["func_type"]), _places(data)
        if kind in (_RESPONSE, _COHERENCE):
            _check_size(data)
        if kind == _RESPONSE:
            functions.append(_function(data, places))
        elif kind == _COHERENCE:
            coherence[places] = (_frequencies(data), np.asarray(data.content["data"]).real)
    return Contents(path, tuple(functions), coherence, unit_system(sets), tuple(listing), origin=origin(sets))


def origin(sets: list[DataSet]) -> str:
    """Return what data set 151, the header, says of the file: model, description, program, date; '' without one."""
    content = next((data.content for data in sets if data.kind == _HEADER), {})
    keys = ("model_name", "description", "program", "date_file_written")
    return ", ".join(text for key in keys if (text := _label(content.get(key))))


def unit_system(sets: list[DataSet]) -> UnitSystem | None:
    """Return the units that data set 164 says, None where there is none.

    Raises
    ------
    DataError
        For factors that are not those of the units code, or two data sets that differ.
    """
    systems = []
    for data in (d for d in sets if d.kind == 164):
        code, length, force = (data.content[key] for key in ("units_code", "length", "force"))
        expected = _CODES.get(int(code))
        if not (length > 0 and force > 0):
            raise DataError(f"{data.where}: units with {length:g} per metre and {force:g} per newton; must be > 0")
        if expected and not np.allclose((length, force), expected, rtol=1e-3):
            raise DataError(
                f"{data.where}: units code {code} means {expected[0]:g} per metre and {expected[1]:g} per newton, the "
                f"factors are {length:g} and {force:g}; must agree"
            )
        systems.append(UnitSystem(length, force, f"data set 164 (line {data.line})"))
    if any(s.length != systems[0].length or s.force != systems[0].force for s in systems):
        places = " and ".join(system.source for system in systems)
        raise DataError(f"{sets[0].file}: {places} have different units; must agree")
    return systems[0] if systems else None


def _first_lines(path: Path) -> list[int]:
    """Return the line on which each data set begins; a file that ends within one is refused."""
    text = path.read_bytes()
    found: list[int] = []
    at = 0
    while (begin := _TAG.search(text, at)) is not None:
        line = text.count(b"\n", 0, begin.start()) + 1
        end = text.find(b"    -1", _data_end(text, begin.end()))
        if end < 0:
            raise DataError(
                f"{path.name}, data set {len(found) + 1} (line {line}): has no -1 at its end; the file is cut off"
            )
        found.append(line)
        at = end + 6
    return found


def _data_end(text: bytes, at: int) -> int:
    """Return where the end of a data set may be looked for: after the bytes of a binary one."""
    lines = text[at : at + 2000].splitlines(keepends=True)[:13]
    binary = re.match(rb"\s*58b\s+\d+\s+\d+\s+\d+\s+(\d+)", b"".join(lines[1:2]))
    return at if binary is None else at + sum(map(len, lines)) + int(binary[1])


def _places(data: DataSet) -> tuple[Place, Place]:
    c = data.content
    return Place(int(c["rsp_node"]), int(c["rsp_dir"])), Place(int(c["ref_node"]), int(c["ref_dir"]))


def _words(data: DataSet) -> str:
    """Return what a data set is, for listings."""
    if data.kind != 58:
        return SET_NAMES.get(data.kind, f"data set {data.kind}")
    kind = int(data.content["func_type"])
    response, reference = _places(data)
    return f"{FUNCTION_TYPES.get(kind, f'function of type {kind}')} at {response} due to {reference}"


def _check_size(data: DataSet) -> None:
    """Raise ValueError if the values are fewer than the header says or no numbers; a binary set may be padded."""
    c, said = data.content, int(data.content["num_pts"])
    values = np.asarray(c["data"])
    if values.size < said or (values.size > said and not c["binary"]):
        raise DataError(f"{data.where}: has {values.size} values; its header says {said}")
    bad = np.flatnonzero(~np.isfinite(values[:said]))
    if bad.size:
        raise DataError(f"{data.where}: value {bad[0] + 1} is {values[bad[0]]}; must be finite")


def _frequencies(data: DataSet) -> Real:
    """Return the abscissae in Hz."""
    c = data.content
    kind, label = int(c["abscissa_spec_data_type"] or 0), _label(c["abscissa_axis_units_lab"])
    x = np.asarray(c["x"], dtype=float)[: int(c["num_pts"])]
    if kind not in (0, _FREQUENCY):
        raise DataError(f"{data.where}: the abscissa is of data type {kind}; must be 18, frequency")
    try:
        return x * frequency_factor(label) if label else x
    except ValueError as error:
        raise DataError(f"{data.where}: abscissa: {error}") from None


def _function(data: DataSet, places: tuple[Place, Place]) -> Function:
    """Return a frequency response, as it stands in the file."""
    c = data.content
    frequency_hz = _frequencies(data)
    values: Complex = np.asarray(c["data"])[: frequency_hz.size]
    if not np.iscomplexobj(values):
        raise DataError(f"{data.where}: its values are real; a frequency response must be complex")
    denominator = int(c["orddenom_spec_data_type"] or 0)
    return Function(
        where=data.where,
        frequency_hz=frequency_hz,
        values=values,
        response=places[0],
        reference=places[1],
        quantity=_numerator(data),
        units=(_label(c["ordinate_axis_units_lab"]), _label(c["orddenom_axis_units_lab"])),
        force=None if denominator == 0 else denominator in _FORCE,
    )


def _numerator(data: DataSet) -> str | None:
    """Return the quantity by the numerator's data type; a type that is no motion is refused."""
    kind = int(data.content["ordinate_spec_data_type"] or 0)
    if kind in (0, 1):
        return None
    if kind not in _NUMERATOR:
        raise DataError(
            f"{data.where}: the numerator is of data type {kind}; must be 8, 11 or 12 (displacement, velocity, "
            "acceleration)"
        )
    return _NUMERATOR[kind]


def _label(text: Any) -> str:
    """Return a units label, '' for what the format writes where there is none."""
    label = str(text or "").strip()
    return "" if label.upper() in {"NONE", "UNKNOWN", "-"} else label
