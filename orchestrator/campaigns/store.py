"""The store of a campaign: rows in as they come, a Zarr group that xarray opens at any moment out.

Every point of the plan has its place from the start. A row's numbers are written first and its status last, and every
chunk replaces the one before in one move: a row counts as there when its status says so, whatever is killed when.
"""

from __future__ import annotations

import json
import os
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import zarr
from filelock import FileLock, Timeout
from numpy.typing import NDArray

from ..errors import InputError
from ..runs.identity import versions
from .prepared import Campaign
from .rows import DONE, FAILED, WAITING, Quantity, Row
from .sampling import Points

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

_FORMAT = "curvesqueal campaign 1"
_BELONGS = (
    ("plan_digest", "another plan"), ("fmus", "other FMUs"), ("versions", "other versions"),
    ("system_digest", "a system with other values or connections"),
)  # fmt: skip
"""What a store has in common with the campaign that goes on with it, and the words for one that differs."""

_CHUNKS = (256, 16384)
"""Fewest and most rows of a chunk."""


@dataclass(frozen=True)
class Store:
    """A store that is open for writing.

    Attributes
    ----------
    path : its folder
    group : the Zarr group
    quantities : what rows hold
    """

    path: Path
    group: zarr.Group
    quantities: tuple[Quantity, ...]

    def status(self) -> NDArray[np.uint8]:
        """Return the status of every row."""
        return np.asarray(self._array("status")[:])

    def write(self, rows: Sequence[Row]) -> None:
        """Write rows; they are there when this returns."""
        if not rows:
            return
        place = np.array([row.index for row in rows])
        for q in self.quantities:
            width = () if q.size is None else (q.size,)
            lack: Any = "" if q.text else np.full(width, np.nan)
            column = [row.values.get(q.name, lack) for row in rows]
            self._put(q.name, place, np.array(column, dtype=object if q.text else np.float64))
        self._put("identity", place, np.array([row.identity for row in rows], dtype=object))
        self._put("message", place, np.array([row.message for row in rows], dtype=object))
        self._put("seconds", place, np.array([row.seconds for row in rows]))
        self._put("status", place, np.array([row.status for row in rows], dtype=np.uint8))

    def _put(self, name: str, place: NDArray[np.int64], values: NDArray[Any]) -> None:
        """Write values to rows, chunk by chunk: one replacement of a chunk for all of its rows."""
        array = self._array(name)
        size = array.chunks[0]
        for chunk in np.unique(place // size):
            here = place // size == chunk
            part = slice(int(chunk) * size, min((int(chunk) + 1) * size, array.shape[0]))
            block = np.asarray(array[part])
            block[place[here] - part.start] = values[here]
            array[part] = block

    def _array(self, name: str) -> Any:
        return self.group[name]


@contextmanager
def claimed(path: Path) -> Iterator[None]:
    """Hold a store for this process alone; a kill sets it free.

    Raises
    ------
    InputError
        If another process holds it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    lock = FileLock(path.with_name(f".{path.name}.lock"), timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise InputError(f"{path}: another sweep is writing to it") from None
    try:
        yield
    finally:
        lock.release()


def open_store(path: Path, campaign: Campaign, points: Points, quantities: tuple[Quantity, ...]) -> Store:
    """Return the store of a campaign, made if it is not there.

    Raises
    ------
    InputError
        If something else is there, or the store of another plan, of other FMUs or of other versions.
    """
    about = _about(campaign)
    if not path.exists():
        _create(path, about, points, quantities)
    group = _group(path)
    attributes = dict(group.attrs)
    for key, words in _BELONGS:
        if attributes.get(key) != about[key]:
            raise InputError(
                f"{path}: is the store of {words}; keep the rows in another store{_difference(attributes, about, key)}"
            )
    return Store(path, group, quantities)


def _difference(before: dict[str, Any], now: dict[str, Any], key: str) -> str:
    """Return which FMU or version differs."""
    if key.endswith("digest"):
        return ""
    then, here = json.loads(str(before.get(key, "{}"))), json.loads(now[key])
    names = sorted(n for n in {*then, *here} if then.get(n) != here.get(n))
    return f" ({names[0]}: {str(then.get(names[0]))[:12]} there, {str(here.get(names[0]))[:12]} here)" if names else ""


def _group(path: Path) -> zarr.Group:
    """Return the Zarr group of a store.

    Raises
    ------
    InputError
        If it is none of ours.
    """
    try:
        group = zarr.open_group(path, mode="r+", use_consolidated=False)
    except (OSError, ValueError, KeyError):
        raise InputError(f"{path}: is no store of a campaign") from None
    if group.attrs.get("format") != _FORMAT:
        raise InputError(f"{path}: is no store of a campaign")
    return group


def _about(campaign: Campaign) -> dict[str, Any]:
    """Return what a store says of itself."""
    fmus = {campaign.names[str(e.source)]: str(e.source) for e in campaign.system.elements.values()}
    fmus |= {Path(text).name: checksum for text, checksum in campaign.sources.items()}
    return {
        "format": _FORMAT,
        "title": f"campaign on {Path(campaign.plan.base.system).name}",
        "plan": campaign.plan.text,
        "plan_digest": campaign.plan.digest,
        "system_digest": campaign.system_digest,
        "factors": list(campaign.plan.factors),
        "fmus": json.dumps(fmus, sort_keys=True),
        "versions": json.dumps(versions(), sort_keys=True),
        "step_s": campaign.settings.step,
        "duration_s": campaign.settings.duration,
        "algorithm": campaign.settings.algorithm,
    }


def _create(path: Path, about: dict[str, Any], points: Points, quantities: tuple[Quantity, ...]) -> None:
    """Make a store with all of its points and no results; it appears under its name when it is whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}-"))
    try:
        group = zarr.open_group(temporary, mode="w", zarr_format=3)
        group.attrs.update({**about, "coordinates": " ".join(points.columns)})
        n = len(points)
        chunk = int(np.clip(n // 64, *_CHUNKS))

        def add(name: str, shape: tuple[int, ...], kind: Any, lack: Any, **attributes: Any) -> Any:
            names = ("run", "place")[: len(shape)]
            chunks = (min(chunk, n), *shape[1:])
            array = group.create_array(
                name, shape=shape, chunks=chunks, dtype=kind, fill_value=lack, dimension_names=names
            )
            array.attrs.update(attributes)
            return array

        for name, column in points.columns.items():
            text = column.dtype == object
            array = add(name, (n,), str if text else column.dtype, "" if text else 0, long_name=name)
            array[:] = column
        for q in quantities:
            shape = (n,) if q.size is None else (n, q.size)
            kind, lack = (str, "") if q.text else (np.float64, np.nan)
            add(q.name, shape, kind, lack, long_name=q.words, **({} if q.text else {"units": q.unit}))
        add("identity", (n,), str, "", long_name="hash of the resolved scenario, FMUs and versions")
        add("message", (n,), str, "", long_name="why a run failed")
        add("seconds", (n,), np.float32, np.nan, long_name="wall time of the run", units="s")
        meanings = {"flag_values": [WAITING, DONE, FAILED], "flag_meanings": "waiting done failed"}
        add("status", (n,), np.uint8, WAITING, long_name="status of the run", **meanings)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # consolidated metadata are not in the specification of Zarr 3 yet
            zarr.consolidate_metadata(group.store)
        os.rename(temporary, path)
    except OSError as error:
        raise InputError(f"{path}: cannot be made: {error.strerror or error}") from None
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def open_campaign(path: Path) -> xr.Dataset:
    """Return a store as a dataset, loaded lazily.

    Raises
    ------
    InputError
        If it is not there or no store of a campaign.
    """
    import xarray as xr  # noqa: PLC0415

    if not path.exists():
        raise InputError(f"{path}: no such store")
    _group(path)
    data: xr.Dataset = xr.open_zarr(path)
    return data
