"""FMI 2.0 co-simulation FMUs through FMPy's binding: a file in, instances with named values and call addresses out."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fmpy import calloc, free, read_model_description, supported_platforms
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)
from fmpy.model_description import ModelDescription, ScalarVariable

from .archive import sha256, unpack
from .errors import InputError, SimulationError

Value = float | int | bool | str

STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")
"""Names of the FMI 2.0 status codes."""


@dataclass(frozen=True)
class Fmu:
    """An FMU file, unpacked and described.

    Attributes
    ----------
    path : the file as the user knows it
    folder : where it is unpacked
    description : FMPy's model description
    checksum : SHA-256 of the file
    """

    path: Path
    folder: Path
    description: ModelDescription
    checksum: str

    @cached_property
    def variables(self) -> dict[str, ScalarVariable]:
        """The variables by name."""
        return {v.name: v for v in self.description.modelVariables}

    def names(self, causality: str) -> list[str]:
        """Return the names of the variables of one causality, in the order of the model description."""
        return [v.name for v in self.description.modelVariables if v.causality == causality]

    def unit(self, name: str) -> str | None:
        """Return the unit of a variable, also when its type declares it."""
        variable = self.variables[name]
        unit = variable.unit or getattr(variable.declaredType, "unit", None)
        return None if unit is None else str(unit)

    def has_feedthrough(self) -> bool | None:
        """Return whether an output depends on an input within a step; None if the FMU does not tell."""
        inputs = set(self.names("input"))
        known = False
        for unknown in self.description.outputs:
            if unknown.dependencies is None:
                continue
            known = True
            if any(v.name in inputs for v in unknown.dependencies):
                return True
        return False if known or not self.description.outputs else None


def open_fmu(path: Path) -> Fmu:
    """Return an FMU that can be instantiated on this machine.

    Raises
    ------
    InputError
        If the file is no FMU, not FMI 2.0 co-simulation, or has no binary for this platform.
    """
    folder = unpack(path, "FMU")
    if not (folder / "modelDescription.xml").is_file():
        raise InputError(f"{path}: holds no modelDescription.xml, so it is not an FMU")
    try:
        description = read_model_description(str(folder), validate=True)
    except Exception as error:  # FMPy raises bare exceptions
        raise InputError(f"{path}: modelDescription.xml is not valid: {_first_line(error)}") from None
    if description.fmiVersion != "2.0":
        raise InputError(f"{path}: is FMI {description.fmiVersion}; FMI 2.0 is wanted")
    if description.coSimulation is None:
        raise InputError(f"{path}: offers model exchange only; co-simulation is wanted")
    if not supported_platforms(str(folder)):
        raise InputError(f"{path}: holds no binaries")
    return Fmu(path, folder, description, sha256(path))


def _first_line(error: Exception) -> str:
    return str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__


class FmuInstance:
    """A running FMI 2.0 co-simulation slave.

    Messages of the FMU are kept and become part of the error when a call fails.

    Attributes
    ----------
    lost : whether a call returned fatal, after which the instance must not be called again
    """

    def __init__(self, fmu: Fmu, name: str) -> None:
        self.fmu = fmu
        self.name = name
        self.messages: list[str] = []
        self.lost = False
        self._callbacks = fmi2CallbackFunctions()
        self._callbacks.logger = fmi2CallbackLoggerTYPE(self._log)
        self._callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
        self._callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
        try:
            self._slave = FMU2Slave(
                guid=fmu.description.guid,
                unzipDirectory=str(fmu.folder),
                modelIdentifier=fmu.description.coSimulation.modelIdentifier,
                instanceName=name,
            )
        except Exception as error:  # FMPy raises bare exceptions for a missing or broken library
            raise SimulationError(f"{name}: {fmu.path}: cannot be loaded here: {_first_line(error)}") from None
        with self._calling("instantiate"):
            self._slave.instantiate(callbacks=self._callbacks, loggingOn=True)

    def _log(self, _environment: Any, _instance: Any, _status: int, _category: Any, message: bytes) -> None:
        self.messages.append(message.decode("utf-8", "replace") if message else "")
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
        except Exception as error:
            if function != "instantiate":
                raise
            raise SimulationError(f"{self.name}: {_first_line(error)}{self.last_message()}") from None

    def last_message(self) -> str:
        """Return what the FMU said last, as the end of a sentence; of a Python exception only its text."""
        if not self.messages:
            return ""
        text = " ".join(self.messages[-1].split())
        exception = re.search(r"(?:Error|Exception)\((['\"])(.*)\1\)$", text)
        return f": {exception.group(2) if exception else text}"

    def set(self, values: Mapping[str, Value]) -> None:
        """Set variables by name, each by its type."""
        setters = {
            "Real": (self._slave.setReal, float),
            "Integer": (self._slave.setInteger, int),
            "Enumeration": (self._slave.setInteger, int),
            "Boolean": (self._slave.setBoolean, bool),
            "String": (self._slave.setString, str),
        }
        for name, value in values.items():
            variable = self.fmu.variables[name]
            setter, convert = setters[variable.type]
            with self._calling(f"setting {name} = {value}"):
                setter([variable.valueReference], [convert(value)])

    def get_real(self, names: Sequence[str]) -> list[float]:
        """Return real variables by name."""
        references = [self.fmu.variables[name].valueReference for name in names]
        with self._calling("getReal"):
            values: list[float] = self._slave.getReal(references)
        return values

    def enter_initialization_mode(self, start: float, stop: float) -> None:
        """Set up the experiment and enter initialisation mode."""
        with self._calling("setupExperiment"):
            self._slave.setupExperiment(startTime=start, stopTime=stop)
        with self._calling("enterInitializationMode"):
            self._slave.enterInitializationMode()

    def exit_initialization_mode(self) -> None:
        """Leave initialisation mode."""
        with self._calling("exitInitializationMode"):
            self._slave.exitInitializationMode()

    def do_step(self, time: float, step: float) -> None:
        """Advance by one step; the compiled loop calls the library directly instead."""
        with self._calling("doStep"):
            self._slave.doStep(currentCommunicationPoint=time, communicationStepSize=step)

    def address(self, function: str) -> int:
        """Return the address of an FMI function of this FMU's library, such as 'fmi2DoStep'."""
        return ctypes.cast(getattr(self._slave.dll, function), ctypes.c_void_p).value or 0

    @property
    def handle(self) -> int:
        """The fmi2Component pointer."""
        return int(self._slave.component)

    def close(self) -> None:
        """Terminate and free the instance; after a fatal error FMI allows no further call, so it is left alone."""
        if self.lost:
            return
        try:
            self._slave.terminate()
        except FMICallException:
            self.messages.append("terminate failed")  # the results are there; a component may die as it likes
        self._slave.freeInstance()
