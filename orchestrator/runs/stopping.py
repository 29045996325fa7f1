"""Ctrl-C and SIGTERM end a run in order, not in the middle of a call; a second one ends it at once."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Thread
from types import FrameType

STOPPED = 130
"""Exit code of a run that was stopped."""

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def stop_on_signals() -> Iterator[Callable[[], bool]]:
    """Catch Ctrl-C and SIGTERM; yield a function that tells whether one came.

    The signal must not become an exception inside an FMU that runs Python, which would report a failure of its own. The
    second one ends the process from another thread, so that it does so in the middle of a call of an FMU, too.
    """
    stopped = False

    def handler(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopped
        stopped = True

    try:
        before = {number: signal.signal(number, handler) for number in _SIGNALS}
    except ValueError:  # not in the main thread: the host program handles signals
        yield lambda: False
        return
    read, write = os.pipe()
    os.set_blocking(write, False)
    old = signal.set_wakeup_fd(write, warn_on_full_buffer=False)
    watch = Thread(target=_watch, args=(read,), daemon=True)
    watch.start()
    try:
        yield lambda: stopped
    finally:
        signal.set_wakeup_fd(old)
        for number, previous in before.items():
            signal.signal(number, previous)
        os.write(write, b"\0")
        watch.join()
        os.close(read)
        os.close(write)


def _watch(read: int) -> None:
    """Count signals until a zero comes; end the process with the second."""
    count = 0
    while True:
        numbers = os.read(read, 64)
        if 0 in numbers:
            return
        count += sum(number in _SIGNALS for number in numbers)
        if count > 1:
            os.write(2, b"stopped at once; results up to the last chunk are kept\n")
            os._exit(STOPPED)
