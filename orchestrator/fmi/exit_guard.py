"""A process that has loaded PythonFMU FMUs ends without their destructors.

All libraries of PythonFMU 0.7.0 in a process share one C++ object, and each destroys it when the process ends: glibc
then aborts with "corrupted double-linked list", after everything went well.
"""

from __future__ import annotations

import ctypes
import sys
from pathlib import Path


def guard_exit(fmu_folder: Path) -> None:
    """Let the process end before the destructors of the FMU libraries that are loaded now, if PythonFMU made this one.

    What is registered last runs first: C streams are flushed and closed, then the process is left with its exit status.
    """
    if sys.platform != "linux" or not (fmu_folder / "resources" / "slavemodule.txt").is_file():
        return
    libc = ctypes.CDLL(None)
    if hasattr(libc, "on_exit"):  # glibc
        libc.on_exit(libc._exit, None)
        libc.on_exit(libc.fcloseall, None)
