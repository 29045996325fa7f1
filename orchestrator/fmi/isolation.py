"""An FMU in a process of its own behind the calls of a binding: if it crashes or hangs, that is an error, not the end.

Every call becomes a message to the process and an answer from it, see `isolation_answers`. The compiled loop gets the
addresses of callbacks that do the same, so that there is one loop for FMUs inside and outside of this process.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import signal
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException

from ..errors import SimulationError
from .binding import BINDINGS, Say, status_of, step_callback
from .file import Fmu, Value
from .isolation_answers import FAILED, MOST_BYTES, unpack
from .isolation_worker import serve

START_SECONDS = 60.0
"""Time that a process gets to start and to instantiate its FMU [s]."""

_POINTER = ctypes.c_void_p


class IsolatedBinding:
    """A slave in another process; the same calls as `fmu_binding.Binding`.

    Parameters
    ----------
    timeout : time that a call may take [s]; None: any time
    """

    def __init__(self, fmu: Fmu, name: str, say: Say, timeout: float | None) -> None:
        kind = BINDINGS[fmu.version]
        self.version, self.suffix, self.layout = fmu.version, kind.suffix, kind.layout
        self.state_suffix = kind.state_suffix
        self.handle = 1  # the callbacks know whom they call
        self._name, self._say, self._timeout = name, say, timeout
        self._started = self._dead = False
        self._callbacks: list[Any] = []
        context = multiprocessing.get_context("spawn")
        self._connection: Connection
        self._connection, other = context.Pipe()
        self._process = context.Process(target=serve, args=(other, fmu.path, name), daemon=True)
        self._process.start()
        other.close()

    def instantiate(self) -> None:
        """Do nothing: the process has begun to, and its first answer is awaited with the first call."""

    def _ask(self, call: str, *arguments: Any) -> Any:
        """Let the process make a call and return what it answers.

        Raises
        ------
        FMICallException
            With the status of the FMI function, if that is worse than a warning.
        SimulationError
            If the process died or did not answer in time.
        """
        if not self._started:
            self._started = True
            self._answer("instantiate", self._timeout and max(START_SECONDS, self._timeout))
        try:
            self._connection.send((call, arguments))
        except OSError:
            raise self._lost(self._obituary()) from None
        return self._answer(call, self._timeout)

    def _answer(self, call: str, timeout: float | None) -> Any:
        """Return the answer to a call."""
        try:
            if not self._connection.poll(timeout):
                raise self._lost(f"did not answer within {timeout:g} s")
            status, result, messages = unpack(self._connection.recv_bytes(MOST_BYTES), call)
        except (EOFError, OSError):
            raise self._lost(self._obituary()) from None
        except (ValueError, RecursionError):
            raise self._lost(f"its process gave no answer to {call} that can be read") from None
        for message in messages:
            self._say(message)
        if status == FAILED:
            raise self._lost(str(result))
        if status > 1:
            raise FMICallException(call, status)
        return result

    def _obituary(self) -> str:
        """Return how the process ended, as a sentence."""
        self._process.join(5.0)
        code = self._process.exitcode
        if code is not None and code < 0:
            return f"its process died of {signal.Signals(-code).name}"
        return f"its process ended by itself with exit code {code}"

    def _lost(self, how: str) -> SimulationError:
        """Give the process up and return the error that says how it was lost."""
        self._dead = True
        self._say(how)
        self._process.kill()
        return SimulationError(f"{self._name}: {how}")

    def set(self, fmi_type: str, references: Sequence[int], values: Sequence[Value]) -> None:
        """Set variables of one type; all elements of arrays, one after the other."""
        self._ask("set", fmi_type, list(references), list(values))

    def get(self, fmi_type: str, references: Sequence[int], count: int) -> list[Any]:
        """Return variables of one type."""
        values: list[Any] = self._ask("get", fmi_type, list(references), count)
        if len(values) != count:
            raise self._lost(f"its process gave {len(values)} values instead of {count}")
        return values

    def enter_initialization_mode(self, start: float, stop: float) -> None:
        """Enter initialisation mode with the times of the experiment."""
        self._ask("enter_initialization_mode", start, stop)

    def exit_initialization_mode(self) -> None:
        """Leave initialisation mode."""
        self._ask("exit_initialization_mode")

    def do_step(self, time: float, step: float) -> Any:
        """Make a communication step; return what FMI 3.0 answers to it."""
        return self._ask("do_step", time, step)

    def get_state(self) -> Any:
        """Return the state, to be freed; here, the number that the process gave it."""
        return _POINTER(self._ask("get_state", 0))

    def set_state(self, state: Any) -> None:
        """Set the state."""
        self._ask("set_state", state.value)

    def free_state(self, state: Any) -> None:
        """Free a state; with the process, its states are gone."""
        if not self._dead:
            self._ask("free_state", state.value)

    def serialise(self, state: Any) -> bytes:
        """Return a state as bytes."""
        data: bytes = self._ask("serialise", state.value)
        return data

    def deserialise(self, data: bytes) -> Any:
        """Return the state of bytes, to be freed."""
        return _POINTER(self._ask("deserialise", data))

    def configure(self, sizes: Mapping[int, int]) -> None:
        """Set structural parameters, by value reference."""
        self._ask("configure", dict(sizes))

    def ended(self) -> bool:
        """Return whether the step that was just discarded is the end that the FMU wants."""
        return not self._dead and bool(self._ask("ended"))

    def terminate(self) -> None:
        """End the simulation."""
        if not self._dead:
            self._ask("terminate")

    def free(self) -> None:
        """End the process, and with it the instance."""
        self._connection.close()
        self._process.join(0 if self._dead else 5.0)
        self._process.kill()
        self._process.join(5.0)

    def abandon(self) -> None:
        """End the process without a word to the FMU."""
        self._dead = True
        self.free()

    def address(self, what: str) -> int:
        """Return the address of a callback for a function, such as 'DoStep' or 'GetReal'."""
        if what == "DoStep":
            callback = step_callback(self.do_step, self.version)
        elif what.endswith(self.state_suffix):
            callback = self._state_callback("get_state" if what.startswith("Get") else "set_state")
        else:
            callback = self._value_callback(what[:3].lower(), what[3:])
        self._callbacks.append(callback)
        return ctypes.cast(callback, _POINTER).value or 0

    def _value_callback(self, call: str, suffix: str) -> Any:
        fmi_type = next(name for name, end in self.suffix.items() if end == suffix)
        kind = np.ctypeslib.as_ctypes_type(self.layout[fmi_type])

        def exchange(_handle: int, references: int, count: int, values: int, size: int = -1) -> int:
            chosen = list((ctypes.c_uint32 * count).from_address(references))
            memory = (kind * (count if size < 0 else size)).from_address(values)

            def work() -> None:
                if call == "set":
                    self.set(fmi_type, chosen, list(memory))
                    return
                values = self.get(fmi_type, chosen, len(memory))
                try:
                    memory[:] = values
                except (TypeError, ValueError, OverflowError):
                    raise self._lost(f"its process gave values that are not {fmi_type}") from None

            return status_of(work)

        kinds = (_POINTER, _POINTER, ctypes.c_size_t, _POINTER, *([ctypes.c_size_t] if self.version == 3 else []))
        return ctypes.CFUNCTYPE(ctypes.c_int, *kinds)(exchange)

    def _state_callback(self, call: str) -> Any:
        def exchange(_handle: int, argument: int) -> int:
            def work() -> None:
                if call == "get_state":
                    place = ctypes.c_size_t.from_address(argument)
                    place.value = self._ask("get_state", place.value)
                else:
                    self._ask("set_state", argument)

            return status_of(work)

        return ctypes.CFUNCTYPE(ctypes.c_int, _POINTER, _POINTER)(exchange)
