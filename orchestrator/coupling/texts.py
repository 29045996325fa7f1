"""Connections that are no sums of products: of texts, and those that look values up in a mapping table.

The compiled loop knows numbers only. Where it would call the function that gets or sets numbers, it calls one from here
that gets or sets the texts of a component, and the inputs of a component that tables feed.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import SimulationError
from ..fmi.instance import FmuInstance, Value
from ..system.tables import told
from .assembly import Assembly
from .bonds import Link

_ERROR = 3
_POINTER = ctypes.c_void_p


@dataclass
class Texts:
    """The texts that a system exchanges, and the values that it looks up.

    Attributes
    ----------
    instances : by component
    sources : for each component the outputs that feed others
    targets : for each component its inputs, each with the connection that feeds it
    values : the latest texts, and values to look up as whole numbers, by component and output
    """

    instances: Mapping[str, FmuInstance]
    sources: dict[str, list[str]] = field(default_factory=dict)
    targets: dict[str, dict[str, Link]] = field(default_factory=dict)
    values: dict[tuple[str, str], str | int] = field(default_factory=dict)
    _functions: dict[tuple[str, str], Any] = field(default_factory=dict)
    _tables: dict[tuple[str, str], dict[int, int]] = field(default_factory=dict)

    @classmethod
    def of(cls, assembly: Assembly, instances: Mapping[str, FmuInstance]) -> Texts:
        """Return the texts of a system."""
        found = cls(instances)
        for link in assembly.links:
            wire = link.wire
            if link.lookup is not None:
                found._tables[wire.end_element, wire.end_connector] = dict(link.lookup.numbers)
            elif assembly.fmus[wire.end_element].variables[wire.end_connector].type != "String":
                continue
            found.targets.setdefault(wire.end_element, {})[wire.end_connector] = link
            outputs = found.sources.setdefault(wire.start_element, [])
            if wire.start_connector not in outputs:
                outputs.append(wire.start_connector)
        return found

    def looks_up(self, component: str, name: str) -> bool:
        """Return whether an input is fed by a table."""
        return (component, name) in self._tables

    def function(self, component: str, direction: str) -> int:
        """Return the address of what stands for an FMI function that sets or gets; 0 if there is nothing to do."""
        if component not in (self.targets if direction == "Set" else self.sources):
            return 0
        key = (component, direction)
        if key not in self._functions:
            extra = [ctypes.c_size_t] if self.instances[component].fmu.version == 3 else []
            kind = ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _POINTER, ctypes.c_size_t, _POINTER, *extra)
            self._functions[key] = kind(self._setter(component) if direction == "Set" else self._getter(component))
        return ctypes.cast(self._functions[key], _POINTER).value or 0

    def refresh(self) -> None:
        """Get all texts anew."""
        for component in self.sources:
            self._getter(component)()

    def _getter(self, component: str) -> Any:
        instance = self.instances[component]
        known = instance.fmu.variables
        texts = [name for name in self.sources[component] if known[name].type == "String"]
        words = [name for name in self.sources[component] if known[name].type != "String"]

        places = [(component, name) for name in texts + words]

        def get(*_: Any) -> int:
            try:
                found: list[str | int] = [*instance.get_texts(texts), *instance.get_words(words)]
            except SimulationError:
                return _ERROR
            self.values.update(zip(places, found, strict=True))
            return 0

        return get

    def _setter(self, component: str) -> Any:
        def put(*_: Any) -> int:
            try:
                known = {name: self._brought(link) for name, link in self.targets[component].items() if self._has(link)}
                self.instances[component].set(known)
            except SimulationError:
                return _ERROR
            return 0

        return put

    def _has(self, link: Link) -> bool:
        """Return whether the output of a connection has been got yet."""
        return (link.wire.start_element, link.wire.start_connector) in self.values

    def _brought(self, link: Link) -> Value:
        """Return what a connection brings now.

        Raises
        ------
        SimulationError
            If the table has no entry for it; the component's last message says so.
        """
        wire = link.wire
        value = self.values[wire.start_element, wire.start_connector]
        table = self._tables.get((wire.end_element, wire.end_connector))
        if table is None or isinstance(value, str):
            return value
        if value not in table:
            fmu, instance = self.instances[wire.start_element].fmu, self.instances[wire.end_element]
            named = told(value, fmu, fmu.variables[wire.start_connector])
            instance.messages.append(f"connection {wire}: the mapping table has no MapEntry for {named}")
            raise SimulationError(instance.messages[-1])
        return table[value]
