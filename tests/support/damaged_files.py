"""Files compared, cut and flipped."""

from __future__ import annotations

import re
from pathlib import Path


def numbers(path: Path) -> bytes:
    """Return the bytes of a results file but for what only one run has: its random digits, the header's checksum."""
    data = path.read_bytes()
    data = re.sub(rb"(run\x00.{4,12}?)[0-9a-f]{32}", rb"\1" + b"0" * 32, data, count=1, flags=re.DOTALL)
    return re.sub(rb"crc32:[0-9a-f]{8}", b"crc32:", data, count=1)
