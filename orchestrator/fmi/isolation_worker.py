"""The other side of `isolation`: the process that has the FMU and makes the calls that it is asked for."""

from __future__ import annotations

import multiprocessing
import os
import signal
from itertools import count
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread
from typing import Any

from fmpy.fmi1 import FMICallException

from .binding import BINDINGS, Fmi2, Fmi3
from .description import first_line
from .file import open_fmu
from .isolation_answers import FAILED, Answer, pack


def serve(connection: Connection, path: Path, name: str) -> None:
    """Instantiate an FMU and answer calls, each with status, result and messages, until the other side is gone."""
    os.dup2(2, 1)  # what the FMU prints is not for the standard output, which may be a program's input
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the master's business
    Thread(target=_end_with_parent, daemon=True).start()
    messages: list[str] = []
    slave: list[_Slave] = []

    def start() -> None:
        slave.append(_Slave(path, name, messages))

    _reply(connection, messages, start)
    while slave:
        try:
            call, arguments = connection.recv()
        except (EOFError, OSError):
            break
        _reply(connection, messages, getattr(slave[0], call, None) or getattr(slave[0].binding, call), *arguments)
    for each in slave:
        each.binding.folder.close()
    os._exit(0)


def _end_with_parent() -> None:
    """End this process when the one that started it is gone, be it in the middle of a call."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(0)


def _reply(connection: Connection, messages: list[str], function: Any, *arguments: Any) -> None:
    """Make a call and send its answer."""
    messages.clear()
    status, result = 0, None
    try:
        result = function(*arguments)
    except FMICallException as error:
        status = error.status
    except Exception as error:  # FMPy and a broken library raise anything
        status, result = FAILED, first_line(error)
    connection.send_bytes(pack(Answer(status, result, messages)))


class _Slave:
    """The FMU, and its states by number."""

    def __init__(self, path: Path, name: str, messages: list[str]) -> None:
        fmu = open_fmu(path)
        self.binding: Fmi2 | Fmi3 = BINDINGS[fmu.version](fmu, name, messages.append)
        self.binding.instantiate()
        self._states: dict[int, Any] = {}
        self._numbers = count(1)

    def _keep(self, state: Any) -> int:
        number = next(self._numbers)
        self._states[number] = state
        return number

    def get_state(self, number: int) -> int:
        """Get the state; `number` of a state that is not wanted any more, or 0. Return the number of the new one."""
        if number in self._states:
            self.free_state(number)
        return self._keep(self.binding.get_state())

    def set_state(self, number: int) -> None:
        """Set a state."""
        self.binding.set_state(self._states[number])

    def free_state(self, number: int) -> None:
        """Free a state."""
        self.binding.free_state(self._states.pop(number))

    def serialise(self, number: int) -> bytes:
        """Return a state as bytes."""
        return self.binding.serialise(self._states[number])

    def deserialise(self, data: bytes) -> int:
        """Return the number of the state of bytes."""
        return self._keep(self.binding.deserialise(data))
