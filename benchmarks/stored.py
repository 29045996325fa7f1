"""Results of benchmarks in one file, a section per script: heading and lines in, `RESULTS.md` out."""

from __future__ import annotations

import re
from pathlib import Path

RESULTS = Path(__file__).parent / "RESULTS.md"


def store(heading: str, lines: list[str]) -> None:
    """Put a section into the file, in the place of the one with the same heading."""
    text = RESULTS.read_text(encoding="utf-8") if RESULTS.exists() else ""
    sections = re.split(r"^(?=# )", text, flags=re.MULTILINE)
    new = "\n".join([f"# {heading}", "", *lines]) + "\n"
    places = [k for k, section in enumerate(sections) if section.startswith(f"# {heading}\n")]
    if places:
        sections[places[0]] = new
    else:
        sections.append(new)
    RESULTS.write_text("\n".join(s.rstrip("\n") + "\n" for s in sections if s.strip()), encoding="utf-8")
