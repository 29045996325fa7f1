"""Numbered variables of a component, such as frequency_001 to frequency_031, seen as one array."""

from __future__ import annotations

from dataclasses import dataclass

from ...component import Component, Variable
from ...modal.parameters import numbered


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
        key = numbered(variable.name)
        last = groups[-1] if groups else None
        if key and last and last.name == key[0] and key[1] == len(last.variables) + 1:
            groups[-1] = Array(last.name, last.first, (*last.variables, variable))
        elif key and key[1] == 1:
            groups.append(Array(key[0], position, (variable,)))
        else:
            groups.append(Array(variable.name, position, (variable,)))
    return groups


def scalars(component: Component) -> list[Array]:
    """Return every variable of a component on its own, in order: for hosts that know no arrays."""
    return [Array(variable.name, position, (variable,)) for position, variable in enumerate(component.variables)]
