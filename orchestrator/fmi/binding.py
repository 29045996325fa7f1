"""The calls of an FMU library in FMI 2.0 and 3.0 behind one set of names, through FMPy's bindings."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any, ClassVar

import numpy as np
from fmpy import calloc, free
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.fmi3 import FMU3Slave

from .exit_guard import guard_exit
from .file import Fmu, Value

Say = Callable[[str], None]


class Binding:
    """A slave with the calls that the two versions of FMI share; subclasses say what they are called.

    Attributes
    ----------
    suffix : by the variable's type, the end of the names of the functions that set and get it
    layout : by the variable's type, how the functions lay out the values in memory
    """

    version: ClassVar[int]
    suffix: ClassVar[dict[str, str]]
    layout: ClassVar[dict[str, np.dtype[Any]]]
    slave: Any

    def set(self, fmi_type: str, references: Sequence[int], values: Sequence[Value]) -> None:
        """Set variables of one type; all elements of arrays, one after the other."""
        kind = self.layout[fmi_type].kind if fmi_type in self.layout else "O"
        convert: Callable[[Any], Any] = {"f": float, "i": int, "u": int, "b": bool, "O": str}[kind]
        if fmi_type == "Boolean":
            convert = bool
        getattr(self.slave, f"set{self.suffix[fmi_type]}")(references, [convert(value) for value in values])

    def terminate(self) -> None:
        """End the simulation."""
        self.slave.terminate()

    def free(self) -> None:
        """Free the instance."""
        self.slave.freeInstance()

    def abandon(self) -> None:
        """Leave an instance alone that must not be called any more."""

    def exit_initialization_mode(self) -> None:
        """Leave initialisation mode."""
        self.slave.exitInitializationMode()

    def do_step(self, time: float, step: float) -> Any:
        """Make a communication step; return what FMI 3.0 answers to it."""
        return self.slave.doStep(time, step)

    @property
    def handle(self) -> int:
        """The pointer to the instance."""
        return int(self.slave.component)

    def address(self, what: str) -> int:
        """Return the address of a function, such as 'DoStep' or 'GetReal'."""
        function = getattr(self.slave.dll, f"fmi{self.version}{what}")
        return ctypes.cast(function, ctypes.c_void_p).value or 0


class Fmi2(Binding):
    """An FMI 2.0 co-simulation slave."""

    version = 2
    suffix: ClassVar = {
        "Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean", "String": "String",
    }  # fmt: skip
    layout: ClassVar = {
        "Real": np.dtype(np.float64),
        **dict.fromkeys(("Integer", "Enumeration", "Boolean"), np.dtype(np.int32)),
    }
    state_suffix = "FMUstate"

    def __init__(self, fmu: Fmu, name: str, say: Say) -> None:
        def log(_environment: Any, _instance: Any, _status: int, _category: Any, message: bytes) -> None:
            say(message.decode("utf-8", "replace") if message else "")

        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(log)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        self.slave = FMU2Slave(
            guid=fmu.description.guid,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        guard_exit(fmu.folder)

    def instantiate(self) -> None:
        """Make the instance."""
        self.slave.instantiate(callbacks=self._callbacks, loggingOn=True)

    def get(self, fmi_type: str, references: Sequence[int], _count: int) -> list[Any]:
        """Return variables of one type."""
        values: list[Any] = getattr(self.slave, f"get{self.suffix[fmi_type]}")(references)
        return values

    def enter_initialization_mode(self, start: float, stop: float) -> None:
        """Set up the experiment and enter initialisation mode."""
        self.slave.setupExperiment(startTime=start, stopTime=stop)
        self.slave.enterInitializationMode()

    def get_state(self) -> Any:
        """Return the state, to be freed."""
        return self.slave.getFMUstate()

    def set_state(self, state: Any) -> None:
        """Set the state."""
        self.slave.setFMUstate(state)

    def free_state(self, state: Any) -> None:
        """Free a state."""
        self.slave.freeFMUstate(state)

    def serialise(self, state: Any) -> bytes:
        """Return a state as bytes."""
        data: bytes = self.slave.serializeFMUstate(state)
        return data

    def deserialise(self, data: bytes) -> Any:
        """Return the state of bytes, to be freed."""
        return self.slave.deSerializeFMUstate(data)


class Fmi3(Binding):
    """An FMI 3.0 co-simulation slave without event mode and early return."""

    version = 3
    suffix: ClassVar = {
        **{name: name for name in ("Float64", "Float32", "Boolean", "String")},
        **{f"{sign}Int{bits}": f"{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)},
        "Enumeration": "Int64",
    }
    layout: ClassVar = {
        "Float64": np.dtype(np.float64),
        "Float32": np.dtype(np.float32),
        "Boolean": np.dtype(np.bool_),
        **{f"{sign}Int{bits}": np.dtype(f"{sign}Int{bits}".lower()) for sign in ("", "U") for bits in (8, 16, 32, 64)},
        "Enumeration": np.dtype(np.int64),
    }
    state_suffix = "FMUState"

    def __init__(self, fmu: Fmu, name: str, say: Say) -> None:
        def log(_environment: Any, _status: int, _category: Any, message: bytes) -> None:
            say(message.decode("utf-8", "replace") if message else "")

        self._log = log
        self.slave = FMU3Slave(
            guid=fmu.description.instantiationToken,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName=name,
        )

    def instantiate(self) -> None:
        """Make the instance."""
        self.slave.instantiate(loggingOn=True, logMessage=self._log)

    def get(self, fmi_type: str, references: Sequence[int], count: int) -> list[Any]:
        """Return variables of one type; all elements of arrays, `count` values together."""
        getter = getattr(self.slave, f"get{self.suffix[fmi_type]}")
        values: list[Any] = getter(references, nValues=count)
        return values

    def enter_initialization_mode(self, start: float, stop: float) -> None:
        """Enter initialisation mode with the times of the experiment."""
        self.slave.enterInitializationMode(startTime=start, stopTime=stop)

    def get_state(self) -> Any:
        """Return the state, to be freed."""
        return self.slave.getFMUState()

    def set_state(self, state: Any) -> None:
        """Set the state."""
        self.slave.setFMUState(state)

    def free_state(self, state: Any) -> None:
        """Free a state."""
        self.slave.freeFMUState(state)

    def serialise(self, state: Any) -> bytes:
        """Return a state as bytes."""
        data: bytes = self.slave.serializeFMUState(state)
        return data

    def deserialise(self, data: bytes) -> Any:
        """Return the state of bytes, to be freed."""
        return self.slave.deserializeFMUState(data)


BINDINGS: dict[int, type[Fmi2] | type[Fmi3]] = {2: Fmi2, 3: Fmi3}
"""By major version of FMI."""
