"""Numba's cache with checksums: a damaged, cut or empty file costs a compilation; so does one that cannot be kept.

Numba takes its files as they are. A cut one ends the program, and a flipped bit in machine code is run.
"""

from __future__ import annotations

import hashlib
import pickle
from contextlib import suppress
from pathlib import Path
from typing import Any

from numba.core.caching import IndexDataCacheFile

_DIGEST = 32


class CheckedFiles(IndexDataCacheFile):
    """The index of a function and the files of its machine code, as Numba has them, with a checksum before each."""

    def load(self, key: Any) -> Any:
        """Return what is kept under a key; None if there is nothing or it is not what was written."""
        with suppress(Exception):  # pickles of another version raise whatever they like
            return super().load(key)  # type: ignore[no-untyped-call]
        return None

    def save(self, key: Any, data: Any) -> None:
        """Keep something where that is possible."""
        with suppress(OSError):
            super().save(key, data)  # type: ignore[no-untyped-call]

    def _load_index(self) -> dict[Any, str]:
        with suppress(Exception):
            version, stamp, overloads = pickle.loads(_checked(self._index_path))
            if (version, stamp) == (self._version, self._source_stamp):
                return dict(overloads)
        return {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        self._write(self._index_path, (self._version, self._source_stamp, overloads))

    def _load_data(self, name: str) -> Any:
        return pickle.loads(_checked(self._data_path(name)))

    def _save_data(self, name: str, data: Any) -> None:
        self._write(self._data_path(name), data)

    def _write(self, path: str, content: Any) -> None:
        data = self._dump(content)
        with self._open_for_write(path) as file:
            file.write(hashlib.sha256(data).digest() + data)


def _checked(path: str) -> bytes:
    """Return the content of a file; raise OSError if it is not what was written."""
    stored = Path(path).read_bytes()
    if hashlib.sha256(stored[_DIGEST:]).digest() != stored[:_DIGEST]:
        raise OSError("damaged")
    return stored[_DIGEST:]


def check_files(function: Any) -> None:
    """Let a function that Numba compiles keep its machine code with checksums."""
    kept = function._cache
    kept._cache_file = CheckedFiles(kept._cache_path, kept._impl.filename_base, kept._impl.locator.get_source_stamp())
