"""The calls of an FMU library in FMI 2.0 and 3.0 behind one set of names, through FMPy's bindings.

FMPy gives FMI 2.0 a logger that fills in the arguments of a message, as printf does. It knows one function to hand the
text to for the whole process, so all instances share that and are told apart by a number.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from itertools import count
from typing import Any, ClassVar

import numpy as np
from fmpy import calloc, free
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2Terminated,
)
from fmpy.fmi3 import FMU3Slave

from ..errors import SimulationError
from .exit_guard import guard_exit
from .file import Fmu, Value
from .folder import InstanceFolder, instance_folder

Say = Callable[[str], None]

_numbers = count(1)
_listeners: dict[int | bytes, Say] = {}
"""Who hears what an instance of FMI 2.0 says, by the number that is its environment, and by its name."""


def _hear(environment: Any, instance: bytes | None, _status: int, _category: Any, message: bytes | None) -> None:
    """Hand on what an instance says; by its name where an FMU forgets its environment."""
    say = _listeners.get(environment or 0) or _listeners.get(instance or b"")
    if say is not None:
        say(message.decode("utf-8", "replace") if message else "")


_LOGGER = fmi2CallbackLoggerTYPE(_hear)


_Signatures = dict[str, tuple[Any, Any, Any]]
"""Names of arguments, their types and that of the result of FMI functions, by name."""

_signatures: dict[type, _Signatures] = {}
"""By class of FMPy's slaves."""

_complete: set[str] = set()
"""Paths of libraries that have all functions."""


class _Functions(dict[str, Any]):
    """The functions of a library, each looked up when it is called for the first time."""

    def __init__(self, dll: Any, signatures: _Signatures) -> None:
        super().__init__()
        self._dll, self._signatures = dll, signatures

    def __missing__(self, name: str) -> Any:
        """Look up a function."""
        function = getattr(self._dll, name)
        function.argnames, function.argtypes, function.restype = self._signatures[name]
        self[name] = function
        return function


class _Quick:
    """FMPy asks Python for all signatures, for each instance; once is enough, where there are a thousand instances."""

    def _loadFunctions(self: Any) -> None:  # noqa: N802 - FMPy's name
        path, known = self.dll._name, _signatures.get(type(self))
        if known is None:
            super()._loadFunctions()  # type: ignore[misc]
            _signatures[type(self)] = {n: (f.argnames, f.argtypes, f.restype) for n, f in self._functions.items()}
        else:
            if path not in _complete:
                for name in known:
                    getattr(self.dll, name)  # one that is missing is the error that FMPy makes of it
            self._functions = _Functions(self.dll, known)
        _complete.add(path)


class FMU2Quick(_Quick, FMU2Slave):  # type: ignore[misc]
    """FMPy's slave of FMI 2.0; it goes by the beginning of its class's name."""


