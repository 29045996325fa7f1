"""Normal modes in universal files: data sets 55 and 2414, with nodes (15, 2411) and units (164), in SI out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import DataError
from ..function import Real
from ..units import UnitSystem
from ..universal import DataSet, origin, read_data_sets, unit_system
from .nodal import NodalModes
from .raw import RawMode, in_si

_NORMAL_MODE, _DISPLACEMENT, _REAL = 2, 8, (2, 4)


def read_universal_modes(path: Path, units: UnitSystem | None) -> NodalModes:
    """Return the normal modes of a universal file.

    Parameters
    ----------
    units : where the file has no data set 164

    Notes
    -----
    Shapes are divided by the root of the modal mass. The damping ratio is the viscous one plus half the hysteretic one.
    """
    sets = read_data_sets(path, (15, 55, 151, 164, 2411, 2414))
    system = unit_system(sets)
    if system is not None and units is not None and (system.length, system.force) != (units.length, units.force):
        raise DataError(f"{path.name}: {system.source} has other units than the option units")
    system = system or units
    if system is None:
        raise DataError(
            f"{path.name}: has no data set 164 (units); give them with the option units, such as m,N or mm,N"
        )
    modes = [_mode_55(d) if d.kind == 55 else _mode_2414(d) for d in sets if d.kind in (55, 2414)]
    if not modes:
        held = ", ".join(sorted({str(d.kind) for d in sets}))
        raise DataError(f"{path.name}: there is no data set 55 or 2414 in it; holds data sets {held}")
    position: dict[int, Real] = {}
    for data in (d for d in sets if d.kind in (15, 2411)):
        c = data.content
        xyz = np.column_stack([c["x"], c["y"], c["z"]])
        position |= dict(zip((int(node) for node in c["node_nums"]), xyz, strict=True))
    return replace(in_si(path.name, modes, position, system), origin=origin(sets))


def _mode_55(data: DataSet) -> RawMode:
    """Return the mode of a data set 55."""
    c = data.content
    _require_normal(data, c["analysis_type"], c["spec_data_type"], np.iscomplexobj(c["r1"]))
    columns = [
        np.asarray(c[key], dtype=float) for key in ("r1", "r2", "r3", "r4", "r5", "r6") if c.get(key) is not None
    ]
    table = np.column_stack(columns)
    damping = float(c["modal_damp_vis"]) + float(c["modal_damp_his"]) / 2
    values = dict(zip((int(n) for n in c["node_nums"]), table, strict=True))
    return RawMode(float(c["freq"]), float(c["modal_m"]), values, damping, int(c["mode_n"]), data.where)


def _mode_2414(data: DataSet) -> RawMode:
    """Return the mode of a data set 2414: frequency, mass and damping stand in its twelfth record."""
    c: dict[str, Any] = data.content
    if int(c["dataset_location"]) != 1:
        raise DataError(f"{data.where}: its data are not at nodes (location {c['dataset_location']}); must be 1")
    _require_normal(data, c["analysis_type"], c["result_type"], int(c["data_type"]) not in _REAL)
    damping = float(c["record12_field5"]) + float(c["record12_field6"]) / 2
    values = {int(n): np.asarray(v, dtype=float) for n, v in zip(c["node_nums"], c["data_at_node"], strict=True)}
    number = int(c.get("record10_field6") or 0) or data.number
    return RawMode(float(c["record12_field2"]), float(c["record12_field4"]), values, damping, number, data.where)


def _require_normal(data: DataSet, analysis: Any, kind: Any, is_complex: bool) -> None:
    """Raise ValueError for anything but a real normal mode of displacements."""
    if int(analysis) != _NORMAL_MODE or is_complex:
        raise DataError(f"{data.where}: analysis type is {analysis}; must be 2, a real normal mode")
    if int(kind) != _DISPLACEMENT:
        raise DataError(f"{data.where}: data type is {kind}; must be 8, displacement")
