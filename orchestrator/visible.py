"""Text from files as a terminal or a picture may have it: what would steer the terminal, or has no letter, in words."""

from __future__ import annotations

import re

_STEERING = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters but for tab and new line, changes of writing direction, and bytes of names that are no UTF-8."""


def visible(text: str) -> str:
    r"""Return a text in which every character is one that can be shown.

    >>> print(visible("rail\x1b[31m"), visible("M\u00fcller"))
    rail\x1b[31m Müller
    """
    return _STEERING.sub(lambda found: found.group().encode("unicode_escape", "surrogatepass").decode(), text)
