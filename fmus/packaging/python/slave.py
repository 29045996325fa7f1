"""The body of a Python FMU: an `Instance` behind PythonFMU's slave interface.

An FMU carries a copy of the modules that this one needs, as a package with a name of its own, and the declaration of
its component. No file is read once the
modules are loaded: a second instance must work when the folder of the first one is gone.
"""

from __future__ import annotations

import ctypes
import hashlib
import math
import struct
from collections.abc import Callable
from functools import wraps
from typing import Any, ClassVar, TypeVar, cast
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray
from pythonfmu import Fmi2Slave

from ...component import Component, Instance, Variable
from ..description.fmi2 import model_description


def hold(*objects: object) -> None:
    """Add a reference to each object that is never given back: payment for what PythonFMU 0.7.0 releases too often.

    It executes a slave's script once per instance and each time releases the namespace, which it does not own: without
    this the second instance of an FMU in a process reads freed memory. And it releases an instance, its class and its
    log queue at every exception, and once more when the instance is freed.
    """
    for each in objects:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(each))


_STATE_HEAD = struct.Struct("<?d")
"""What stands before the memory in a serialised state: whether the run has begun, the time reached."""

Method = TypeVar("Method", bound=Callable[..., Any])


def survives_errors(method: Method) -> Method:
    """Let an exception of a slave's method pass without harm to the process; see `hold`."""

    @wraps(method)
    def guarded(slave: ComponentSlave, *arguments: Any) -> Any:
        try:
            return method(slave, *arguments)
        except Exception:
            hold(slave, type(slave), slave.log_queue)
            raise

    return cast(Method, guarded)


class ComponentSlave(Fmi2Slave):  # type: ignore[misc]
    """A component as PythonFMU drives it; a subclass in the FMU names its files.

    Attributes
    ----------
    declaration : the component, see `Component.to_json`
    release : version of the project
    content : identifies the code, see `model_description`
    """

    declaration: ClassVar[str]
    release: ClassVar[str]
    content: ClassVar[str]

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        component = Component.from_json(self.declaration)
        self.instance = Instance(component)
        self.modelName = component.name
        self.running = False
        self.reached = -math.inf
        self._places = np.array(self.instance.places())
        self._resolved: dict[tuple[str, tuple[int, ...]], tuple[NDArray[np.intp], bool]] = {}

    def to_xml(self, *_options: Any) -> Element:
        """Return the model description."""
        return model_description(self.instance.component, self.release, self.content)

    @survives_errors
    def exit_initialization_mode(self) -> None:
        """Start the run."""
        self.instance.initialise()
        self.running = True

    @survives_errors
    def do_step(self, current_time: float, step_size: float) -> bool:
        """Advance by one step; going back takes a kept state."""
        if not step_size > 0.0:
            raise ValueError(f"step size {step_size}: must be > 0")
        if current_time < self.reached - 0.01 * step_size - 1e-12 * abs(current_time):  # hosts round differently
            raise ValueError(f"time {current_time:.12g} s: must not be before {self.reached:.12g} s, which is reached")
        self.instance.do_step(step_size)
        self.reached = current_time + step_size
        return True

    def get_real(self, vrs: list[int]) -> list[float]:
        """Return real variables; in initialisation mode they are calculated on demand."""
        return self._get("Real", vrs)

    def get_integer(self, vrs: list[int]) -> list[int]:
        """Return integer variables."""
        return [int(x) for x in self._get("Integer", vrs)]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return boolean variables."""
        return [bool(x) for x in self._get("Boolean", vrs)]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        """Set real variables."""
        self._set("Real", vrs, values)

    def set_integer(self, vrs: list[int], values: list[int]) -> None:
        """Set integer variables."""
        self._set("Integer", vrs, values)

    def set_boolean(self, vrs: list[int], values: list[bool]) -> None:
        """Set boolean variables."""
        self._set("Boolean", vrs, values)

    @survives_errors
    def _get(self, kind: str, vrs: list[int]) -> list[float]:
        if not self.running:
            self.instance.initialise()
        places, _ = self._resolve(kind, vrs)
        values: list[float] = self.instance.memory[places].tolist()
        if not math.isfinite(sum(values)):
            self._refuse_not_finite(vrs, values)
        return values

    def _refuse_not_finite(self, vrs: list[int], values: list[float]) -> None:
        """Raise ValueError if one of the values is no finite number; their sum may be none even so."""
        for vr, value in zip(vrs, values, strict=True):
            if not math.isfinite(value):
                name = self.instance.component.variables[vr].name
                raise ValueError(f"{name} is not finite; an input or parameter is too large")

    @survives_errors
    def _set(self, kind: str, vrs: list[int], values: list[Any]) -> None:
        places, only_inputs = self._resolve(kind, vrs)
        if not (only_inputs and math.isfinite(sum(values))):
            for vr, value in zip(vrs, values, strict=True):
                self._check_settable(self.instance.component.variables[vr], float(value))
        self.instance.memory[places] = values

    def _check_settable(self, variable: Variable, value: float) -> None:
        """Raise ValueError unless a variable may be set now, to this value."""
        if variable.causality not in ("parameter", "input"):
            raise ValueError(f"{variable.name} is calculated by the component; it cannot be set")
        if self.running and variable.causality == "parameter" and not variable.tunable:
            raise ValueError(f"{variable.name} is a fixed parameter; it cannot be set after initialisation")
        variable.check(value)

    def _resolve(self, kind: str, vrs: list[int]) -> tuple[NDArray[np.intp], bool]:
        """Return where in memory some value references stand, and whether all are inputs.

        Checked once, then remembered for the hot path.
        """
        key = (kind, tuple(vrs))
        found = self._resolved.get(key)
        if found is None:
            for vr in vrs:
                if not 0 <= vr < len(self._places):
                    raise ValueError(f"there is no variable with value reference {vr}")
                variable = self.instance.component.variables[vr]
                if variable.kind != kind:
                    raise TypeError(f"{variable.name} is of type {variable.kind}, not {kind}")
            only_inputs = all(self.instance.component.variables[vr].causality == "input" for vr in vrs)
            found = self._resolved[key] = (self._places[vrs], only_inputs)
        return found

    def _get_fmu_state(self) -> dict[str, Any]:
        return {"snapshot": self.instance.memory.tobytes(), "running": self.running, "reached": self.reached}

    @survives_errors
    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        if not state:
            raise ValueError("these bytes are no state of this FMU, or a damaged one")
        self.instance.memory[:] = np.frombuffer(state["snapshot"])
        self.running = state["running"]
        self.reached = state["reached"]

    @classmethod
    def _fmu_state_to_bytes(cls, state: dict[str, Any]) -> bytes:
        data: bytes = _STATE_HEAD.pack(state["running"], state["reached"]) + state["snapshot"]
        return cls._checksum(data) + data

    @classmethod
    def _fmu_state_from_bytes(cls, state: bytes) -> dict[str, Any]:
        """Return a state; an empty one for other bytes, which `_set_fmu_state` refuses: no exception may pass here."""
        size = len(cls._checksum(b""))
        data = bytes(state[size:])
        if bytes(state[:size]) != cls._checksum(data) or len(data) < _STATE_HEAD.size:
            return {}
        running, reached = _STATE_HEAD.unpack_from(data)
        return {"snapshot": data[_STATE_HEAD.size :], "running": running, "reached": reached}

    @classmethod
    def _checksum(cls, data: bytes) -> bytes:
        """Return a checksum that also tells FMUs apart."""
        return hashlib.sha256(cls.content.encode() + data).digest()
