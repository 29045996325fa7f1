"""What the commands `wheel ...` share: wheels by name or file, wheels into files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fmus.wheel.imported import ImportedWheel, read_modes

if TYPE_CHECKING:
    from fmus.modal.modes import Modes

Real = NDArray[np.float64]


def read_wheel(text: str) -> ImportedWheel:
    """Return class158, or what a CSV or TOML file says of a wheel."""
    from fmus.wheel.class158 import class158  # noqa: PLC0415

    if text != "class158":
        return read_modes(Path(text))
    known = class158()
    return ImportedWheel(known.modes, areas=np.column_stack([known.area_axial, known.area_radial]))


def write_wheel(modes: Modes, path: Path, title: str, source: str, areas: Real | None = None) -> None:
    """Write a wheel as an FMU or, with areas if they are known, as modal data, by the suffix."""
    from fmus.modal.component import structure  # noqa: PLC0415
    from fmus.modal.data import ModalData, write_modal_data  # noqa: PLC0415
    from fmus.packaging.build import build_fmu  # noqa: PLC0415

    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".toml":
        write_modal_data(path, ModalData(title, source, modes, areas))
    else:
        build_fmu(structure("wheel", f"Wheel at the contact point: {title}", modes), path)
