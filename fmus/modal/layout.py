"""Where the kernels of a modal structure find what: blocks of parameters and tables."""

from __future__ import annotations

from ..interface import (
    PAIRS,
)

_BLOCKS = 7

_TABLES = 6

N_MOBILITIES = len(PAIRS)
