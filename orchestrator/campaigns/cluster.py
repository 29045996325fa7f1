"""Where a campaign runs: processes of this machine, or any Dask scheduler by its address; a connected client out."""

from __future__ import annotations

import logging
import multiprocessing
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import dask
from distributed import Client, LocalCluster, Worker, WorkerPlugin
from distributed.utils import get_mp_context

from ..errors import InputError, SimulationError
from ..runs.identity import versions
from .prepared import keep

PATIENCE = 30.0
"""Time in which a scheduler answers and a first worker comes [s]."""


_STARTS = 5


class FmuContents(WorkerPlugin):
    """What every worker gets, those that come later too: the FMUs of a campaign, by checksum."""

    def __init__(self, name: str, contents: Mapping[str, bytes]) -> None:
        self.name = name
        self.contents = dict(contents)

    def setup(self, worker: Worker) -> None:  # noqa: ARG002 - the signature of a plugin
        """Write what this machine does not have yet."""
        keep(self.contents)


@contextmanager
def local(workers: int) -> Iterator[Client]:
    """Start worker processes on this machine, one thread each; an FMU has a process that no other run disturbs.

    Raises
    ------
    SimulationError
        If they cannot be started.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    settings = {
        "distributed.worker.multiprocessing-method": _start_method(),
        "distributed.scheduler.allowed-failures": 0,
        "distributed.comm.timeouts.connect": f"{PATIENCE:g}s",
        "distributed.worker.profile.enabled": False,
    }
    with dask.config.set(settings), _started(workers) as cluster, Client(cluster) as client:
        yield client


def _start_method() -> str:
    """Return how processes are made: by a server that has loaded this package, where there is such a thing.

    A worker that replaces a lost one is then there at once, and leaves without the destructors of the FMUs' libraries,
    which may free twice.
    """
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return "spawn"
    with dask.config.set({"distributed.worker.multiprocessing-method": "forkserver"}):
        get_mp_context()  # puts its own list of modules in, once
    multiprocessing.get_context("forkserver").set_forkserver_preload(["distributed", f"{__package__}.work"])
    return "forkserver"


def _started(workers: int) -> LocalCluster:
    """Return a cluster of this machine; a worker that is killed while it starts does not end the campaign."""
    for attempt in range(_STARTS):
        try:
            return LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0",
                silence_logs=logging.CRITICAL, memory_limit=0,
            )  # fmt: skip
        except (RuntimeError, OSError, TimeoutError) as error:
            if attempt == _STARTS - 1:
                raise SimulationError(f"the worker processes do not start: {error}") from None
    raise AssertionError


@contextmanager
def remote(address: str, patience: float = PATIENCE) -> Iterator[Client]:
    """Connect to a scheduler.

    Raises
    ------
    InputError
        If it is not there, has no workers, or runs other versions.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    try:
        client = Client(address, timeout=patience, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"scheduler {address}: no Dask scheduler answers there ({reason})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=patience)
        except TimeoutError:
            raise InputError(f"scheduler {address}: has no workers") from None
        _same_versions(client, address)
        yield client


def _same_versions(client: Client, address: str) -> None:
    """Raise InputError if scheduler or workers run other versions than this process."""
    told: Any = client.get_versions()
    here = told["client"]["packages"]["distributed"]
    there = told["scheduler"]["packages"]["distributed"]
    if here != there:
        raise InputError(f"scheduler {address}: runs distributed {there}, this is {here}")
    try:
        workers = client.run(versions)
    except Exception as error:  # the worker's own error: it has not even this package
        raise InputError(f"scheduler {address}: its workers cannot load this package ({error})") from None
    for worker, found in workers.items():
        for name, version in versions().items():
            if found.get(name) != version:
                raise InputError(
                    f"scheduler {address}: worker {worker} runs {name} {found.get(name)}, this is {version}"
                )
