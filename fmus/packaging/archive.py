"""Zip files with the same bytes for the same content: sorted names, fixed dates, fixed attributes."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Mapping
from pathlib import Path

_DATE = (1980, 1, 1, 0, 0, 0)


def write_files(files: Mapping[str, bytes], target: Path) -> None:
    """Write a zip file with the given contents by name; whoever reads `target` meanwhile finds a whole one."""
    partial = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(partial, "w") as archive:
            for name in sorted(files):
                info = zipfile.ZipInfo(name, _DATE)
                info.compress_type = zipfile.ZIP_DEFLATED
                info.create_system = 3  # Unix on every platform, so that the bytes agree
                info.external_attr = 0o644 << 16
                archive.writestr(info, files[name], compresslevel=9)
        partial.replace(target)
    finally:
        partial.unlink(missing_ok=True)


def write_archive(source: Path, target: Path, more: Mapping[str, bytes]) -> None:
    """Write the content of zip file `source`, and `more` files, to `target`; byte code is left out."""
    with zipfile.ZipFile(source) as archive:
        files = {name: archive.read(name) for name in archive.namelist() if "__pycache__" not in name}
    write_files({**files, **more}, target)
