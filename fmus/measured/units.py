"""Units of measured functions: texts such as 'mm/s/N' in, quantity and factor to SI out, by the library pint."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from ..errors import DataError

QUANTITIES = {"receptance": 0, "mobility": 1, "accelerance": 2}
"""What is given per unit force, and the power of j omega that it has more than a receptance."""

TRANSLATIONS = ("lon", "lat", "ver")


@dataclass(frozen=True)
class Ratio:
    """The unit of a motion per force.

    Attributes
    ----------
    text : as it was written
    factor : what values are multiplied with to be in SI
    quantity : key of `QUANTITIES`
    rotations : 0 for translation per force, 2 for rotation per moment, 1 for one of the two
    """

    text: str
    factor: float
    quantity: str
    rotations: int


@dataclass(frozen=True)
class UnitSystem:
    """The units of length and force that a file is written in.

    Attributes
    ----------
    length, force : units in one metre and one newton, as in data set 164
    source : where this is said
    """

    length: float
    force: float
    source: str

    def factor(self, response: str, reference: str) -> float:
        """Return what values of a function between two directions are multiplied with to be in SI."""
        motion = 1.0 / self.length if response in TRANSLATIONS else 1.0
        load = 1.0 / self.force if reference in TRANSLATIONS else 1.0 / (self.force * self.length)
        return motion / load

    def text(self, response: str, reference: str) -> str:
        """Return the unit as a text, such as '0.001 m per 1 N', without the powers of time."""
        motion = f"{1 / self.length:.6g} m" if response in TRANSLATIONS else "1 rad"
        load = f"{1 / self.force:.6g} N" if reference in TRANSLATIONS else f"{1 / self.force / self.length:.6g} N m"
        return f"{motion} per {load}"


def rotations(response: str, reference: str) -> int:
    """Return how many of two directions are rotations."""
    return sum(direction not in TRANSLATIONS for direction in (response, reference))


def read_ratio(text: str) -> Ratio:
    """Return what a unit of a motion per force says.

    Raises
    ------
    DataError
        If it is no unit, or none of a displacement, velocity or acceleration per force.

    Examples
    --------
    >>> read_ratio("mm/s/N")
    Ratio(text='mm/s/N', factor=0.001, quantity='mobility', rotations=0)
    >>> read_ratio("g/N").factor  # acceleration of gravity, not grams
    9.80665
    >>> read_ratio("rad/s/(N*m)").rotations
    2
    """
    for written in (text, re.sub(r"(?<![A-Za-z])g(?![A-Za-z])", "standard_gravity", text)):
        factor, dimension = _base(written)
        time = dimension.get("[time]", 0) - 2
        length = dimension.get("[length]", 0)
        if set(dimension) <= {"[mass]", "[time]", "[length]"} and dimension.get("[mass]") == -1:
            for quantity, power in QUANTITIES.items():
                if time == -power and length in (0, -1, -2):
                    return Ratio(text, factor, quantity, -int(length))
    raise DataError(f"unit {text!r} is no displacement, velocity or acceleration per force")


def frequency_factor(text: str) -> float:
    """Return what frequencies in a unit are multiplied with to be in Hz; rad/s is an angular frequency.

    >>> frequency_factor("kHz"), round(frequency_factor("rad/s"), 6)
    (1000.0, 0.159155)
    """
    angular = "rad" in text
    factor, dimension = _base(text)
    if dimension != {"[time]": -1}:
        raise DataError(f"unit {text!r} is no frequency")
    return factor / (2 * math.pi) if angular else factor


def velocity_factor(text: str) -> float:
    """Return what velocities in a unit are multiplied with to be in m/s.

    >>> velocity_factor("mm/s"), round(velocity_factor("km/h"), 6)
    (0.001, 0.277778)
    """
    factor, dimension = _base(text)
    if dimension != {"[length]": 1, "[time]": -1}:
        raise DataError(f"unit {text!r} is no velocity")
    return factor


def read_system(text: str) -> UnitSystem:
    """Return the units that a text such as 'mm,N' names.

    >>> read_system("mm,mN").length
    1000.0
    """
    units = [part.strip() for part in text.split(",")]
    wanted = ({"[length]": 1}, {"[mass]": 1, "[length]": 1, "[time]": -2})
    if len(units) != 2:
        raise DataError(f"units {text!r}: must be a unit such as m/s/N, or those of length and force such as mm,N")
    factors = []
    for unit, dimension, word in zip(units, wanted, ("length", "force"), strict=True):
        factor, found = _base(unit)
        if found != dimension:
            raise DataError(f"units {text!r}: {unit!r} is no {word}")
        factors.append(factor)
    return UnitSystem(round(1 / factors[0], 9), round(1 / factors[1], 9), f"units {text}")


@cache
def _registry() -> Any:
    from pint import UnitRegistry  # noqa: PLC0415 - slow to import, and only files with units need it

    return UnitRegistry()


@cache
def _base(text: str) -> tuple[float, dict[str, float]]:
    """Return factor to SI and dimensions of a unit; `m/s2` and `N.m` are read as they are meant."""
    plain = text.strip().replace("²", "^2").replace("·", "*").replace("µ", "u")
    plain = re.sub(r"(?<=[A-Za-z])\.(?=[A-Za-z])", "*", plain)
    plain = re.sub(r"(?<=[A-Za-z])(-?\d+)", r"**\1", plain)
    try:
        quantity = _registry().Quantity(1.0, plain).to_base_units()
    except Exception:  # pint lets pass whatever Python's tokeniser raises
        raise DataError(f"{text!r} is no unit") from None
    return float(quantity.magnitude), {k: float(v) for k, v in quantity.dimensionality.items()}
