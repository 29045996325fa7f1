"""A campaign from start to end: a plan and a store's path in, a full store out, whatever happens on the way."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from distributed import Client

from ..errors import InputError, SimulationError
from .adoption import adopted
from .cluster import FmuContents, local, remote
from .engine import Engine
from .factors import SEED, START_HZ
from .plan import Plan
from .prepared import Campaign, Workshop, keep, pack, prepare
from .rows import DONE, FAILED, WAITING
from .sampling import Points, points
from .stages import quantities, run_point
from .store import Store, claimed, open_store

RECONNECTS = 20
"""How often in a row a scheduler that is gone is looked for again before the campaign stops."""

_NUMBER_BYTES, _ROW_BYTES = 6.0, 90.0
"""Typical size in the store of a number and of the rest of a row, packed [bytes]."""


@dataclass(frozen=True)
class Progress:
    """How far a campaign is.

    Attributes
    ----------
    wanted, done, failed : runs of the plan, those that are done, those that failed
    rate : runs per second since the start of this sweep
    """

    wanted: int
    done: int
    failed: int
    rate: float

    @property
    def left_s(self) -> float | None:
        """Time left at this rate [s]; None if the rate is not known."""
        left = self.wanted - self.done - self.failed
        return left / self.rate if self.rate > 0 else None


@dataclass(frozen=True)
class How:
    """How a campaign is computed; nothing of it changes a number.

    Attributes
    ----------
    scheduler : address of a Dask scheduler; None: processes of this machine
    workers : their number; None: one per core
    retry_failed : whether failed runs are made again
    report : called with the progress about once a second
    notice : called with sentences that a user should read
    stop_requested : asked twice a second
    """

    scheduler: str | None = None
    workers: int | None = None
    retry_failed: bool = False
    report: Callable[[Progress], None] = lambda _: None
    notice: Callable[[str], None] = lambda _: None
    stop_requested: Callable[[], bool] = lambda: False


@dataclass(frozen=True)
class Estimate:
    """What a campaign takes.

    Attributes
    ----------
    runs : number of runs
    seconds_per_run : of one core of this machine [s]
    seconds : of all runs with the workers that were asked for [s]
    bytes : of the store
    """

    runs: int
    seconds_per_run: float
    seconds: float
    bytes: float


def sweep(plan: Plan, out: Path, how: How | None = None, kin: tuple[Path, ...] = ()) -> Progress:
    """Compute what the store of a plan does not hold yet.

    Parameters
    ----------
    kin : other stores, whose rows are taken where they have the same identity

    Raises
    ------
    InputError
        If the plan does not fit its system, the store is another's, or the scheduler is not there.
    SimulationError
        If the scheduler is gone for good; the store keeps what was done.
    """
    how = how or How()
    campaign, contents, where = checked(plan)
    with claimed(out):
        store = open_store(out, campaign, where, quantities(plan))
        missing = np.flatnonzero(store.status() == WAITING).tolist()
        store.write(list(adopted(campaign, where, missing, kin, store.quantities)))
        run = _Sweep(campaign, contents, where, store, how)
        if run.todo():
            run.all()
        return run.progress()


def checked(plan: Plan) -> tuple[Campaign, dict[str, bytes], Points]:
    """Return campaign, FMUs and points of a plan that fits its system.

    Raises
    ------
    InputError
        If a component or parameter is not there, or an end of a factor is out of range.
    """
    quantities(plan)
    where = points(plan)
    campaign, contents = pack(plan)
    keep(contents)
    workshop = Workshop()
    for row in _corners(where):
        prepare(campaign, workshop, where[row])
    return campaign, contents, where


def _corners(where: Points) -> Iterator[int]:
    """Yield rows at which each factor has its first, smallest and largest value, or each of its texts."""
    rows = {0}
    for name, column in where.columns.items():
        if column.dtype == object:
            rows |= {int(i) for i in np.unique(column.astype(str), return_index=True)[1]}
        elif name != SEED:
            rows |= {int(column.argmin()), int(column.argmax())}
        if name == START_HZ:
            rows |= {int(i) for i in np.unique(column, return_index=True)[1]}
    yield from sorted(rows)


@dataclass
class _Sweep:
    """One sweep over a store."""

    campaign: Campaign
    contents: dict[str, bytes]
    where: Points
    store: Store
    how: How

    def __post_init__(self) -> None:
        self.status = self.store.status()
        self.begin = time.monotonic()
        self.made = 0
        self.retried: set[int] = set()
        self.key = self.campaign.digest[:16]

    def todo(self) -> list[int]:
        """Return the rows that are to be computed."""
        again = self.how.retry_failed & (self.status == FAILED)
        again[list(self.retried)] = False
        return [int(i) for i in np.flatnonzero((self.status == WAITING) | again)]

    def progress(self) -> Progress:
        """Return how far it is."""
        done, failed = int((self.status == DONE).sum()), int((self.status == FAILED).sum())
        elapsed = time.monotonic() - self.begin
        return Progress(len(self.status), done, failed, self.made / elapsed if elapsed > 0 else 0.0)

    def all(self) -> None:
        """Compute; look for the scheduler again when it is gone."""
        tries = 0
        while True:
            before = self.made
            try:
                with self._client() as client:
                    self._on(client)
                return
            except (SimulationError, InputError) as error:
                if self.how.scheduler is None or self.how.stop_requested() or (tries == 0 and not self.made):
                    raise
                tries = tries + 1 if self.made == before else 1
                if tries > RECONNECTS:
                    raise SimulationError(f"{error}; the same plan goes on from {self.store.path}") from None
                self.how.notice(f"{error}; looking for it again")
                time.sleep(1.0)

    @contextmanager
    def _client(self) -> Iterator[Client]:
        """Connect, or start workers."""
        if self.how.scheduler is None:
            with local(min(self.how.workers or os.cpu_count() or 1, max(1, len(self.todo())))) as client:
                yield client
        else:
            with remote(self.how.scheduler) as client:
                yield client

    def _on(self, client: Client) -> None:
        """Compute on a client and write the rows."""
        self.how.notice(f"dashboard {client.dashboard_link}")
        client.register_plugin(FmuContents(f"fmus-{self.key}", self.contents))
        engine = Engine(client, self.campaign, self.key, self.where.__getitem__, self.how.stop_requested)
        self.how.report(self.progress())
        for rows in engine.rows(self.todo()):
            self.store.write(rows)
            self.status[[row.index for row in rows]] = [row.status for row in rows]
            self.retried |= {row.index for row in rows}
            self.made += len(rows)
            self.how.report(self.progress())


def estimate(plan: Plan, workers: int) -> Estimate:
    """Return what a campaign takes, from its first point computed twice here; the second one counts.

    Raises
    ------
    InputError
        If the plan does not fit its system, or the first point cannot be computed.
    """
    campaign, _, where = checked(plan)
    workshop = Workshop()
    for _ in range(2):
        row = run_point(campaign, workshop, 0, where[0])
    if row.status == FAILED:
        raise InputError(f"the first point fails: {row.message}")
    numbers = sum(q.size or 1 for q in quantities(plan)) + len(where.columns)
    size = len(where) * (_ROW_BYTES + _NUMBER_BYTES * numbers)
    return Estimate(len(where), row.seconds, row.seconds * len(where) / workers, size)
