"""Figures of the reliability tests: in full numbers they go into docs/reliability.md, else the tests are short."""

from __future__ import annotations

import os
import re
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "reliability.md"
FULL = bool(os.environ.get("CURVESQUEAL_RELIABILITY"))
"""Whether the tests run in full number and write what they find."""

_TABLE = re.compile(r"(<!-- figures -->\n)(.*?)(<!-- end of figures -->)", re.DOTALL)
_HEAD = "| what | tried | found |\n| --- | --- | --- |\n"


def count(short: int, full: int) -> int:
    """Return how often something is tried."""
    return full if FULL else short


def write_figure(what: str, tried: str, found: str) -> None:
    """Put a row into the table of the page, in the place of the one about the same matter."""
    if not FULL:
        return
    text = PAGE.read_text(encoding="utf-8")
    match = _TABLE.search(text)
    assert match is not None
    rows = dict.fromkeys(match.group(2).splitlines()[2:])
    kept = [row for row in rows if not row.startswith(f"| {what} |")]
    table = "\n".join(sorted([*kept, f"| {what} | {tried} | {found} |"]))
    PAGE.write_text(text[: match.start(2)] + _HEAD + table + "\n" + text[match.end(2) :], encoding="utf-8")
