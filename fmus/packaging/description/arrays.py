"""Numbered variables of a component, such as frequency_001 to frequency_031, seen as one array."""

from __future__ import annotations

import re
from dataclasses import dataclass

from ...component import Component, Variable

_NUMBERED = re.compile(r"(.+)_(\d{3,})")


@dataclass(frozen=True)
class Array:
    """One or several successive variables of a component.

    Attributes
    ----------
    name : common name
    first : position of the first in `Component.variables`
    variables : the variables; exactly one if it is a scalar
    """

    name: str
    first: int
    variables: tuple[Variable, ...]

    @property
    def is_scalar(self) -> bool:
        """Whether this is a variable on its own, with the name that it has."""
        return self.name == self.variables[0].name


def arrays(component: Component) -> list[Array]:
    """Return the variables of a component, numbered ones of one name gathered, in order."""
    groups: list[Array] = []
    for position, variable in enumerate(component.variables):
        match = _NUMBERED.fullmatch(variable.name)
        last = groups[-1] if groups else None
        if match and last and last.name == match.group(1) and int(match.group(2)) == len(last.variables) + 1:
            groups[-1] = Array(last.name, last.first, (*last.variables, variable))
        elif match and int(match.group(2)) == 1:
            groups.append(Array(match.group(1), position, (variable,)))
        else:
            groups.append(Array(variable.name, position, (variable,)))
    return groups
