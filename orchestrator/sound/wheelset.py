"""Which wheelset the results of a run are of: parameters in, radiating areas and damping out."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fmus.modal.parameters import block_of, modal_velocities
from fmus.wheel.areas import UNCERTAINTY_DB, estimated_wheelset, given_wheelset
from fmus.wheel.class158 import class158
from fmus.wheel.imported import read_modes
from fmus.wheel.inferred import inferred
from fmus.wheel.wheelset import DATA, Wheelset, read_wheelset

from ..errors import InputError
from ..results.columns import MODAL_VELOCITIES

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..results.samples import Samples

Real = NDArray[np.float64]

SAME_FREQUENCY = 1e-3
"""Relative distance of natural frequencies within which a structure counts as one that is known."""


def wheelset_of(data: xr.Dataset | Samples, wheel: str | Wheelset | None = None) -> Wheelset:
    """Return the wheelset of a results file with the damping ratios of the run.

    Parameters
    ----------
    data : results with the wheel's parameters and modal velocities
    wheel : a wheelset, name of a shipped one or a file such as those in fmus/wheel/data; None: the shipped one that
        has the natural frequencies, and most nearly the shapes, of the results

    Raises
    ------
    InputError
        If no wheelset fits.
    """
    if isinstance(wheel, Wheelset):
        return _as_run(wheel, data)
    count = len(modal_velocities("wheel", data))
    if count == 0:
        raise InputError(
            f"{_source(data)}: holds no modal velocities of the wheel, so its sound is not known; "
            f"run again and record '{MODAL_VELOCITIES}'"
        )
    if wheel is not None:
        chosen = _named(wheel)
        if len(chosen.modes) != count:
            raise InputError(f"wheel {wheel}: has {len(chosen.modes)} modes, {_source(data)} has {count}")
        return _as_run(chosen, data)
    frequency = block(data, "wheel", "frequency")
    found = fitting_wheelset(frequency, block(data, "wheel", "shape_lat")) if frequency.size == count else None
    if found is not None:
        return _as_run(found, data)
    raise InputError(
        f"{_source(data)}: its wheel is none of {', '.join(shipped())}, so its radiating areas are not known; "
        "name a wheel, or give its file"
    )


def _as_run(wheelset: Wheelset, data: xr.Dataset | Samples) -> Wheelset:
    """Return a wheelset with the damping ratios that the run had, where the results tell them."""
    zeta = block(data, "wheel", "damping_ratio")
    return replace(wheelset, modes=replace(wheelset.modes, zeta=zeta)) if zeta.size == len(wheelset.modes) else wheelset


def fitting_wheelset(frequency_hz: Real, shape_lat: Real) -> Wheelset | None:
    """Return the shipped wheelset that has these natural frequencies [Hz] and most nearly these lateral shapes.

    None if none has. Without shapes (empty) the first one is taken.
    """
    fitting = [
        candidate
        for candidate in map(_named, shipped())
        if len(candidate.modes) == frequency_hz.size
        and np.allclose(candidate.modes.omega / (2 * np.pi), frequency_hz, rtol=SAME_FREQUENCY)
    ]
    if not fitting:
        return None
    size = shape_lat.size
    return min(fitting, key=lambda w: float(np.abs(w.modes.shape[:, 1] - shape_lat).sum()) if size else 0.0)


def shipped() -> list[str]:
    """Return the names of the wheelsets whose radiating areas are known."""
    return [*sorted(path.stem for path in DATA.glob("*840.toml")), "class158", "inferred"]


def _named(wheel: str) -> Wheelset:
    """Return the wheelset of a name or file."""
    own = {"class158": class158, "inferred": inferred}
    if wheel in own:
        return own[wheel]()
    path = DATA / f"{wheel}.toml" if wheel in shipped() else Path(wheel)
    try:
        text = path.read_text(encoding="utf-8")
        if path.suffix.lower() != ".csv" and "[[mode]]" not in text:
            return read_wheelset(path)
        read = read_modes(path)
        if read.areas is not None:
            return given_wheelset(read.modes, read.areas, f"{path.stem}; areas as its file has them")
        sure, others = UNCERTAINTY_DB.values()
        title = f"{path.stem}; areas estimated from labels, (n,0) within {sure:g} dB, others {others:g} dB"
        return estimated_wheelset(read.modes, title)
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise InputError(f"wheel {wheel}: neither {', '.join(shipped())} nor a wheelset file: {error}") from None


def block(data: xr.Dataset | Samples, structure: str, name: str) -> Real:
    """Return a parameter of all modes of a structure, such as 'frequency'; empty if the results do not tell it."""
    values: dict[str, Any] = json.loads(data.attrs.get("all_parameters", "{}")).get(structure, {})
    return block_of(name, values)


def _source(data: xr.Dataset | Samples) -> str:
    return str(data.encoding.get("source", "the results"))
