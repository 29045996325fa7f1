"""The folder for what is worth keeping between runs: of this user alone, without what nobody has used for long.

Unpacked FMUs, kernels that Numba compiled, compiled libraries, built cases, rails and wheels, FMUs of campaigns.

Libraries are loaded from it. So it is never one that somebody else can write to, and where no such folder is to be had
(no home, a read-only one), a temporary one serves.
"""

from __future__ import annotations

import atexit
import os
import shutil
import stat
import tempfile
import time
from contextlib import suppress
from functools import cache
from pathlib import Path

from platformdirs import user_cache_path

UNUSED = 60 * 24 * 3600.0
"""Time after which something that was not used is removed [s]."""


def cache_folder(kind: str) -> Path:
    """Return the folder for things of a kind; CURVESQUEAL_CACHE names another place for all of them."""
    folder = _root(os.environ.get("CURVESQUEAL_CACHE") or str(user_cache_path("curvesqueal"))) / kind
    folder.mkdir(parents=True, exist_ok=True)
    _prune_once(folder)
    return folder


@cache
def _prune_once(folder: Path) -> None:
    """Prune a folder, once in a process."""
    prune(folder)


def mark_used(path: Path) -> None:
    """Remember that something in the cache is in use."""
    with suppress(OSError):
        os.utime(path)


def prune(folder: Path) -> None:
    """Remove what lies in a folder of the cache and was not used for long."""
    limit = time.time() - UNUSED
    with suppress(OSError):
        for path in folder.iterdir():
            if path.lstat().st_mtime < limit:
                _remove(path)


def _remove(path: Path) -> None:
    with suppress(OSError):
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            path.unlink()


@cache
def _root(wanted: str) -> Path:
    """Return the first place that only this user can write to: the wanted one, one in the temporary folder, a new one.

    PythonFMU cannot load from a path with `#`, `%` or letters outside ASCII.
    """
    own = f"curvesqueal-{os.getuid()}" if hasattr(os, "getuid") else "curvesqueal"
    for folder in (Path(wanted).absolute(), Path(tempfile.gettempdir()) / own):
        text = str(folder)
        if text.isascii() and not set("#%") & set(text) and _private(folder):
            return folder
    temporary = Path(tempfile.mkdtemp(prefix="curvesqueal-"))
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    return temporary


def _private(folder: Path) -> bool:
    """Return whether a folder is there, or can be made, that belongs to this user and nobody else can write to."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        found = folder.lstat()  # a link could be bent to another place later
        if stat.S_ISLNK(found.st_mode) and folder.parent == Path(tempfile.gettempdir()):
            return False
        found = folder.stat()
        if hasattr(os, "getuid") and found.st_uid != os.getuid():
            return False
        if os.name == "posix" and found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
            folder.chmod(0o700)
        with tempfile.NamedTemporaryFile(dir=folder):
            return True
    except OSError:
        return False
