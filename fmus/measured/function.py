"""What a file of measured functions holds, as it stands there: no units, signs or axes applied yet."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .units import UnitSystem

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

CODES = {1: "+x", 2: "+y", 3: "+z", 4: "+rx", 5: "+ry", 6: "+rz"}
"""Direction codes of universal files; a negative one is the opposite direction."""


@dataclass(frozen=True)
class Place:
    """A degree of freedom: node and direction.

    Attributes
    ----------
    node : number in the file, None where the format knows none
    code : signed direction code of universal files, or a direction of the contract
    """

    node: int | None
    code: int | str

    def __str__(self) -> str:
        """Return it as '7:+z'."""
        name = self.code if isinstance(self.code, str) else code_name(self.code)
        return name if self.node is None else f"{self.node}:{name}"


@dataclass(frozen=True)
class Function:
    """A frequency response as a file holds it.

    Attributes
    ----------
    where : file, data set and line, for messages
    frequency_hz : (m,) frequencies [Hz]
    values : (m,) complex, in the file's unit
    response, reference : where motion and force are
    quantity : what the file's data types say it is, None where they do not
    units : labels of numerator and denominator, '' where there is none
    force : whether the denominator is a force; None where the file does not say
    lines : (m,) line of the file that each value stands on; None where there is none
    """

    where: str
    frequency_hz: Real
    values: Complex
    response: Place
    reference: Place
    quantity: str | None = None
    units: tuple[str, str] = ("", "")
    force: bool | None = True
    lines: NDArray[np.int64] | None = None


@dataclass(frozen=True)
class Contents:
    """What a file holds.

    Attributes
    ----------
    path : the file
    functions : its frequency responses
    coherence : (frequencies, values) by response and reference
    system : its units of length and force, if it says them
    listing : a few words on each thing in it, for refusals
    si : whether values without a unit are in SI because the format says so
    origin : what the file says about itself, '' if nothing
    """

    path: Path
    functions: tuple[Function, ...]
    coherence: dict[tuple[Place, Place], tuple[Real, Real]] = field(default_factory=dict)
    system: UnitSystem | None = None
    listing: tuple[str, ...] = ()
    si: bool = False
    origin: str = ""

    def listed(self) -> str:
        """Return all that is in the file as one text."""
        return "; ".join(self.listing) or "nothing"


def code_name(code: int) -> str:
    """Return the name of a signed direction code.

    >>> code_name(-3)
    '-z'
    """
    name = CODES.get(abs(code), f"+{abs(code)}")
    return name if code >= 0 else "-" + name[1:]
