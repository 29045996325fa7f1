"""Ctrl-C and SIGTERM end a run in order, not in the middle of a call."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType


@contextmanager
def stop_on_signals() -> Iterator[Callable[[], bool]]:
    """Catch Ctrl-C and SIGTERM; yield a function that tells whether one came.

    The signal must not become an exception inside an FMU that runs Python, which would report a failure of its own.
    """
    stopped = False

    def handler(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopped
        stopped = True

    try:
        before = {number: signal.signal(number, handler) for number in (signal.SIGINT, signal.SIGTERM)}
    except ValueError:  # not in the main thread: the host program handles signals
        before = {}
    try:
        yield lambda: stopped
    finally:
        for number, old in before.items():
            signal.signal(number, old)
