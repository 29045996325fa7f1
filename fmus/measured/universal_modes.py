"""Normal modes in universal files: data sets 55 and 2414, with nodes (15, 2411) and units (164), in SI out."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..errors import DataError
from .function import Real
from .nodal import NodalModes
from .units import UnitSystem
from .universal import DataSet, read_data_sets, unit_system

_NORMAL_MODE, _DISPLACEMENT, _REAL = 2, 8, (2, 4)


class _Mode(NamedTuple):
    frequency_hz: float
    mass: float
    damping_ratio: float
    number: int
    values: dict[int, Real]


def read_universal_modes(path: Path, units: UnitSystem | None) -> NodalModes:
    """Return the normal modes of a universal file.

    Parameters
    ----------
    units : where the file has no data set 164

    Notes
    -----
    Shapes are divided by the root of the modal mass. The damping ratio is the viscous one plus half the hysteretic one.
    """
    sets = read_data_sets(path, (15, 55, 164, 2411, 2414))
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
        xyz = np.column_stack([c["x"], c["y"], c["z"]]) / system.length
        position |= dict(zip((int(node) for node in c["node_nums"]), xyz, strict=True))
    return _in_si(path, modes, position, system)


def _in_si(path: Path, modes: list[_Mode], position: dict[int, Real], units: UnitSystem) -> NodalModes:
    """Return modes over the nodes of the first, mass-normalised."""
    nodes = sorted(modes[0].values)
    for i, mode in enumerate(modes, start=1):
        if sorted(mode.values) != nodes:
            raise DataError(f"{path.name}, mode {i}: has other nodes than mode 1; must be the same")
        if not mode.mass > 0:
            raise DataError(f"{path.name}, mode {i}: modal mass is {mode.mass:g}; must be > 0")
    kilograms = units.length / units.force
    size = max(len(values) for mode in modes for values in mode.values.values())
    shape = np.full((len(modes), len(nodes), size), np.nan)
    for i, mode in enumerate(modes):
        for k, node in enumerate(nodes):
            values = mode.values[node] / np.sqrt(mode.mass * kilograms)
            shape[i, k, : values.size] = values
    shape[:, :, 3:] *= units.length  # rotations are per length
    return NodalModes(
        where=path.name,
        frequency_hz=np.array([mode.frequency_hz for mode in modes]),
        damping_ratio=np.array([mode.damping_ratio for mode in modes]),
        nodes=np.array(nodes, dtype=np.int64),
        shape=shape,
        position=position,
        labels=tuple(f"mode {mode.number}" for mode in modes),
    )


def _mode_55(data: DataSet) -> _Mode:
    """Return the mode of a data set 55."""
    c = data.content
    _require_normal(data, c["analysis_type"], c["spec_data_type"], np.iscomplexobj(c["r1"]))
    columns = [
        np.asarray(c[key], dtype=float) for key in ("r1", "r2", "r3", "r4", "r5", "r6") if c.get(key) is not None
    ]
    table = np.column_stack(columns)
    damping = float(c["modal_damp_vis"]) + float(c["modal_damp_his"]) / 2
    values = dict(zip((int(n) for n in c["node_nums"]), table, strict=True))
    return _Mode(float(c["freq"]), float(c["modal_m"]), damping, int(c["mode_n"]), values)


def _mode_2414(data: DataSet) -> _Mode:
    """Return the mode of a data set 2414: frequency, mass and damping stand in its twelfth record."""
    c: dict[str, Any] = data.content
    if int(c["dataset_location"]) != 1:
        raise DataError(f"{data.where}: its data are not at nodes (location {c['dataset_location']}); must be 1")
    _require_normal(data, c["analysis_type"], c["result_type"], int(c["data_type"]) not in _REAL)
    damping = float(c["record12_field5"]) + float(c["record12_field6"]) / 2
    values = {int(n): np.asarray(v, dtype=float) for n, v in zip(c["node_nums"], c["data_at_node"], strict=True)}
    number = int(c.get("record10_field6") or 0) or data.number
    return _Mode(float(c["record12_field2"]), float(c["record12_field4"]), damping, number, values)


def _require_normal(data: DataSet, analysis: Any, kind: Any, is_complex: bool) -> None:
    """Raise ValueError for anything but a real normal mode of displacements."""
    if int(analysis) != _NORMAL_MODE or is_complex:
        raise DataError(f"{data.where}: analysis type is {analysis}; must be 2, a real normal mode")
    if int(kind) != _DISPLACEMENT:
        raise DataError(f"{data.where}: data type is {kind}; must be 8, displacement")
