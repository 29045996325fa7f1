"""One vertical point function of the default track in the ways in which people measure and store it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyuff
from numpy.typing import NDArray

from fmus.rail.track import track_receptance
from fmus.rail.track_data import TRACKS, read_track

Complex = NDArray[np.complex128]
Real = NDArray[np.float64]

F = np.arange(20.0, 4001.0, 5.0)
TRACK = read_track(TRACKS / "default.toml")


def true_receptance(f: Real) -> Complex:
    """Return the vertical point receptance [m/N] at frequencies f [Hz]."""
    return np.asarray(track_receptance(2 * np.pi * f, TRACK)[:, 2, 2])


RECEPTANCE = true_receptance(F)
MOBILITY = 2j * np.pi * F * RECEPTANCE
ACCELERANCE = 2j * np.pi * F * MOBILITY

SI: dict[str, Any] = {
    "units_code": 1, "units_description": "SI", "temp_mode": 1, "length": 1.0, "force": 1.0, "temp": 1.0,
    "temp_offset": 0.0,
}  # fmt: skip
MM_MN = {**SI, "units_code": 5, "units_description": "mm (milli-newton)", "length": 1000.0, "force": 1000.0}
MM_N = {**SI, "units_code": 9, "units_description": "mm-N user defined", "length": 1000.0}
PLAIN: dict[str, Any] = {
    "func_type": 4, "rsp_node": 7, "rsp_dir": 3, "ref_node": 7, "ref_dir": 3, "data": MOBILITY, "x": F, "binary": 0,
    "rsp_ent_name": "rail", "ref_ent_name": "rail", "abscissa_spacing": 1, "abscissa_min": F[0],
    "abscissa_inc": F[1] - F[0], "abscissa_spec_data_type": 18, "ordinate_spec_data_type": 11,
    "orddenom_spec_data_type": 13, "ordinate_axis_units_lab": "m/s", "orddenom_axis_units_lab": "N",
    "abscissa_axis_units_lab": "Hz",
}  # fmt: skip
COHERENCE: dict[str, Any] = {
    "func_type": 6, "data": np.full(F.size, 0.9), "ordinate_spec_data_type": 0, "orddenom_spec_data_type": 0,
}  # fmt: skip
TIME: dict[str, Any] = {
    "func_type": 1, "data": np.sin(np.arange(F.size) * 0.1) + 2, "abscissa_spec_data_type": 17,
    "abscissa_axis_units_lab": "s",
}  # fmt: skip

UFF: dict[str, tuple[list[dict[str, Any]], dict[str, Any] | None]] = {
    "uff-plain": ([{}], SI),
    "uff-binary": ([{"binary": 1}], SI),
    "uff-ufb-suffix": ([{"binary": 1}], SI),
    "uff-y-up": ([{"rsp_dir": 2, "ref_dir": 2}], SI),
    "uff-signs-opposite": ([{"data": -MOBILITY, "ref_dir": -3}], SI),
    "uff-units-mm": ([{"data": MOBILITY * 1000}], MM_N),
    "uff-units-mm-mn": ([{"data": MOBILITY}], MM_MN),
    "uff-label-mm": ([{"data": MOBILITY * 1000, "ordinate_axis_units_lab": "mm/s"}], None),
    "uff-label-g": (
        [{"data": ACCELERANCE / 9.80665, "ordinate_spec_data_type": 12, "ordinate_axis_units_lab": "g"}], None,
    ),
    "uff-with-coherence": ([{}, COHERENCE, {"func_type": 2, "data": np.abs(MOBILITY) ** 2}], SI),
    "uff-coherence-first": ([COHERENCE, {}], SI),
    "uff-two-nodes": ([{}, {"rsp_node": 9, "ref_node": 9, "data": MOBILITY * 1.01}], SI),
    "uff-only-coherence": ([COHERENCE], SI),
    "uff-time-history": ([TIME], SI),
    "uff-denominator": ([{"orddenom_spec_data_type": 12, "orddenom_axis_units_lab": "m/s2"}], SI),
}  # fmt: skip
"""Data sets 58, as changes of `PLAIN`, and data set 164 of each file."""


def write_uff(path: Path, sets: list[dict[str, Any]], units: dict[str, Any] | None = SI) -> Path:
    """Write a universal file."""
    file = pyuff.UFF(str(path))
    if units:
        file.write_sets(pyuff.prepare_164(**units), "add")
    for change in sets:
        file.write_sets(pyuff.prepare_58(**{**PLAIN, **change}), "add")
    return path


def write_csv(path: Path, f: Real, values: Complex, separator: str = ",", encoding: str = "utf-8") -> Path:
    """Write a vertical point function as CSV."""
    rows = np.column_stack([f, values.real, values.imag])
    lines = [["frequency_hz", "ver_real", "ver_imag"], *[[repr(float(x)) for x in row] for row in rows]]
    path.write_text("\n".join(separator.join(line) for line in lines) + "\n", encoding=encoding)
    return path


def noisy() -> tuple[Real, Complex]:
    """Return an accelerance from 3 to 6400 Hz with a noise floor of 0.3 % of its largest value."""
    f = np.arange(3.125, 6400.1, 3.125)
    clean = -((2 * np.pi * f) ** 2) * true_receptance(f)
    random = np.random.default_rng(0)
    noise = random.standard_normal(f.size) + 1j * random.standard_normal(f.size)
    return f, clean + 3e-3 * np.abs(clean).max() * noise / np.sqrt(2)


def write_variant(folder: Path, name: str) -> Path:
    """Write the file of a variant."""
    if name in UFF:
        return write_uff(folder / ("m.ufb" if name == "uff-ufb-suffix" else "m.uff"), *UFF[name])
    path = folder / "m.csv"
    if name == "csv-noise":
        return write_csv(path, *noisy())
    if name == "csv-dc":
        return write_csv(path, np.append(0.0, F), np.append(0.0, MOBILITY))
    change = {"csv-bom": {"encoding": "utf-8-sig"}, "csv-semicolon": {"separator": ";"}, "csv-plain": {}}[name]
    return write_csv(path, F, MOBILITY, **change)
