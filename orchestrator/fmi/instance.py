"""Instances of co-simulation FMUs, FMI 2.0 or 3.0: named values, states, and the addresses of the calls."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple

from fmpy.fmi1 import FMICallException

from ..errors import SimulationError
from .binding import BINDINGS, Fmi2, Fmi3
from .description import first_line
from .file import Fmu, Value, Variable, open_fmu

if TYPE_CHECKING:
    from .isolation import IsolatedBinding

__all__ = ["STATUS", "Fmu", "FmuInstance", "Value", "Variable", "open_fmu"]

STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")
"""Names of the FMI status codes."""


_seen: set[str] = set()
"""Checksums of the FMUs that this process has had an instance of and may have no second one of."""


class _Reading(NamedTuple):
    """How variables are got.

    Attributes
    ----------
    calls : type, value references and number of values of each call
    places : positions of the variables among the values of all calls
    """

    calls: list[tuple[str, list[int], int]]
    places: list[int]


class FmuInstance:
    """A running co-simulation slave.

    Messages of the FMU are kept and become part of the error when a call fails. An FMU that a process can have one
    instance of gets a process of its own for every further one.

    Parameters
    ----------
    timeout : time that a call may take, in a process of the FMU's own [s]; None: in this process, without limit
    scratch : whether the instance is there to be asked something and thrown away

    Attributes
    ----------
    lost : whether a call returned fatal, after which the instance must not be called again
    apart : whether it runs in a process of its own
    """

    def __init__(self, fmu: Fmu, name: str, timeout: float | None = None, scratch: bool = False) -> None:
        self.fmu = fmu
        self.name = name
        self.messages: list[str] = []
        self.lost = False
        self._readings: dict[tuple[str, ...], _Reading] = {}
        alone = fmu.once_per_process and (scratch or fmu.checksum in _seen)
        self.apart = timeout is not None or alone
        if fmu.once_per_process and not self.apart:
            _seen.add(fmu.checksum)
        try:
            self._binding = self._bind(timeout)
        except Exception as error:  # FMPy raises bare exceptions for a missing or broken library
            raise SimulationError(f"{name}: {fmu.path}: cannot be loaded here: {first_line(error)}") from None
        with self._calling("instantiate"):
            self._binding.instantiate()
        if fmu.structure:
            with self._calling("setting structural parameters"):
                self._binding.configure({fmu.variables[n].valueReference: k for n, k in fmu.structure.items()})

    def _bind(self, timeout: float | None) -> Fmi2 | Fmi3 | IsolatedBinding:
        if not self.apart:
            return BINDINGS[self.fmu.version](self.fmu, self.name, self._say)
        from .isolation import IsolatedBinding  # noqa: PLC0415 - seldom wanted

        return IsolatedBinding(self.fmu, self.name, self._say, timeout)

    def _say(self, message: str) -> None:
        self.messages.append(message)
        del self.messages[:-20]

    @contextmanager
    def _calling(self, function: str) -> Iterator[None]:
        """Turn a failed FMI call into an error that names component and function."""
        try:
            yield
        except FMICallException as error:
            status = STATUS[error.status] if 0 <= error.status < len(STATUS) else str(error.status)
            self.lost = status == "fatal"
            raise SimulationError(f"{self.name}: {function} returned {status}{self.last_message()}") from None
        except SimulationError:  # of a process of its own that is no more
            self.lost = True
            raise
        except Exception as error:
            if function != "instantiate":
                raise
            raise SimulationError(f"{self.name}: {first_line(error)}{self.last_message()}") from None

    def last_message(self) -> str:
        """Return what the FMU said last, as the end of a sentence; of a Python exception only its text."""
        if not self.messages:
            return ""
        text = " ".join(self.messages[-1].split())
        exception = re.search(r"(?:Error|Exception)\((['\"])(.*)\1\)$", text)
        return f": {exception.group(2) if exception else text}"

    def set(self, values: Mapping[str, Value]) -> None:
        """Set variables by name, each by its type; elements of an array that are not given keep their start values."""
        arrays: dict[str, dict[int, Value]] = {}
        scalars: dict[str, dict[str, Value]] = {}
        for name, value in values.items():
            variable = self.fmu.variables[name]
            if variable.array == name:
                scalars.setdefault(variable.fmi_type, {})[name] = value
            else:
                arrays.setdefault(variable.array, {})[variable.element] = value
        for fmi_type, group in scalars.items():
            self._set_scalars(fmi_type, group)
        for array, given in arrays.items():
            elements = [self.fmu.variables[name] for name in self.fmu.arrays[array]]
            kind, reference = elements[0].fmi_type, elements[0].valueReference
            with self._calling(f"setting {array}"):
                if len(given) < len(elements) and any(v.start is None for v in elements):
                    held = self._binding.get(kind, [reference], len(elements))
                else:
                    held = [v.start_value for v in elements]
                self._binding.set(kind, [reference], [given.get(v.element, held[v.element]) for v in elements])

    def _set_scalars(self, fmi_type: str, values: Mapping[str, Value]) -> None:
        """Set scalars of one type in one call; if it fails, one by one, so that the error names the one."""
        references = [self.fmu.variables[name].valueReference for name in values]
        try:
            self._binding.set(fmi_type, references, list(values.values()))
        except FMICallException as error:
            self.lost = 0 <= error.status < len(STATUS) and STATUS[error.status] == "fatal"
            if self.lost:
                raise SimulationError(f"{self.name}: setting values returned fatal{self.last_message()}") from None
            for name, value in values.items():
                with self._calling(f"setting {name} = {value}"):
                    self._binding.set(fmi_type, [self.fmu.variables[name].valueReference], [value])

    def get_real(self, names: Sequence[str]) -> list[float]:
        """Return variables by name as floating-point numbers, whatever numeric type they have."""
        return [float(value) for value in self._get(names)]

    def get_texts(self, names: Sequence[str]) -> list[str]:
        """Return variables of type String by name."""
        return [str(value) for value in self._get(names)]

    def get_words(self, names: Sequence[str]) -> list[int]:
        """Return whole numbers, truth values (0 or 1) and values of enumerations by name."""
        return [int(value) for value in self._get(names)]

    def _get(self, names: Sequence[str]) -> list[Any]:
        """Return variables by name; those that share a value reference are got once."""
        reading = self._readings.get(tuple(names)) or self._reading(names)
        found: list[Any] = []
        for kind, references, count in reading.calls:
            with self._calling(f"get{self._binding.suffix[kind]}"):
                found += self._binding.get(kind, references, count)
        return [found[place] for place in reading.places]

    def _reading(self, names: Sequence[str]) -> _Reading:
        """Return how to get variables, and remember it: a structure that is tried gets the same ones at every step."""
        variables = [self.fmu.variables[name] for name in names]
        calls, begins, total = [], {}, 0
        for kind in dict.fromkeys(v.fmi_type for v in variables):
            sizes = {v.valueReference: v.size for v in variables if v.fmi_type == kind}
            calls.append((kind, list(sizes), sum(sizes.values())))
            for reference, size in sizes.items():
                begins[kind, reference] = total
                total += size
        places = [begins[v.fmi_type, v.valueReference] + v.element for v in variables]
        reading = self._readings[tuple(names)] = _Reading(calls, places)
        return reading

    def enter_initialization_mode(self, start: float, stop: float) -> None:
        """Set up the experiment and enter initialisation mode."""
        with self._calling("enterInitializationMode"):
            self._binding.enter_initialization_mode(start, stop)

    def exit_initialization_mode(self) -> None:
        """Leave initialisation mode."""
        with self._calling("exitInitializationMode"):
            self._binding.exit_initialization_mode()

    def do_step(self, time: float, step: float) -> None:
        """Advance by one step; the compiled loop calls the library directly instead."""
        with self._calling("doStep"):
            self._binding.do_step(time, step)

    def get_state(self) -> Any:
        """Return the FMU's state, to be freed."""
        with self._calling("getFMUstate"):
            return self._binding.get_state()

    def set_state(self, state: Any) -> None:
        """Set the FMU's state."""
        with self._calling("setFMUstate"):
            self._binding.set_state(state)

    def free_state(self, state: Any) -> None:
        """Free a state; after a fatal error nothing is called any more."""
        if not self.lost:
            with self._calling("freeFMUstate"):
                self._binding.free_state(state)

    def save(self) -> bytes:
        """Return the FMU's state as bytes."""
        state = self.get_state()
        with self._calling("serializeFMUstate"):
            data = self._binding.serialise(state)
        self.free_state(state)
        return data

    def restore(self, data: bytes) -> None:
        """Set the FMU's state from bytes that `save` returned."""
        with self._calling("deSerializeFMUstate"):
            state = self._binding.deserialise(data)
        self.set_state(state)
        self.free_state(state)

    def ended(self) -> bool:
        """Return whether the step that was just discarded is the end that the FMU wants."""
        try:
            return self._binding.ended()
        except (FMICallException, SimulationError):  # it need not know
            return False

    def address(self, what: str) -> int:
        """Return the address of an FMI function of this FMU's library, such as 'DoStep'."""
        return self._binding.address(what)

    def value_function(self, direction: str, fmi_type: str) -> int:
        """Return the address of the function that sets ('Set') or gets ('Get') variables of a type."""
        return self._binding.address(f"{direction}{self._binding.suffix[fmi_type]}")

    def state_function(self, direction: str) -> int:
        """Return the address of the function that sets ('Set') or gets ('Get') the state."""
        return self._binding.address(f"{direction}{self._binding.state_suffix}")

    def layout(self, fmi_type: str) -> Any:
        """Return the data type of an FMI type in memory."""
        return self._binding.layout[fmi_type]

    @property
    def handle(self) -> int:
        """The pointer to the instance."""
        return self._binding.handle

    def close(self) -> None:
        """Terminate and free the instance; after a fatal error FMI allows no further call, so it is left alone."""
        if self.lost:
            self._binding.abandon()
            return
        try:
            self._binding.terminate()
        except (FMICallException, SimulationError):
            self.messages.append("terminate failed")  # the results are there; a component may die as it likes
        self._binding.free()
