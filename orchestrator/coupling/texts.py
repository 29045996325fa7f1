"""Connections of texts: an output of type String in, inputs of type String out.

The compiled loop knows numbers only. Where it would call the function that gets or sets numbers, it calls one from here
that gets or sets the texts of a component.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..errors import SimulationError
from ..fmi.instance import FmuInstance
from .assembly import Assembly

_ERROR = 3
_POINTER = ctypes.c_void_p


@dataclass
class Texts:
    """The texts that a system exchanges.

    Attributes
    ----------
    instances : by component
    sources : for each component the outputs that feed others
    targets : for each component its inputs, each with the output that feeds it
    values : the latest texts, by component and output
    """

    instances: Mapping[str, FmuInstance]
    sources: dict[str, list[str]] = field(default_factory=dict)
    targets: dict[str, dict[str, tuple[str, str]]] = field(default_factory=dict)
    values: dict[tuple[str, str], str] = field(default_factory=dict)
    _functions: dict[tuple[str, str], Any] = field(default_factory=dict)

    @classmethod
    def of(cls, assembly: Assembly, instances: Mapping[str, FmuInstance]) -> Texts:
        """Return the texts of a system."""
        found = cls(instances)
        for wire in (link.wire for link in assembly.links):
            if assembly.fmus[wire.end_element].variables[wire.end_connector].type != "String":
                continue
            source = (wire.start_element, wire.start_connector)
            found.targets.setdefault(wire.end_element, {})[wire.end_connector] = source
            outputs = found.sources.setdefault(wire.start_element, [])
            if wire.start_connector not in outputs:
                outputs.append(wire.start_connector)
        return found

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
        def get(*_: Any) -> int:
            names = self.sources[component]
            try:
                texts = self.instances[component].get_texts(names)
            except SimulationError:
                return _ERROR
            self.values.update({(component, name): text for name, text in zip(names, texts, strict=True)})
            return 0

        return get

    def _setter(self, component: str) -> Any:
        def put(*_: Any) -> int:
            known = {name: self.values[s] for name, s in self.targets[component].items() if s in self.values}
            try:
                self.instances[component].set(known)
            except SimulationError:
                return _ERROR
            return 0

        return put
