"""An FMU file in, its description out: variables element by element, what it depends on, what it can do. No calls.

FMI 2.0 and 3.0 look alike from here: the types Float64, Float32 and Real are all Real, and an array variable `F` of
FMI 3.0 is a variable for each element, `F[1]`, `F[2]` and so on (`A[1,2]` for a matrix, row by row).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product
from math import prod
from pathlib import Path
from typing import Any

from fmpy import supported_platforms
from fmpy.model_description import ModelDescription, ScalarVariable

from ..archive import sha256, unpack, zip_faults
from ..errors import Fault, InputError
from .description import read_description
from .types import plain_type

Value = float | int | bool | str

MOST_VARIABLES = 2_000_000
"""Most scalar variables and elements of arrays of an FMU."""

WHOLE = ("Integer", "Enumeration", "Boolean")
NUMERIC = ("Real", *WHOLE)
"""Types that can be exchanged and recorded as numbers, and those of them that are whole numbers."""


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

    @property
    def place(self) -> tuple[str, int, int]:
        """What an FMU knows the variable by: the functions that get it, value reference, and element."""
        return _getter(self.fmi_type), self.valueReference, self.element

    @property
    def start_value(self) -> Value:
        """Start value in its type; nothing of its kind if the description has none."""
        if self.type == "String":
            return "" if self.start is None else str(self.start)
        if self.type == "Boolean":
            return str(self.start).strip().lower() in ("true", "1")
        if self.type in WHOLE:
            return int(self.start or 0)
        return float(self.start or 0.0)


@dataclass(frozen=True)
class Fmu:
    """An FMU file, unpacked and described.

    Attributes
    ----------
    path : the file as the user knows it
    folder : where it is unpacked
    description : FMPy's model description
    checksum : SHA-256 of the file
    faults : what the description has wrong that does not change a number, one sentence each
    structure : sizes that are set, by structural parameter; the others as the description has them
    """

    path: Path
    folder: Path
    description: ModelDescription
    checksum: str
    faults: tuple[Fault, ...] = ()
    structure: Mapping[str, int] = field(default_factory=dict)

    @property
    def version(self) -> int:
        """Major version of FMI, 2 or 3."""
        return int(self.description.fmiVersion.partition(".")[0])

    @cached_property
    def variables(self) -> dict[str, Variable]:
        """The variables by name, arrays element by element."""
        count = sum(prod(_shape(d, self.structure)) for d in self.description.modelVariables)
        if count > MOST_VARIABLES:
            raise InputError(f"{self.path}: has {count} variables, elements of arrays counted; refused")

        return {v.name: v for d in self.description.modelVariables for v in _elements(d, self.structure)}

    def resized(self, sizes: Mapping[str, int]) -> Fmu:
        """Return this FMU with other sizes of its arrays, by structural parameter."""
        return replace(self, structure={**self.structure, **sizes})

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

    def dependencies(self) -> dict[str, frozenset[str] | None]:
        """Return on which inputs each output depends within a step; None: the FMU does not tell, so on all.

        Whole arrays by name; an alias of an input or output counts as what it is an alias of.
        """
        inputs: dict[tuple[str, int], set[str]] = {}
        for variable in self.description.modelVariables:
            if variable.causality == "input":
                inputs.setdefault(_place(variable), set()).add(variable.name)
        told: dict[str, frozenset[str] | None] = {}
        for unknown in self.description.outputs:
            known = unknown.dependencies
            names = None if known is None else {name for v in known for name in inputs.get(_place(v), ())}
            told[unknown.variable.name] = None if names is None else frozenset(names)
        outputs = [v for v in self.description.modelVariables if v.causality == "output"]
        return {v.name: told.get(v.name if v.alias is None else v.alias.name) for v in outputs}

    def has_feedthrough(self) -> bool | None:
        """Return whether an output depends on an input within a step; None if the FMU does not tell."""
        found = self.dependencies().values()
        if any(found):
            return True
        return None if any(names is None for names in found) and self.names("input") else False

    @property
    def can_roll_back(self) -> bool:
        """Whether its state can be got and set."""
        return bool(self.description.coSimulation.canGetAndSetFMUstate)

    @property
    def can_serialise(self) -> bool:
        """Whether its state can be kept beyond the process."""
        return self.can_roll_back and bool(self.description.coSimulation.canSerializeFMUstate)

    @property
    def takes_any_step(self) -> bool:
        """Whether its communication step may change during a run."""
        return bool(self.description.coSimulation.canHandleVariableCommunicationStepSize)

    @property
    def inner_step(self) -> float | None:
        """Step that it makes inside, of which a communication step is best a multiple [s]; None if it does not tell."""
        inner = self.description.coSimulation.fixedInternalStepSize
        return None if inner is None else float(inner)

    @property
    def once_per_process(self) -> bool:
        """Whether a process can hold one instance of it only."""
        return bool(self.description.coSimulation.canBeInstantiatedOnlyOncePerProcess)


def _place(variable: ScalarVariable) -> tuple[str, int]:
    """Return what an FMU knows a variable by: the functions that get it, and its value reference."""
    return _getter(variable.type), variable.valueReference


def _getter(fmi_type: str) -> str:
    """Return the type whose functions get and set variables of a type in FMI 2.0; FMI 3.0 has references apart."""
    return "Integer" if fmi_type == "Enumeration" else fmi_type


def _shape(declared: ScalarVariable, structure: Mapping[str, int]) -> tuple[int, ...]:
    """Return the sizes of an array; () for a scalar."""
    sizes = (
        d.start if d.start is not None else structure.get(d.variable.name, d.variable.start)
        for d in declared.dimensions
    )
    return tuple(int(size) for size in sizes)


def _elements(declared: ScalarVariable, structure: Mapping[str, int]) -> Iterator[Variable]:
    """Yield the scalar variables that a variable of a model description stands for."""
    shape = _shape(declared, structure)
    size = prod(shape)
    starts: list[str | None] = [None] * size
    if declared.start is not None:
        texts = str(declared.start).split() if shape and declared.type != "String" else [declared.start]
        if len(texts) in (1, size):
            starts = list(texts) * (size // len(texts))
    kind = declared.declaredType
    unit = declared.unit or getattr(kind, "unit", None)
    nominal = declared.nominal or getattr(kind, "nominal", None)
    for element, index in enumerate(product(*(range(1, n + 1) for n in shape))):
        yield Variable(
            name=f"{declared.name}[{','.join(map(str, index))}]" if shape else declared.name,
            array=declared.name,
            type=plain_type(declared.type),
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
    description, faults = read_description(folder, path)
    if description.fmiVersion.partition(".")[0] not in ("2", "3"):
        raise InputError(f"{path}: is FMI {description.fmiVersion}; FMI 2.0 or 3.0 is wanted")
    if description.coSimulation is None:
        other = "model exchange" if description.modelExchange is not None else "scheduled execution"
        raise InputError(f"{path}: offers {other} only; co-simulation is wanted")
    if not supported_platforms(str(folder)):
        raise InputError(f"{path}: holds no binaries")
    return Fmu(path, folder, description, sha256(path), (*zip_faults(path), *faults))
