"""One row of a campaign: what a run gave, and what its numbers are called and measured in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Number = float | str | NDArray[np.float64]

WAITING, DONE, FAILED = 0, 1, 2


@dataclass(frozen=True)
class Quantity:
    """A number that a stage gives.

    Attributes
    ----------
    name : of the variable in the store
    unit : SI, "1" for none, "" for a text
    words : what it is
    size : numbers of it per row along a dimension `place`; None: one
    lacks : whether it may be missing in a run that is all right
    """

    name: str
    unit: str
    words: str
    size: int | None = None
    lacks: bool = False

    @property
    def text(self) -> bool:
        """Whether it is a text."""
        return not self.unit


@dataclass(frozen=True)
class Row:
    """What came out at one point.

    Attributes
    ----------
    index : of the point in the plan
    status : `DONE` or `FAILED`
    identity : hash of the resolved scenario; empty if it could not be resolved
    message : why it failed, one sentence
    values : by the names of quantities
    seconds : wall time
    """

    index: int
    status: int
    identity: str = ""
    message: str = ""
    values: Mapping[str, Number] = field(default_factory=dict)
    seconds: float = 0.0
