"""Table 4 of the paper beside ours: a wheel and a rail in, 32 cells and further crossings out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fmus.cases import read_cases

from ..errors import InputError
from ..published.table4 import CASES, CELL_MODES, PaperTable, read_paper_table
from ..stability.analysis import Stability, analyse
from ..stability.cases import WHEELS, case_inputs, find_rail, find_wheel
from ..stability.eigenloci import Crossing

FAR = 0.07
"""A crossing belongs to a cell within this relative distance of the mode's natural frequency."""


@dataclass(frozen=True)
class Cell:
    """One cell of Table 4, the paper's and ours; None where stable.

    Attributes
    ----------
    case : 1 to 4
    mode : column
    modes : wheel modes that we find involved
    """

    case: int
    mode: str
    paper_frequency_hz: float | None
    paper_gain: float | None
    frequency_hz: float | None
    gain: float | None
    modes: tuple[str, ...] = ()

    @property
    def agrees(self) -> bool:
        """Whether both are stable or both unstable."""
        return (self.gain is None) == (self.paper_gain is None)


@dataclass(frozen=True)
class Table4:
    """Our Table 4.

    Attributes
    ----------
    cells : 32, case by case
    extra : case and crossing for whatever belongs to no cell
    """

    cells: tuple[Cell, ...]
    extra: tuple[tuple[int, Crossing], ...]

    @property
    def right(self) -> int:
        """Number of cells that are stable or unstable as published."""
        return sum(cell.agrees for cell in self.cells)

    @property
    def log_error(self) -> float:
        """Root mean square of ln(gain/paper gain) over the cells that both have."""
        pairs = [(c.gain, c.paper_gain) for c in self.cells if c.gain is not None and c.paper_gain is not None]
        return float(np.sqrt(np.mean([np.log(ours / theirs) ** 2 for ours, theirs in pairs]))) if pairs else np.nan

    def as_json(self) -> dict[str, Any]:
        """Return what the command prints."""
        keys = ("case", "mode", "paper_frequency_hz", "paper_gain", "frequency_hz", "gain")
        return {
            "cells": [{**{key: getattr(c, key) for key in keys}, "modes": list(c.modes)} for c in self.cells],
            "extra": [{"case": case, "frequency_hz": c.frequency_hz, "gain": c.gain} for case, c in self.extra],
            "cells_right": self.right,
            "rms_ln_gain": self.log_error,
        }


def compare(results: Mapping[int, Stability], paper: PaperTable | None = None) -> Table4:
    """Return the table of the stability of all four cases.

    Parameters
    ----------
    results : by case, 1 to 4
    """
    paper = read_paper_table() if paper is None else paper
    cells: list[Cell] = []
    extra: list[tuple[int, Crossing]] = []
    for case in CASES:
        chosen: dict[str, tuple[Crossing, tuple[str, ...]]] = {}
        for instability in sorted(results[case].instabilities, key=lambda i: -i.crossing.gain):
            mode = _cell(instability.crossing.frequency_hz, paper)
            if mode is None or mode in chosen or not instability.crossing.clockwise:
                extra.append((case, instability.crossing))
            else:
                chosen[mode] = (instability.crossing, instability.modes)
        for column, mode in enumerate(CELL_MODES):
            ours = chosen.get(mode)
            printed = (float(paper.frequency_hz[case - 1, column]), float(paper.gain[case - 1, column]))
            f, g = (None, None) if np.isnan(printed[1]) else printed
            cells.append(
                Cell(case, mode, f, g, None, None)
                if ours is None
                else Cell(case, mode, f, g, ours[0].frequency_hz, ours[0].gain, ours[1])
            )
    return Table4(tuple(cells), tuple(extra))


def _cell(frequency_hz: float, paper: PaperTable) -> str | None:
    """Return the column that a crossing belongs to, if any."""
    distance = np.abs(frequency_hz / paper.natural_frequency_hz - 1)
    return CELL_MODES[int(distance.argmin())] if distance.min() < FAR else None


FAMILIES = {"printed": "case", "inferred": "inferred"}
"""What the four cases of a table are called, and how their names begin."""


def find_table4(rail: str | None = None, wheel: str | None = None, cases_of: str = "printed") -> Table4:
    """Return Table 4 for a wheel and a rail; Cases 2 and 4 have a rigid rail always.

    Parameters
    ----------
    rail, wheel : None: analytical rail, wheel of the cases
    cases_of : key of `FAMILIES`

    Raises
    ------
    InputError
        For an unknown family, wheel or rail.
    """
    if cases_of not in FAMILIES:
        raise InputError(f"cases {cases_of}: must be {' or '.join(FAMILIES)}")
    cases = sorted((c for c in read_cases() if c.family == FAMILIES[cases_of]), key=lambda case: case.name)
    the_wheel, the_rail = find_wheel(wheel or WHEELS[cases[0].wheel]), find_rail(rail or "analytic")
    return compare({n: analyse(*case_inputs(case, the_wheel, the_rail)) for n, case in enumerate(cases, start=1)})
