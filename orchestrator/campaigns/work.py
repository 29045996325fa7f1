"""What a worker does: a batch of points in, their rows out. What it prepares it keeps for the next batch."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

from distributed import get_worker

from .factors import Value
from .prepared import Campaign, Workshop
from .rows import Row
from .stages import run_point

_WORKSHOPS: dict[str, Workshop] = {}
"""By campaign; of this process."""


def run_batch(campaign: Campaign, key: str, points: Sequence[tuple[int, Mapping[str, Value]]], topic: str) -> list[Row]:
    """Return the rows of some points.

    Parameters
    ----------
    key : of the campaign
    points : index in the plan and values
    topic : of the event that tells that this batch has begun, for the watch over batches that hang
    """
    worker = get_worker()
    worker.log_event(topic, {"first": points[0][0], "worker": worker.address, "time": time.time()})
    workshop = _WORKSHOPS.setdefault(key, Workshop())
    return [run_point(campaign, workshop, index, point) for index, point in points]
