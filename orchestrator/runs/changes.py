"""What differs from a system: values, FMUs, a rail, a wheel and damping as a user names them; a scenario out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..fmi.instance import Value
from ..system.kept import rail_named
from .scenario import Scenario
from .treatments import damping_values, wheel_named


@dataclass(frozen=True)
class Changes:
    """What a user changes of a system, the same for every command.

    Attributes
    ----------
    values : parameter values by component and name
    sources : FMU files that take a component's place
    rail, wheel : an .fmu, or a name or file of which one is made; they win over `sources`
    damp : rules such as '(3,0)=1e-3'
    """

    values: Mapping[str, Mapping[str, Value]] = field(default_factory=dict)
    sources: Mapping[str, Path] = field(default_factory=dict)
    rail: str | None = None
    wheel: str | None = None
    damp: tuple[str, ...] = ()

    @property
    def any(self) -> bool:
        """Whether something is changed."""
        return self != Changes()

    @property
    def only_contact(self) -> bool:
        """Whether wheel and rail are as the system has them, or as `rail`, `wheel` and `sources` name them."""
        return not self.damp and self.values.keys() <= {"contact"}

    def resolved(self, system: str) -> tuple[dict[str, dict[str, Value]], dict[str, Path]]:
        """Return parameter values and FMU files that mean the same.

        A wheel by name brings the stiffness of its contact, which a value of the user's own overrules.
        """
        values = {name: dict(own) for name, own in self.values.items()}
        sources = dict(self.sources)
        if self.rail is not None:
            sources["rail"] = rail_named(self.rail)
        if self.wheel is not None:
            sources["wheel"], contact = wheel_named(self.wheel)
            if contact:
                values["contact"] = {**contact, **values.get("contact", {})}
        return (damping_values(system, sources, values, self.damp) if self.damp else values), sources

    def scenario(self, system: str, **how: Any) -> Scenario:
        """Return the scenario of the changed system; `how` as `Scenario` has it."""
        values, sources = self.resolved(system)
        return Scenario(system, values=values, sources=sources, **how).absolute()
