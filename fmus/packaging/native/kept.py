"""Compiled files kept between builds, under the hash of everything that they are made from.

The same content gives the same bytes, so a kept file is the one that a compiler would write. A folder that cannot be
written, or a damaged file, costs a compilation and nothing else.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from ...cache import cache_folder, mark_used

NOTHING_KEPT = "CURVESQUEAL_BUILD_ANEW"
"""The variable of the environment that, if it is set, makes every build compile."""

_MARK = 32


def key_of(parts: Iterable[str | bytes]) -> str:
    """Return the name under which a file made from `parts` is kept; their order and borders count.

    >>> key_of(["ab", "c"]) == key_of(["a", "bc"])
    False
    """
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode() if isinstance(part, str) else part
        digest.update(len(data).to_bytes(8, "big") + data)
    return digest.hexdigest()


def kept(key: str) -> bytes | None:
    """Return the content of a kept file; None if there is none, or it is not what was written."""
    if os.environ.get(NOTHING_KEPT):
        return None
    with suppress(OSError):
        path = cache_folder("compiled") / key
        stored = path.read_bytes()
        mark_used(path)
        if hashlib.sha256(stored[_MARK:]).digest() == stored[:_MARK]:
            return stored[_MARK:]
    return None


def keep(key: str, content: bytes) -> None:
    """Keep a content, with its checksum, where that is possible; readers meet the whole file or none."""
    with suppress(OSError):
        folder = cache_folder("compiled")
        handle, name = tempfile.mkstemp(dir=folder)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(hashlib.sha256(content).digest() + content)
            Path(name).replace(folder / key)
        except OSError:
            Path(name).unlink(missing_ok=True)
