"""Measured files in, modal data of a passive rail and the quality of its fit out. Nothing is written."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fmus.interface import DIRECTIONS
from fmus.modal.data import ModalData
from fmus.modal.modes import Modes
from fmus.rail.measured import Measurement, measured_modes, read_csv, read_uff

Quality = dict[str, dict[str, float]]

UFF_SUFFIXES = (".uff", ".unv", ".bunv")


def data_of_files(
    files: Sequence[Path], quantity: str, most_modes: int, axis: Sequence[str] = ()
) -> tuple[ModalData, Quality]:
    """Return the modal rail that fits the point functions of some files.

    Parameters
    ----------
    files : CSV or UFF; each may have its own frequencies and directions
    quantity : {'receptance', 'mobility', 'accelerance'}
    most_modes : in each direction
    axis : directions of UFF's codes, such as '3=lat'

    Raises
    ------
    ValueError
        For files that cannot be read or fitted, or a direction that two files have; says which file.
    """
    axes = _axes(axis)
    found: dict[str, tuple[Path, Measurement]] = {}
    parts: list[Modes] = []
    quality: Quality = {}
    for file in files:
        measurement = _read(file, quantity, axes)
        for direction in measurement.receptance:
            if direction in found:
                raise ValueError(f"{file}: holds {direction} as {found[direction][0]} does; must be in one file")
            found[direction] = (file, measurement)
        try:
            modes, errors = measured_modes(measurement, most_modes)
        except ValueError as error:
            raise ValueError(f"{file}: {error}") from None
        parts.append(modes)
        quality |= errors
    modes = Modes(
        np.concatenate([part.omega for part in parts]),
        np.concatenate([part.zeta for part in parts]),
        np.concatenate([part.shape for part in parts]),
        tuple(label for part in parts for label in part.labels),
    )
    names = ", ".join(file.name for file in files)
    source = f"passive least squares fit of the logarithm of the {quantity} in {names} (fmus.rail.measured)"
    return ModalData("measured modal rail", source, modes), {d: quality[d] for d in DIRECTIONS if d in quality}


def _read(file: Path, quantity: str, axes: dict[int, str] | None) -> Measurement:
    """Return the measurement in a file, whose kind its suffix says."""
    if not file.is_file():
        raise ValueError(f"{file}: no such file")
    if file.suffix.lower() == ".csv":
        return read_csv(file, quantity)
    if file.suffix.lower() in UFF_SUFFIXES:
        return read_uff(file, quantity, axes)
    raise ValueError(f"{file}: must end with .csv or {' or '.join(UFF_SUFFIXES)}")


def _axes(texts: Sequence[str]) -> dict[int, str] | None:
    """Return the directions by UFF code that texts such as '3=lat' give."""
    axes: dict[int, str] = {}
    for text in texts:
        code, _, direction = text.partition("=")
        if not code.isdigit() or not 1 <= int(code) <= 6 or direction not in DIRECTIONS:
            raise ValueError(f"--axis {text}: must be CODE=DIRECTION with 1 to 6 and {', '.join(DIRECTIONS)}")
        axes[int(code)] = direction
    return axes or None
