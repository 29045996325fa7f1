"""An FMU file in, its description out: variables element by element, what it depends on, what it can do. No calls.

FMI 2.0 and 3.0 look alike from here: the types Float64, Float32 and Real are all Real, and an array variable `F` of
FMI 3.0 is a variable for each element, `F[1]`, `F[2]` and so on (`A[1,2]` for a matrix, row by row).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from fmpy import read_model_description, supported_platforms
from fmpy.model_description import ModelDescription, ScalarVariable

from ..archive import sha256, unpack
from ..errors import InputError

Value = float | int | bool | str

_INTEGERS = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
_TYPES = {"Float64": "Real", "Float32": "Real", **dict.fromkeys(_INTEGERS, "Integer")}
"""Types of FMI 3.0 under the names of FMI 2.0; those that are not listed keep theirs."""


@dataclass(frozen=True)
class Variable:
    """A scalar variable, or one element of an array.

    Attributes
    ----------
    name : with the indices of the element for an array
    array : name of the FMI variable
    type : Real, Integer, Boolean, Enumeration, String, Binary or Clock
    fmi_type : the type as the FMU's version of FMI calls it
    valueReference : of the FMI variable
    element, size : position of the element in the FMI variable, and number of its elements
    start, min, max : as the model description writes them; None if it does not
    nominal : typical size; None if the FMU does not tell
    """

    name: str
    array: str
    type: str
    fmi_type: str
    causality: str
    variability: str | None
    valueReference: int  # noqa: N815 - FMI's and FMPy's word
    element: int
    size: int
    unit: str | None
    description: str | None
    start: Any
    min: Any
    max: Any
    nominal: float | None


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

    @property
    def version(self) -> int:
        """Major version of FMI, 2 or 3."""
        return int(self.description.fmiVersion.partition(".")[0])

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The variables by name, arrays element by element."""
        return {v.name: v for declared in self.description.modelVariables for v in _elements(declared)}

    @cached_property
    def arrays(self) -> dict[str, list[str]]:
        """The names of the elements of each array, by the name of the array."""
        found: dict[str, list[str]] = {}
        for variable in self.variables.values():
            if variable.array != variable.name:
                found.setdefault(variable.array, []).append(variable.name)
        return found

    def names(self, causality: str) -> list[str]:
        """Return the names of the variables of one causality, in the order of the model description."""
        return [v.name for v in self.variables.values() if v.causality == causality]

    def unit(self, name: str) -> str | None:
        """Return the unit of a variable, also when its type declares it."""
        return self.variables[name].unit

    def has_feedthrough(self) -> bool | None:
        """Return whether an output depends on an input within a step; None if the FMU does not tell."""
        known = False
        for unknown in self.description.outputs:
            if unknown.dependencies is None:
                continue
            known = True
            if any(v.causality == "input" for v in unknown.dependencies):
                return True
        return False if known or not self.description.outputs else None

    @property
    def can_roll_back(self) -> bool:
        """Whether its state can be got and set."""
        return bool(self.description.coSimulation.canGetAndSetFMUstate)

    @property
    def can_serialise(self) -> bool:
        """Whether its state can be kept beyond the process."""
        return self.can_roll_back and bool(self.description.coSimulation.canSerializeFMUstate)

    @property
    def own_step(self) -> float | None:
        """Step that the FMU insists on [s]; None if it takes any.

        FMI 3.0 tells it as fixedInternalStepSize; an FMI 2.0 FMU that cannot handle variable steps tells it as the step
        size of its default experiment.
        """
        interface, experiment = self.description.coSimulation, self.description.defaultExperiment
        if interface.fixedInternalStepSize is not None:
            return float(interface.fixedInternalStepSize)
        if self.version == 2 and not interface.canHandleVariableCommunicationStepSize and experiment is not None:
            return float(experiment.stepSize) if experiment.stepSize else None
        return None


def _elements(declared: ScalarVariable) -> Iterator[Variable]:
    """Yield the scalar variables that a variable of a model description stands for."""
    shape = tuple(declared.shape or ())
    size = prod(shape)
    starts: list[str | None] = [None] * size
    if declared.start is not None:
        texts = str(declared.start).split() if shape else [declared.start]
        starts = list(texts) if len(texts) == size else [texts[0]] * size
    kind = declared.declaredType
    unit = declared.unit or getattr(kind, "unit", None)
    nominal = declared.nominal or getattr(kind, "nominal", None)
    for element, index in enumerate(product(*(range(1, n + 1) for n in shape))):
        yield Variable(
            name=f"{declared.name}[{','.join(map(str, index))}]" if shape else declared.name,
            array=declared.name,
            type=_TYPES.get(declared.type, declared.type),
            fmi_type=declared.type,
            causality=declared.causality or "local",
            variability=declared.variability,
            valueReference=declared.valueReference,
            element=element,
            size=size,
            unit=None if unit is None else str(unit),
            description=declared.description,
            start=starts[element],
            min=declared.min or getattr(kind, "min", None),
            max=declared.max or getattr(kind, "max", None),
            nominal=None if nominal is None else float(nominal),
        )


def open_fmu(path: Path) -> Fmu:
    """Return an FMU that can be instantiated on this machine.

    Raises
    ------
    InputError
        If the file is no FMU, not FMI 2.0 or 3.0 co-simulation, or has no binary.
    """
    folder = unpack(path, "FMU")
    if not (folder / "modelDescription.xml").is_file():
        raise InputError(f"{path}: holds no modelDescription.xml, so it is not an FMU")
    try:
        description = read_model_description(str(folder), validate=True)
    except Exception as error:  # FMPy raises bare exceptions
        raise InputError(f"{path}: modelDescription.xml is not valid: {first_line(error)}") from None
    if description.fmiVersion.partition(".")[0] not in ("2", "3"):
        raise InputError(f"{path}: is FMI {description.fmiVersion}; FMI 2.0 or 3.0 is wanted")
    if description.coSimulation is None:
        other = "model exchange" if description.modelExchange is not None else "scheduled execution"
        raise InputError(f"{path}: offers {other} only; co-simulation is wanted")
    if not supported_platforms(str(folder)):
        raise InputError(f"{path}: holds no binaries")
    return Fmu(path, folder, description, sha256(path))


def first_line(error: Exception) -> str:
    """Return the first line of what an exception says, the second too if the first announces it, or its name."""
    lines = str(error).strip().splitlines() or [type(error).__name__]
    return f"{lines[0]} {lines[1].lstrip('- ')}" if lines[0].endswith(":") and len(lines) > 1 else lines[0]
