"""Rows that other stores have already: points that are missing in, rows of the same identity out."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np

from ..errors import InputError
from ..runs.identity import identity
from .prepared import Campaign, Workshop, prepare
from .rows import DONE, Quantity, Row
from .sampling import Points
from .store import open_campaign


def adopted(
    campaign: Campaign, where: Points, missing: Iterable[int], kin: Iterable[Path], quantities: tuple[Quantity, ...]
) -> Iterator[Row]:
    """Yield the missing rows that stores have under the identity of their resolved scenario.

    Parameters
    ----------
    kin : stores; those of plans that compute something else are passed over
    quantities : what rows hold
    """
    known: dict[str, Row] = {}
    for path in kin:
        known.update(_rows(path, campaign, quantities))
    workshop = Workshop()
    for index in missing if known else ():
        name = identity(prepare(campaign, workshop, where[index]), campaign.settings)
        if name in known:
            yield Row(index, DONE, name, "", known[name].values, known[name].seconds)


def _rows(path: Path, campaign: Campaign, quantities: tuple[Quantity, ...]) -> dict[str, Row]:
    """Return the finished rows of a store by identity; none if it computes something else."""
    try:
        data = open_campaign(path).load()
    except InputError:
        return {}
    computed = (json.loads(text).get("compute", {}) for text in (data.attrs["plan"], campaign.plan.text))
    if len({json.dumps(each, sort_keys=True) for each in computed}) > 1:
        return {}
    if any(q.name not in data for q in quantities):  # of an earlier version
        return {}
    columns = {q.name: data[q.name].to_numpy() for q in quantities}
    names, seconds = data["identity"].to_numpy(), data["seconds"].to_numpy()
    return {
        str(names[k]): Row(0, DONE, values={n: column[k] for n, column in columns.items()}, seconds=float(seconds[k]))
        for k in np.flatnonzero(data["status"].to_numpy() == DONE)
    }
