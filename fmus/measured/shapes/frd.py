"""Eigenmodes in CalculiX results (.frd, text): mass-normalised shapes and coordinates in SI out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...errors import DataError
from ..function import Real
from ..tables import read_text
from ..units import UnitSystem
from .nodal import NodalModes
from .raw import RawMode, in_si, needed

_NODES, _RESULTS = "    2C", "  100C"


def is_frd(head: bytes) -> bool:
    """Return whether a file that begins so is one of CalculiX' results."""
    return head.startswith(b"    1C") or head.startswith(b"    1U")


def read_frd(path: Path, units: UnitSystem | None) -> NodalModes:
    """Return the eigenmodes of a file.

    Parameters
    ----------
    units : what the deck was written in; the file does not say it

    Raises
    ------
    DataError
        For a file without modes, in a binary form, or cut off, with its line.
    """
    system = needed(path.name, units)
    reader = _Reader(path.name)
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        reader.take(line, number)
    if reader.block or not reader.ended:
        inside = f"within a block of {reader.block}" if reader.block else "without the line 9999"
        raise DataError(f"{path.name}: ends {inside}; the file is cut off")
    if not reader.modes:
        raise DataError(f"{path.name}: holds no eigenmodes with displacements (*FREQUENCY, *NODE FILE with U)")
    return in_si(path.name, reader.modes, reader.position, system)


class _Reader:
    """What has been read of a file, line by line.

    Attributes
    ----------
    position : coordinates by node
    modes : whose displacements are those that are read last
    block : what the lines with values belong to, '' where they are passed over
    ended : whether the last line of a file has been seen
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.position: dict[int, Real] = {}
        self.modes: list[RawMode] = []
        self.block = ""
        self.ended = False
        self._mass = 1.0
        self._values: dict[int, Real] = {}
        self._frequency_hz = 0.0

    def take(self, line: str, number: int) -> None:
        """Take the next line."""
        where = f"{self.name}, line {number}"
        if line.startswith(" -1"):
            if self.block in {"nodes", "displacements"}:
                node, values = _values(line, where)
                (self.position if self.block == "nodes" else self._values)[node] = values
        elif line.rstrip() == " 9999":
            self.ended = True
        elif line.startswith(" -3"):
            self.block = ""
        elif line.startswith(" -4"):
            wanted = self.block == "results" and line[5:13].strip() == "DISP"
            self.block = "displacements" if wanted else ""
            if wanted:
                self._values = {}
                self.modes.append(RawMode(self._frequency_hz, self._mass, self._values, where=where))
        elif line.startswith("    1PGM"):
            self._mass = _real(line[8:].split()[:1], where, "generalised mass")
        elif line.startswith(_NODES):
            self.block = _ascii("nodes", line, where)
        elif line.startswith(_RESULTS):
            self.block = _ascii("results" if "MODAL" in line[58:] else "", line, where)
            self._frequency_hz = _real([line[12:24]], where, "frequency")


def _real(texts: list[str], where: str, what: str) -> float:
    """Return the number of a text, of which there must be one."""
    try:
        return float(*texts) if texts else float("none")
    except ValueError:
        raise DataError(f"{where}: the {what} must be a number; got {' '.join(texts) or 'nothing'!r}") from None


def _ascii(block: str, line: str, where: str) -> str:
    """Return the name of a block whose format, the last number of its line, is text."""
    if line.rstrip()[-1:] in {"2", "3"}:
        raise DataError(f"{where}: the block is binary; write the results as text (*NODE FILE, not OUTPUT=BINARY)")
    return block


def _values(line: str, where: str) -> tuple[int, Real]:
    """Return node and three values of a line, of either width of node numbers."""
    start = 13 if len(line.rstrip()) >= 13 + 36 - 1 else 8
    try:
        return int(line[3:start]), np.array([float(line[start + 12 * i : start + 12 * (i + 1)]) for i in range(3)])
    except ValueError:
        raise DataError(f"{where}: must be a node and three numbers; got {line.strip()!r}") from None
