"""Table 4 of the paper: `data/table4.csv` in, crossing frequencies and loop gains as arrays out."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]

TABLE4 = Path(__file__).parent / "data" / "table4.csv"
CASES = (1, 2, 3, 4)
CELL_MODES = ("(1,0)", "(0,0)", "(0,x)", "(2,0)", "(3,0)", "(4,0)", "(5,0)", "(6,0)")
"""Columns of the table: one mode of the wheel each."""


@dataclass(frozen=True)
class PaperTable:
    """The 32 cells of Table 4, cases by modes.

    Attributes
    ----------
    natural_frequency_hz : (8,) of the wheel modes [Hz]
    frequency_hz, gain : (4, 8) of the crossings; NaN where the paper has none
    modes : wheel modes that the paper names, by case and column
    """

    natural_frequency_hz: Real
    frequency_hz: Real
    gain: Real
    modes: dict[tuple[int, str], tuple[str, ...]]

    @property
    def unstable(self) -> NDArray[np.bool_]:
        """(4, 8): whether the paper finds an instability."""
        return np.isfinite(self.gain)

    @property
    def tolerance(self) -> Real:
        """(4, 8) relative tolerance of frequencies: 2 % below 300 Hz, where they hang on the contact, else 0.5 %."""
        return np.where(self.natural_frequency_hz < 300, 0.02, 0.005) * np.ones((len(CASES), 1))


def read_paper_table(path: Path = TABLE4) -> PaperTable:
    """Return Table 4 as printed."""
    natural = np.full(len(CELL_MODES), np.nan)
    frequency = np.full((len(CASES), len(CELL_MODES)), np.nan)
    gain = np.full_like(frequency, np.nan)
    modes: dict[tuple[int, str], tuple[str, ...]] = {}
    with path.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            case, column = int(row["case"]), CELL_MODES.index(row["mode"])
            natural[column] = float(row["natural_frequency_hz"])
            if row["gain"]:
                frequency[case - 1, column] = float(row["frequency_hz"])
                gain[case - 1, column] = float(row["gain"])
            modes[case, row["mode"]] = tuple(row["modes"].split())
    return PaperTable(natural, frequency, gain, modes)