class FMU3Quick(_Quick, FMU3Slave):  # type: ignore[misc]
    """FMPy's slave of FMI 3.0."""


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
    folder: InstanceFolder

    def set(self, fmi_type: str, references: Sequence[int], values: Sequence[Value]) -> None:
        """Set variables of one type; all elements of arrays, one after the other."""
        kind = self.layout[fmi_type].kind if fmi_type in self.layout else "O"
        convert: Callable[[Any], Any] = {"f": float, "i": int, "u": int, "b": bool, "O": str}[kind]
        if fmi_type == "Boolean":
            convert = bool
        getattr(self.slave, f"set{self.suffix[fmi_type]}")(references, [convert(value) for value in values])

    def configure(self, sizes: Mapping[int, int]) -> None:
        """Set structural parameters, by value reference; FMI 2.0 has none."""

    def ended(self) -> bool:
        """Return whether the step that was just discarded is the end that the FMU wants."""
        return False

    def terminate(self) -> None:
        """End the simulation."""
        self.slave.terminate()

    def free(self) -> None:
        """Free the instance."""
        self.slave.freeInstance()
        self.folder.close()

    def abandon(self) -> None:
        """Leave an instance alone that must not be called any more."""
        self.folder.close()

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
        self._number = next(_numbers)
        self._names = (self._number, name.encode())
        _listeners.update(dict.fromkeys(self._names, say))
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = _LOGGER
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        self._callbacks.componentEnvironment = self._number
        _fill_in_arguments(self._callbacks)
        self.folder = instance_folder(fmu)
        self.slave = FMU2Quick(
            guid=fmu.description.guid,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.unzipDirectory = str(self.folder.path)  # where it looks for resources; the library is loaded
        guard_exit(fmu.folder, fmu.path)

    def instantiate(self) -> None:
        """Make the instance."""
        self.slave.instantiate(callbacks=self._callbacks, loggingOn=True)

    def ended(self) -> bool:
        """Return whether the step that was just discarded is the end that the FMU wants."""
        return bool(self.slave.getBooleanStatus(fmi2Terminated))

    def free(self) -> None:
        """Free the instance."""
        super().free()
        for each in self._names:
            _listeners.pop(each, None)

    def get(self, fmi_type: str, references: Sequence[int], _count: int) -> list[Any]:
        """Return variables of one type."""
        values: list[Any] = getattr(self.slave, f"get{self.suffix[fmi_type]}")(references)
        return [v.decode("utf-8", "replace") for v in values] if fmi_type == "String" else values

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


def _fill_in_arguments(callbacks: fmi2CallbackFunctions) -> None:
    """Have the arguments of a message filled in before the logger gets it, where FMPy brings a library for that."""
    try:
        from fmpy.logging import addLoggerProxy  # noqa: PLC0415 - it loads a library that not every platform has
    except OSError:
        return
    addLoggerProxy(ctypes.byref(callbacks))


class Fmi3(Binding):
    """An FMI 3.0 co-simulation slave; event mode only for an FMU that cannot do without."""

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
        self._has_event_mode = bool(fmu.description.coSimulation.hasEventMode)
        self._events = False
        self._callback: Any = None
        self.folder = instance_folder(fmu)
        self.slave = FMU3Quick(
            guid=fmu.description.instantiationToken,
            unzipDirectory=str(fmu.folder),
            modelIdentifier=fmu.description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.slave.unzipDirectory = str(self.folder.path)  # where it looks for resources; the library is loaded

    def instantiate(self) -> None:
        """Make the instance: one that handles its events itself, else one whose events are handled here."""
        try:
            self.slave.instantiate(loggingOn=True, logMessage=self._log)
        except Exception:  # FMPy raises bare exceptions
            if not self._has_event_mode:
                raise
            self.slave.instantiate(loggingOn=True, logMessage=self._log, eventModeUsed=True)
            self._events = True

    def configure(self, sizes: Mapping[int, int]) -> None:
        """Set structural parameters, by value reference."""
        self.slave.enterConfigurationMode()
        for reference, size in sizes.items():
            self.slave.setUInt64([reference], [size])
        self.slave.exitConfigurationMode()

    def exit_initialization_mode(self) -> None:
        """Leave initialisation mode, and event mode if the FMU is in it then."""
        self.slave.exitInitializationMode()
        if self._events:
            self._handle_events()

    def _handle_events(self) -> bool:
        """Let the FMU go from event mode into step mode; return whether it ends the simulation."""
        for _ in range(_MOST_EVENT_ITERATIONS):
            again, ends, *_ = self.slave.updateDiscreteStates()
            if ends or not again:
                break
        self.slave.enterStepMode()
        return bool(ends)

    def do_step(self, time: float, step: float) -> Any:
        """Make a communication step and handle its events; return what FMI 3.0 answers to it."""
        event, ends, early, reached = self.slave.doStep(time, step)
        if self._events and event and not ends:
            self.slave.enterEventMode()
            ends = self._handle_events()
        return event, ends, early, reached

    def address(self, what: str) -> int:
        """Return the address of a function; where events are handled here, that of `do_step`."""
        if not (self._events and what == "DoStep"):
            return super().address(what)
        if self._callback is None:
            self._callback = step_callback(self.do_step, 3)
        return ctypes.cast(self._callback, ctypes.c_void_p).value or 0

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


_MOST_EVENT_ITERATIONS = 1000
_FATAL = 4


def status_of(call: Callable[[], None]) -> int:
    """Return the FMI status of a call; an exception must not reach compiled code."""
    try:
        call()
    except FMICallException as error:
        return int(error.status)
    except SimulationError:
        return _FATAL
    return 0


def step_callback(do_step: Callable[[float, float], Any], version: int) -> Any:
    """Return a function of C that makes a step by a function of Python, in the place of fmi2DoStep or fmi3DoStep."""

    def step(_handle: int, time: float, size: float, _final: int, *answer: int) -> int:
        def call() -> None:
            told = do_step(time, size)
            if answer and told is not None:
                for place, flag in zip(answer[:3], told[:3], strict=True):
                    ctypes.c_bool.from_address(place).value = flag
                ctypes.c_double.from_address(answer[3]).value = told[3]

        return status_of(call)

    extra = [ctypes.c_void_p] * 4 if version == 3 else []
    kinds = (ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int, *extra)
    return ctypes.CFUNCTYPE(ctypes.c_int, *kinds)(step)


BINDINGS: dict[int, type[Fmi2] | type[Fmi3]] = {2: Fmi2, 3: Fmi3}
"""By major version of FMI."""
