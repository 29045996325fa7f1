"""What of a system can be set: its FMUs in, names, ranges and values out; and values for many names at once."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from fmus.modal.layout import DAMPING_RATIO
from fmus.modal.parameters import names_of

from ..errors import InputError
from ..fmi.instance import Fmu, Value
from .friction import with_friction

_SETTABLE = ("parameter", "structuralParameter", "input")


@dataclass(frozen=True)
class Settable:
    """A variable that can be given a value before a run.

    Attributes
    ----------
    name : component and variable
    type, unit, start, minimum, maximum : as the FMU has them; None if it does not tell
    description : of the FMU; for a parameter of a mode it names the mode
    """

    name: str
    type: str
    unit: str | None
    start: Any
    minimum: Any
    maximum: Any
    description: str


def settable(fmus: Mapping[str, Fmu]) -> Iterator[Settable]:
    """Yield what can be set, component by component, in the order of the descriptions."""
    for component, fmu in fmus.items():
        for v in fmu.variables.values():
            if v.causality in _SETTABLE:
                yield Settable(
                    f"{component}.{v.name}", v.type, fmu.unit(v.name), v.start, v.min, v.max, v.description or ""
                )


def spread(values: Mapping[str, Mapping[str, Value]], fmus: Mapping[str, Fmu]) -> dict[str, dict[str, Value]]:
    """Return values with each name that has `*` or `?` in it replaced by all that it stands for.

    A value for a name as it is wins over one for many; `friction` of a contact may be a law's name or its file.

    Raises
    ------
    InputError
        If a name stands for nothing that can be set.
    """
    values = with_friction(values, fmus)
    many = [(f"{c}.{n}", value) for c, more in values.items() for n, value in more.items() if _is_pattern(f"{c}{n}")]
    result: dict[str, dict[str, Value]] = {}
    names = [(c, v.name) for c, fmu in fmus.items() for v in fmu.variables.values() if v.causality in _SETTABLE]
    for pattern, value in many:
        matches = re.compile(re.escape(pattern).replace(r"\*", ".*").replace(r"\?", ".")).fullmatch
        found = [(c, n) for c, n in names if matches(f"{c}.{n}")]
        if not found:
            raise InputError(f"{pattern}: stands for nothing that can be set; `curvesqueal info` lists what can")
        for component, name in found:
            result.setdefault(component, {})[name] = value
    for component, more in values.items():
        for name, value in more.items():
            if not _is_pattern(f"{component}{name}"):
                result.setdefault(component, {})[name] = value
    return result


def labels_of(fmu: Fmu) -> list[str]:
    """Return the labels of an FMU's modes, which stand in the descriptions of its damping ratios."""
    names = names_of(DAMPING_RATIO, fmu.variables)
    texts = [str(fmu.variables[name].description or "") for name in names.values()]
    array = {text.partition("one value per mode: ")[2] for text in texts}
    if len(array) == 1 and (labels := array.pop()):
        return labels.split("; ")
    return [text.partition(" of mode ")[2].partition(", ")[2] for text in texts]


def _is_pattern(text: str) -> bool:
    return "*" in text or "?" in text
