"""What a component is: variables, the sizes of its arrays, and three kernels. No FMI, no files but one JSON text.

`initialise(parameters, derived, state, inputs, outputs)` and `do_step(parameters, derived, state, inputs, outputs, h)`
write into flat float arrays; integers and booleans are stored as floats.
`differentiate(parameters, derived, state, inputs, outputs, h, seed, sensitivity)` writes the change of the outputs at
the end of the last step, of size h (0 before the first step), per change of the inputs along `seed` into `sensitivity`,
and nothing else. The calculated parameters are the head of
`derived`, so that they are known after `initialise`; the local variables are the head of `state`, so that they cost
nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compile import Kernel
from .errors import DataError

Vector = NDArray[np.float64]

CAUSALITIES = ("parameter", "calculatedParameter", "local", "input", "output")


@dataclass(frozen=True)
class Variable:
    """A variable of a component as its model description shows it.

    Attributes
    ----------
    causality : {'parameter', 'calculatedParameter', 'local', 'input', 'output'}
    kind : {'Real', 'Integer', 'Boolean'}
    start : value at instantiation; None where the component calculates it
    minimum, maximum : smallest and largest value that is accepted
    depends_on : for outputs: the names of the variables that it depends on during the run
    initially_depends_on : for outputs and calculated parameters: the same in initialisation mode; None: on everything
    tunable : whether a parameter may change during the run
    """

    name: str
    causality: str
    unit: str
    description: str
    kind: str = "Real"
    start: float | None = None
    minimum: float = -math.inf
    maximum: float = math.inf
    nominal: float = 1.0
    depends_on: tuple[str, ...] = ()
    initially_depends_on: tuple[str, ...] | None = ()
    tunable: bool = False

    def __post_init__(self) -> None:
        """Check the declaration."""
        if self.causality not in CAUSALITIES:
            raise DataError(f"{self.name}: causality is {self.causality!r}; must be one of {CAUSALITIES}")
        if self.start is not None:
            self.check(self.start)

    def check(self, value: float) -> float:
        """Return `value` if this variable may have it; raise ValueError otherwise."""
        if not math.isfinite(value):
            raise DataError(f"{self.name} = {value}: must be a finite number")
        if not self.minimum <= value <= self.maximum:
            unit = "" if self.unit == "1" else f" {self.unit}"
            raise DataError(f"{self.name} = {value:g}: must be in the range {self.minimum:g} to {self.maximum:g}{unit}")
        if self.kind != "Real" and value != int(value):
            raise DataError(f"{self.name} = {value:g}: must be a whole number")
        return value


@dataclass(frozen=True)
class Component:
    """A declared component.

    Attributes
    ----------
    name : model name and model identifier
    variables : in the order of their value references
    derived_size, state_size : lengths of the arrays that only the kernels know
    kernels : module of this package that holds `initialise`, `do_step` and `differentiate`
    failure : what is said where outputs are no numbers, which ends the run; %g, if there is one, stands for the last
        local variable. Empty: such outputs mean an input that is too large
    """

    name: str
    description: str
    variables: tuple[Variable, ...]
    derived_size: int
    state_size: int
    kernels: str
    failure: str = ""

    def of(self, causality: str) -> tuple[Variable, ...]:
        """Return the variables of one causality, in order."""
        return tuple(v for v in self.variables if v.causality == causality)

    def with_starts(self, values: Mapping[str, float]) -> Component:
        """Return the component with other start values of some parameters, by name; checked.

        Raises
        ------
        DataError
            For an unknown parameter or a value out of range.
        """
        unknown = next((name for name in values if name not in self.parameter_index), None)
        if unknown is not None:
            raise DataError(f"{self.name} has no parameter {unknown!r}")
        variables = tuple(
            replace(v, start=v.check(values[v.name])) if v.name in values and v.causality == "parameter" else v
            for v in self.variables
        )
        return replace(self, variables=variables)

    @cached_property
    def parameter_index(self) -> dict[str, int]:
        """Position of each parameter in the parameter array."""
        return {v.name: i for i, v in enumerate(self.of("parameter"))}

    @property
    def differentiable(self) -> bool:
        """Whether there is a kernel `differentiate`."""
        return hasattr(import_module(f".{self.kernels}", __package__), "differentiate")

    def kernel(self, name: str) -> Kernel:
        """Return the kernel `initialise`, `do_step` or `differentiate`."""
        function: Kernel = getattr(import_module(f".{self.kernels}", __package__), name)
        return function

    def to_json(self) -> str:
        """Return this declaration as a JSON text that `from_json` reads back without loss."""
        return json.dumps(asdict(self), separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Component:
        """Return the component that `to_json` wrote."""
        data: dict[str, Any] = json.loads(text)
        data["variables"] = tuple(_variable(v) for v in data["variables"])
        return cls(**data)


def _variable(data: dict[str, Any]) -> Variable:
    """Return a variable of its JSON object, in which tuples have become lists."""
    fields: Any = {key: tuple(value) if isinstance(value, list) else value for key, value in data.items()}
    return Variable(**fields)


class Instance:
    """A running component: one block of memory, six views of it, and the kernels that work on them.

    Parameters
    ----------
    component : Component
    parameters : values by name that differ from the start values; checked

    Attributes
    ----------
    memory : everything that the future depends on; copy it to save the state, write it back to restore
    parameters, derived, state, inputs, outputs : views of `memory`, what the kernels read and write
    last_step : (1,) view of `memory`, size of the last step [s]; 0 before the first

    Raises
    ------
    DataError
        For an unknown parameter or a value out of range.
    """

    def __init__(self, component: Component, parameters: Mapping[str, float] | None = None) -> None:
        self.component = component
        starts = [v.start for v in component.of("parameter")]
        inputs = [v.start for v in component.of("input")]
        sizes = (len(starts), component.derived_size, component.state_size, len(inputs), len(component.of("output")), 1)
        self.memory: Vector = np.zeros(sum(sizes))
        views = np.split(self.memory, np.cumsum(sizes)[:-1])
        self.parameters, self.derived, self.state, self.inputs, self.outputs, self.last_step = views
        self.parameters[:] = starts
        self.inputs[:] = inputs
        self._initialise = component.kernel("initialise")
        self._do_step = component.kernel("do_step")
        for name, value in (parameters or {}).items():
            self.set_parameter(name, value)

    def places(self) -> list[int]:
        """Return where in `memory` the value of each variable stands."""
        n, d, s, i = (a.size for a in (self.parameters, self.derived, self.state, self.inputs))
        following = {
            "parameter": 0, "calculatedParameter": n, "local": n + d, "input": n + d + s, "output": n + d + s + i,
        }  # fmt: skip
        places = []
        for variable in self.component.variables:
            places.append(following[variable.causality])
            following[variable.causality] += 1
        return places

    def set_parameter(self, name: str, value: float) -> None:
        """Set one parameter by name, checked against its declared range."""
        index = self.component.parameter_index.get(name)
        if index is None:
            raise DataError(f"{self.component.name} has no parameter {name!r}")
        self.parameters[index] = self.component.of("parameter")[index].check(value)

    def initialise(self) -> None:
        """Calculate the derived quantities, the initial state and the outputs at the start."""
        self._initialise(self.parameters, self.derived, self.state, self.inputs, self.outputs)
        self.last_step[0] = 0.0
        self._check_outcome()

    def do_step(self, h: float) -> None:
        """Advance by `h` seconds with the inputs held; outputs are those at the end of the step."""
        self._do_step(self.parameters, self.derived, self.state, self.inputs, self.outputs, h)
        self.last_step[0] = h
        self._check_outcome()

    def _check_outcome(self) -> None:
        """Raise DataError if a component that may find no solution has found none."""
        if self.component.failure and not math.isfinite(self.outputs.sum()):
            reason = self.component.failure
            raise DataError(reason % self.state[len(self.component.of("local")) - 1] if "%" in reason else reason)

    def differentiate(self, seed: Vector) -> Vector:
        """Return the change of all outputs per change of the inputs along `seed`, at the end of the last step.

        The last step is thought of as made again from the same state with inputs changed a little: the directional
        derivative of FMI, at the size of the last step. Nothing but the result is written. Before the first step, the
        outputs that `initialise` made are differentiated.

        Parameters
        ----------
        seed : (number of inputs,) array, in the units of the inputs

        Returns
        -------
        (number of outputs,) array, in the units of the outputs

        Raises
        ------
        DataError
            For a seed of another length, or if the component is not differentiable.
        """
        if not self.component.differentiable:
            raise DataError(f"{self.component.name} offers no directional derivatives")
        if seed.shape != self.inputs.shape:
            raise DataError(f"seed has shape {seed.shape}; must be {self.inputs.shape}, one value per input")
        sensitivity = np.zeros(self.outputs.size)
        arrays = (self.parameters, self.derived, self.state, self.inputs, self.outputs)
        self.component.kernel("differentiate")(
            *arrays, float(self.last_step[0]), np.array(seed, dtype=float), sensitivity
        )
        return sensitivity

    @property
    def calculated(self) -> dict[str, float]:
        """The calculated parameters by name."""
        names = [v.name for v in self.component.of("calculatedParameter")]
        return dict(zip(names, self.derived[: len(names)].tolist(), strict=True))
