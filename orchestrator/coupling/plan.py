"""An assembled system and its instances in, the index arrays and addresses of the compiled loop out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from ..fmi.file import Fmu
from ..fmi.instance import FmuInstance
from . import loop
from .algorithms import Algorithm
from .assembly import Assembly
from .bonds import Link
from .loop_calls import LAYOUTS

NUMERIC = ("Real", "Integer", "Enumeration", "Boolean")
"""Types that can be exchanged and recorded."""

Key = tuple[str, str]
"""Component and variable."""


@dataclass(frozen=True)
class Input:
    """An input that the loop sets: gain times an output plus offset.

    Attributes
    ----------
    key : component and variable
    source : the output that feeds it; None for an element of an array that nothing feeds, whose `gain` is 0
    """

    key: Key
    source: Key | None
    gain: float
    offset: float


@dataclass(frozen=True)
class Wiring:
    """Which values a system exchanges, in the order of the plan's arrays.

    Attributes
    ----------
    inputs : by component
    outputs : by component
    directions : of the power bonds
    """

    inputs: tuple[Input, ...]
    outputs: tuple[Key, ...]
    directions: tuple[str, ...]

    @classmethod
    def of(cls, assembly: Assembly) -> Wiring:
        """Return the wiring of a system; every numeric output is exchanged."""
        inputs, outputs = [], []
        for name, fmu in assembly.fmus.items():
            links = {k.wire.end_connector: k for k in assembly.links if k.wire.end_element == name}
            for variable in call_order(fmu, links):
                inputs.append(_input((name, variable), links.get(variable), assembly))
            numeric = [v for v in fmu.names("output") if fmu.variables[v].type in NUMERIC]
            outputs += [(name, variable) for variable in call_order(fmu, numeric)]
        return cls(tuple(inputs), tuple(outputs), tuple(dict.fromkeys(b.direction for b in assembly.bonds)))

    def inputs_of(self, component: str) -> slice:
        """Return where the inputs of a component stand."""
        return _part([each.key[0] for each in self.inputs], component)

    def outputs_of(self, component: str) -> slice:
        """Return where the outputs of a component stand."""
        return _part([name for name, _ in self.outputs], component)


def _part(owners: Sequence[str], component: str) -> slice:
    """Return where a component's entries stand in a list in which they follow each other."""
    first = owners.index(component) if component in owners else 0
    return slice(first, first + owners.count(component))


def _input(key: Key, link: Link | None, assembly: Assembly) -> Input:
    """Return an input as its connection feeds it, or held at its value."""
    if link is not None:
        return Input(key, (link.wire.start_element, link.wire.start_connector), link.gain, link.offset)
    start = assembly.fmus[key[0]].variables[key[1]].start
    return Input(key, None, 0.0, float(assembly.parameters[key[0]].get(key[1], start or 0.0)))


def call_order(fmu: Fmu, names: Iterable[str]) -> list[str]:
    """Return variables in the order of the description and by type, as calls exchange them; arrays become whole."""
    chosen = set(names)
    arrays = {fmu.variables[name].array for name in chosen}
    ordered = [v for v in fmu.variables.values() if v.array in arrays]
    kinds = list(dict.fromkeys(v.fmi_type for v in ordered))
    return [v.name for v in sorted(ordered, key=lambda v: kinds.index(v.fmi_type))]


def make_plan(
    assembly: Assembly,
    instances: Mapping[str, FmuInstance],
    wiring: Wiring,
    stages: Sequence[Sequence[str]],
    algorithm: Algorithm,
    periods: Mapping[str, int],
) -> loop.Plan:
    """Resolve names to indices and functions to addresses."""
    names = list(assembly.fmus)
    inputs = wiring.inputs
    ends = [each.key for each in inputs]
    place_y = {key: i for i, key in enumerate(wiring.outputs)}
    place_u = {key: i for i, key in enumerate(ends)}
    dependent = assembly.coupling().dependent()
    rolling = algorithm.sweeps > 1
    return loop.Plan(
        stage_begin=_begins([len(stage) for stage in stages]),
        order=_whole([names.index(name) for stage in stages for name in stage]),
        handle=_whole([instances[name].handle for name in names]),
        version=_whole([assembly.fmus[name].version for name in names]),
        period=_whole([periods[name] for name in names]),
        do_step=_whole([instances[name].address("DoStep") for name in names]),
        get_state=_whole([instances[name].state_function("Get") if rolling else 0 for name in names]),
        set_state=_whole([instances[name].state_function("Set") if rolling else 0 for name in names]),
        state=np.zeros(len(names), dtype=np.int64),
        answer=np.zeros((len(names), 2)),
        inputs=transfers(assembly, instances, ends, "Set"),
        outputs=transfers(assembly, instances, wiring.outputs, "Get"),
        u=np.zeros(len(inputs)),
        y=np.zeros(len(wiring.outputs)),
        source=_whole([0 if each.source is None else place_y[each.source] for each in inputs]),
        gain=np.array([each.gain for each in inputs]),
        offset=np.array([each.offset for each in inputs]),
        share=np.array([algorithm.share if rolling and name not in dependent else 1.0 for name, _ in ends]),
        u_before=np.zeros(len(inputs)),
        u_last=np.zeros(len(inputs)),
        u_scale=np.array([[assembly.fmus[e].variables[v].nominal or 0.0, 0.0] for e, v in ends]).reshape(-1, 2),
        sweeps=_whole([algorithm.sweeps, 0, 0, 0]),
        tolerance=np.array([algorithm.tolerance]),
        scratch=np.zeros(max(len(inputs), len(wiring.outputs), 1), dtype=np.uint64),
        bond_force=_whole([place_u[b.force.wire.end_element, b.force.wire.end_connector] for b in assembly.bonds]),
        bond_velocity=_whole(
            [place_y[b.velocity.wire.start_element, b.velocity.wire.start_connector] for b in assembly.bonds]
        ),
        bond_row=_whole([wiring.directions.index(b.direction) for b in assembly.bonds]),
        energy=np.zeros((len(wiring.directions), 2)),
    )


def transfers(
    assembly: Assembly, instances: Mapping[str, FmuInstance], keys: Sequence[Key], direction: str
) -> loop.Transfers:
    """Return the calls that set or get variables: one per component and type; `keys` in call order."""
    begin, functions, layouts, reference_counts, value_counts = [0], [], [], [], []
    references: list[int] = []
    for name, fmu in assembly.fmus.items():
        own = [fmu.variables[variable] for element, variable in keys if element == name]
        for kind, group in groupby(own, lambda v: v.fmi_type):
            variables = list(group)
            unique = list(dict.fromkeys(v.valueReference for v in variables))
            functions.append(instances[name].value_function(direction, kind))
            layouts.append(LAYOUTS.index(instances[name].layout(kind)))
            references += unique
            reference_counts.append(len(unique))
            value_counts.append(len(variables))
        begin.append(len(functions))
    return loop.Transfers(
        begin=_whole(begin),
        function=_whole(functions),
        layout=_whole(layouts),
        reference_begin=_begins(reference_counts),
        value_begin=_begins(value_counts),
        reference=np.array(references, dtype=np.uint32),
    )


def _whole(values: Sequence[int]) -> NDArray[np.int64]:
    return np.array(values, dtype=np.int64)


def _begins(lengths: Sequence[int]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
