"""The standard streams of a command: those that are closed, break, are full or take few letters."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from types import FrameType
from typing import Any

BROKEN = 141
"""Exit code where the reader of the output went away: 128 and the number of SIGPIPE, as shells say it."""

INTERRUPTED = 130


def open_closed_streams() -> None:
    """Put nothing in the place of streams that are closed, or the next file that is opened takes their number."""
    while True:
        number = os.open(os.devnull, os.O_RDWR)
        if number > 2:
            os.close(number)
            break
    for name in ("stdout", "stderr"):
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115 - for the whole process


def keep_standard_output() -> None:
    """Keep the standard output for what commands print; what FMUs print goes to the error stream.

    Letters that it does not take are written as their numbers.
    """
    stream: Any = sys.stdout
    stream.flush()
    own = os.dup(1)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(own, "w", encoding=stream.encoding, errors="backslashreplace")


def end_on_interrupt() -> None:
    """Let Ctrl-C end the process with its exit code and no traceback, where no run has to be ended in order."""

    def handler(_number: int, _frame: FrameType | None) -> None:
        raise SystemExit(INTERRUPTED)

    with suppress(ValueError):  # not in the main thread
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else a shell has it ignored
            signal.signal(signal.SIGINT, handler)


def broken(stream: Any) -> bool:
    """Return whether Click or Typer has found a stream's reader gone; they then end with exit code 1."""
    return type(stream).__name__ == "PacifyFlushWrapper"


def flushed(code: int) -> int:
    """Write what is left in the streams; return the exit code, which says so where that cannot be done."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        code = code or BROKEN
    except OSError as error:
        code = code or 1
        with suppress(OSError):
            sys.stderr.write(f"curvesqueal: standard output: cannot be written: {error.strerror}\n")
    with suppress(OSError):
        sys.stderr.flush()
    return code
