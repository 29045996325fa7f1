"""Friction laws by name or file: a name or a file in, parameter values of the contact out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fmus.contact.friction.file import read_friction
from fmus.contact.friction.named import NAMED
from fmus.errors import DataError
from fmus.modal.parameters import as_spelled

from ..errors import InputError
from ..fmi.instance import Value

FRICTION = "friction"
"""What a user sets to a name or a file; it stands for all parameters of a friction law."""


def with_friction(values: Mapping[str, Mapping[str, Value]], fmus: Mapping[str, Any]) -> dict[str, dict[str, Value]]:
    """Return values by component and name, those of friction laws written out where a component has such laws."""
    result = {component: dict(own) for component, own in values.items()}
    for component, own in result.items():
        known = fmus[component].variables if component in fmus else {}
        if FRICTION in own and FRICTION not in known and "friction_law" in known:
            law = str(own.pop(FRICTION))
            result[component] = as_spelled(friction_values(law, own), known)
    return result


def friction_values(text: str, own: Mapping[str, Value] | None = None) -> dict[str, Value]:
    """Return the parameter values of a contact with a friction law.

    Parameters
    ----------
    text : a key of `NAMED`, or a CSV file with columns creepage or velocity, and friction
    own : values that are set besides, which win

    Raises
    ------
    InputError
        For a law that is none, and where a friction coefficient is given beside a table, which has its own.
    """
    path = Path(text)
    if text in NAMED:
        return {**NAMED[text].values, **(own or {})}
    if not path.is_file():
        raise InputError(f"friction {text}: neither one of {', '.join(NAMED)} nor a file")
    try:
        table = read_friction(path)
    except DataError as error:
        raise InputError(str(error)) from None
    if "mu0" in (own or {}):
        raise InputError(f"contact.mu0: friction comes from the table {path.name}, so it has no effect; leave one out")
    return {**table, **(own or {})}
