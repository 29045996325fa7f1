"""The engine: points that are missing in, rows as they are done out, on any Dask client.

Batches are as long as `BATCH_SECONDS`, so that the scheduler's share is small and a lost worker costs little. A batch
whose worker is lost is done again, point by point; a point that takes several workers with it, or does not end in time,
becomes a row with its sentence.
"""

from __future__ import annotations

import queue
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from distributed import Client, Future, KilledWorker

from ..errors import SimulationError
from .factors import Value
from .prepared import Campaign
from .rows import FAILED, Row
from .work import run_batch

BATCH_SECONDS = 1.0
LARGEST_BATCH = 500
PER_THREAD = 3
"""Batches that are on their way for every thread of the workers."""

PATIENCE = 30.0
"""Time in which a worker whose batch does not end is replaced [s]."""

_LOST = ("cancelled", "lost")


@dataclass
class _Batch:
    """Points that are on their way.

    Attributes
    ----------
    indices : of the points
    begun : time at which a worker began with them, and that worker's address
    """

    indices: tuple[int, ...]
    begun: tuple[float, str] | None = None


@dataclass
class Engine:
    """Batches on a client.

    Attributes
    ----------
    client : where they run
    campaign, key : what they belong to
    point : values at an index
    stop_requested : asked twice a second
    """

    client: Client
    campaign: Campaign
    key: str
    point: Callable[[int], Mapping[str, Value]]
    stop_requested: Callable[[], bool] = lambda: False
    _waiting: deque[tuple[int, ...]] = field(default_factory=deque)
    _running: dict[str, tuple[Future[list[Row]], _Batch]] = field(default_factory=dict)
    _finished: queue.SimpleQueue[str] = field(default_factory=queue.SimpleQueue)
    _killed: dict[int, int] = field(default_factory=dict)
    _seconds: deque[float] = field(default_factory=lambda: deque(maxlen=50))
    _threads: tuple[float, int] = (0.0, 1)
    _count: int = 0

    def rows(self, indices: list[int]) -> Iterator[list[Row]]:
        """Yield the rows of points as they are done, all at once that are there.

        Raises
        ------
        SimulationError
            If the scheduler is gone; what is missing then is not done.
        """
        left: deque[int] = deque(indices)
        topic = f"campaign-{self.key}"
        self.client.subscribe_topic(topic, self._begun)
        try:
            while left or self._waiting or self._running:
                if self.stop_requested():
                    break
                self._submit(left, topic)
                rows = self._collect() + self._watch()
                if rows:
                    yield rows
        finally:
            for future, _ in list(self._running.values()):
                future.release()
            self._running.clear()

    def _submit(self, left: deque[int], topic: str) -> None:
        """Send batches until the workers have enough of them."""
        while (left or self._waiting) and len(self._running) < PER_THREAD * self._count_threads():
            if self._waiting:
                indices = self._waiting.popleft()
            else:
                indices = tuple(left.popleft() for _ in range(min(self._size(), len(left))))
            self._count += 1
            name = f"run-{self.key}-{indices[0]}-{self._count}"
            points = [(index, self.point(index)) for index in indices]
            future = self.client.submit(run_batch, self.campaign, self.key, points, topic, key=name, pure=False)
            self._running[name] = (future, _Batch(indices))
            future.add_done_callback(lambda done: self._finished.put(done.key))

    def _size(self) -> int:
        """Return how many points make a batch."""
        if len(self._seconds) < 3:
            return 1
        typical = sorted(self._seconds)[len(self._seconds) // 2]
        return max(1, min(LARGEST_BATCH, int(BATCH_SECONDS / max(typical, 1e-6))))

    def _count_threads(self) -> int:
        """Return the number of threads of all workers, looked up once a second."""
        if time.monotonic() - self._threads[0] > 1.0:
            try:
                count = sum(self.client.nthreads().values())
            except (OSError, TimeoutError):
                raise SimulationError(self._gone()) from None
            self._threads = (time.monotonic(), max(1, count))
        return self._threads[1]

    def _collect(self) -> list[Row]:
        """Return what has come, after waiting for something to come."""
        rows: list[Row] = []
        try:
            name = self._finished.get(timeout=0.5)
            while True:
                rows += self._result(name)
                name = self._finished.get_nowait()
        except queue.Empty:
            return rows

    def _result(self, name: str) -> list[Row]:
        """Return the rows of a batch; none if it has to be done again."""
        if name not in self._running:
            return []
        future, batch = self._running.pop(name)
        try:
            if future.status not in _LOST:
                rows: list[Row] = future.result(timeout=60)
                self._seconds.extend(row.seconds for row in rows)
                return rows
        except KilledWorker:
            return self._worker_lost(batch)
        except (OSError, TimeoutError):
            pass
        except Exception as error:  # whatever a worker cannot say otherwise is a row's sentence
            if "Cancelled" not in type(error).__name__ and "Lost" not in type(error).__name__:
                return self._failed(batch, f"the worker fails: {type(error).__name__}: {error}")
        if self.client.status != "running":
            raise SimulationError(self._gone())
        self._again(batch)
        return []

    def _worker_lost(self, batch: _Batch) -> list[Row]:
        """Do a batch again whose worker process ended; give a point up that this happened to too often."""
        if len(batch.indices) == 1:
            index = batch.indices[0]
            self._killed[index] = self._killed.get(index, 0) + 1
            if self._killed[index] >= self.campaign.plan.compute.attempts:
                return self._failed(
                    batch, f"its worker process ended {self._killed[index]} times in the middle of this run"
                )
        self._again(batch)
        return []

    def _again(self, batch: _Batch) -> None:
        self._waiting.extend((index,) for index in batch.indices)

    def _failed(self, batch: _Batch, sentence: str) -> list[Row]:
        return [Row(index, FAILED, "", sentence) for index in batch.indices]

    def _begun(self, event: tuple[float, Any]) -> None:
        """Note that a worker has begun with a batch."""
        told = event[1]
        for _, batch in list(self._running.values()):
            if batch.indices[0] == told["first"]:
                batch.begun = (time.monotonic(), str(told["worker"]))

    def _watch(self) -> list[Row]:
        """End workers whose batch does not end; return the row of a single point that does not."""
        limit = self.campaign.plan.compute.timeout_s
        rows: list[Row] = []
        for name, (future, batch) in list(self._running.items()):
            if batch.begun is None or time.monotonic() - batch.begun[0] < limit:
                continue
            del self._running[name]
            future.cancel()
            self.client.restart_workers([batch.begun[1]], timeout=PATIENCE, raise_for_error=False)
            if len(batch.indices) == 1:
                rows += self._failed(batch, f"does not end within {limit:g} s")
            else:
                self._again(batch)
        return rows

    def _gone(self) -> str:
        return f"the scheduler at {self.client.scheduler.address if self.client.scheduler else '?'} is gone"
