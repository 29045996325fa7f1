"""What a user says about files of measured functions, where these do not say it themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..errors import DataError
from ..interface import DIRECTIONS
from .units import QUANTITIES

DEFAULT_AXES: dict[int, str] = {1: "lon", 2: "lat", 3: "ver", 6: "spin"}
"""Directions of the codes of universal files unless told otherwise; signs of other codes cancel at one point."""


@dataclass(frozen=True)
class Choice:
    """What a user says about files of measured functions.

    Attributes
    ----------
    quantity : 'receptance', 'mobility' or 'accelerance' where the file does not say it
    units : unit of the functions ('mm/s/N'), or units of length and force ('mm,N'), where the file does not say them
    node : which driving point, where there are several
    axes : direction of each signed direction code; empty: `DEFAULT_AXES`
    start_hz, stop_hz : band that is used; None: as far as the data go
    """

    quantity: str | None = None
    units: str | None = None
    node: int | None = None
    axes: Mapping[int, str] = field(default_factory=dict)
    start_hz: float | None = None
    stop_hz: float | None = None

    def __post_init__(self) -> None:
        """Check what can be checked without a file."""
        if self.quantity is not None and self.quantity not in QUANTITIES:
            raise DataError(f"quantity is {self.quantity!r}; must be one of {', '.join(QUANTITIES)}")
        twice = [d for d in self.axes.values() if list(self.axes.values()).count(d) > 1]
        if twice:
            raise DataError(f"axes: two codes are {twice[0]}; must be one")
        if self.start_hz is not None and self.stop_hz is not None and not self.start_hz < self.stop_hz:
            raise DataError(f"band from {self.start_hz:g} to {self.stop_hz:g} Hz; must increase")

    def direction(self, code: int | str) -> tuple[str, float] | None:
        """Return direction and sign of a code, None for a code that is not used.

        >>> Choice(axes={-1: "lon"}).direction(1)
        ('lon', -1.0)
        """
        if isinstance(code, str):
            return code, 1.0
        axes = self.axes or DEFAULT_AXES
        for sign in (1, -1):
            if sign * code in axes:
                return axes[sign * code], float(sign)
        return None


def read_axes(texts: Sequence[str]) -> dict[int, str]:
    """Return the directions by signed code that texts such as '3=lat' or '-1=lon' give.

    >>> read_axes(["3=lat", "-1=lon"])
    {3: 'lat', -1: 'lon'}
    """
    axes: dict[int, str] = {}
    for text in texts:
        code, _, direction = text.partition("=")
        if not code.lstrip("+-").isdigit() or not 1 <= abs(int(code)) <= 6 or direction not in DIRECTIONS:
            raise DataError(f"axis {text}: must be CODE=DIRECTION with 1 to 6, -1 to -6 and {', '.join(DIRECTIONS)}")
        if int(code) in axes or -int(code) in axes:
            raise DataError(f"axis {text}: axis {abs(int(code))} is given twice")
        if (abs(int(code)) > 3) != (direction == "spin"):
            raise DataError(f"axis {text}: codes 1 to 3 are translations, 4 to 6 rotations; spin is a rotation")
        axes[int(code)] = direction
    return axes
