"""A process that has loaded PythonFMU FMUs ends without their destructors.

All libraries of PythonFMU 0.7.0 in a process share one C++ object, and each destroys it when the process ends: glibc
then aborts with "corrupted double-linked list", after everything went well.
"""

from __future__ import annotations

import ctypes
import os
import signal
import sys
from pathlib import Path
from typing import Any


def guard_exit(fmu_folder: Path, file: Path) -> None:
    """Let the process end before the destructors of the FMU libraries that are loaded now, if PythonFMU made this one.

    What is registered last runs first: C streams are flushed and closed, then the process is left with its exit status.
    """
    _FILES[str(fmu_folder)] = file
    if sys.platform != "linux" or not (fmu_folder / "resources" / "slavemodule.txt").is_file():
        return
    libc = ctypes.CDLL(None)
    if hasattr(libc, "on_exit"):  # glibc
        libc.on_exit(libc._exit, None)
        libc.on_exit(libc.fcloseall, None)


_FILES: dict[str, Path] = {}
"""Files of the FMUs whose libraries are loaded, by the folder that they are unpacked in."""

_KEPT: list[Any] = []
"""Callbacks that the C library has the addresses of."""

FAILED = 1
"""Exit code of a process that an FMU ended by itself."""

_CRASHES = (signal.SIGSEGV, signal.SIGBUS, signal.SIGFPE, signal.SIGILL, signal.SIGABRT)


class _Place(ctypes.Structure):
    """What `dladdr` says of an address."""

    _fields_ = (
        ("file", ctypes.c_char_p), ("base", ctypes.c_void_p), ("name", ctypes.c_char_p), ("address", ctypes.c_void_p),
    )  # fmt: skip


def tell_who_ends_the_process() -> None:
    """Say which FMU calls exit() or crashes, in a process that itself always ends with `os._exit`.

    A crash still ends the process by its signal; exit(0) is a failure like any other.
    """
    if not sys.platform.startswith("linux"):
        return
    libc = ctypes.CDLL(None)
    if not (hasattr(libc, "on_exit") and hasattr(libc, "backtrace")):  # not glibc
        return
    libc.signal.restype = ctypes.c_void_p
    libc.signal.argtypes = (ctypes.c_int, ctypes.c_void_p)

    def exited(status: int, _argument: int | None) -> None:
        _say(f"{_culprit(libc)} ended the process by exit({status}); what was recorded until then is in the results")
        os._exit(FAILED)

    def crashed(number: int) -> None:
        libc.signal(number, None)
        name = signal.Signals(number).name
        _say(f"{_culprit(libc)} crashed ({name}); isolated, it would not take the run along")
        libc["raise"](number)  # waits until this returns: an FMU that raised the signal itself would go on

    ending = ctypes.CFUNCTYPE(None, ctypes.c_int, ctypes.c_void_p)(exited)
    crash = ctypes.CFUNCTYPE(None, ctypes.c_int)(crashed)
    _KEPT.extend((ending, crash))
    libc.on_exit(ending, None)
    for number in _CRASHES:
        libc.signal(number, ctypes.cast(crash, ctypes.c_void_p))


def _say(sentence: str) -> None:
    os.write(2, f"curvesqueal: {sentence}\n".encode(errors="replace"))


def _culprit(libc: Any) -> str:
    """Return the FMU whose code is on the stack, the innermost one."""
    frames = (ctypes.c_void_p * 64)()
    for frame in frames[: libc.backtrace(frames, len(frames))]:
        place = _Place()
        if frame and libc.dladdr(ctypes.c_void_p(frame), ctypes.byref(place)) and place.file:
            library = os.fsdecode(place.file)
            for folder, file in _FILES.items():
                if library.startswith(folder + os.sep):
                    return f"the FMU {file}"
    return "an FMU or a library"
