"""An assembled system and its instances in, the index arrays and addresses of the compiled loop out."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..fmi.file import NUMERIC, WHOLE, Fmu, Variable
from ..fmi.instance import FmuInstance
from .algorithms import Algorithm
from .assembly import Assembly
from .bonds import Link
from .loop import data
from .loop.calls import LAYOUTS
from .texts import Texts

_DOUBLES = 0
"""Position of doubles in `LAYOUTS`."""

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
    bonds : the power bonds of the contact: structure and direction of each
    """

    inputs: tuple[Input, ...]
    outputs: tuple[Key, ...]
    bonds: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, assembly: Assembly) -> Wiring:
        """Return the wiring of a system; every numeric output is exchanged."""
        inputs: list[Input] = []
        outputs: list[Key] = []
        fed: dict[str, dict[str, Link]] = {name: {} for name in assembly.fmus}
        for link in assembly.links:
            fed[link.wire.end_element][link.wire.end_connector] = link
        for name, fmu in assembly.fmus.items():
            links = {v: link for v, link in fed[name].items() if fmu.variables[v].type in NUMERIC}
            inputs += [_input((name, variable), links.get(variable), assembly) for variable in call_order(fmu, links)]
            numeric = [v for v in fmu.names("output") if fmu.variables[v].type in NUMERIC]
            outputs += [(name, variable) for variable in call_order(fmu, numeric)]
        return cls(tuple(inputs), tuple(outputs), tuple((b.structure, b.direction) for b in assembly.bonds))


def _input(key: Key, link: Link | None, assembly: Assembly) -> Input:
    """Return an input as its connection feeds it, or held at its value."""
    if link is not None:
        return Input(key, (link.wire.start_element, link.wire.start_connector), link.gain, link.offset)
    start = assembly.fmus[key[0]].variables[key[1]].start_value
    return Input(key, None, 0.0, float(assembly.parameters[key[0]].get(key[1], start)))


def call_order(fmu: Fmu, names: Iterable[str]) -> list[str]:
    """Return variables in the order of the description and by type, as calls exchange them; arrays become whole."""
    chosen = set(names)
    arrays = {fmu.variables[name].array for name in chosen}
    ordered = [v for v in fmu.variables.values() if v.array in arrays]
    kinds = list(dict.fromkeys(v.fmi_type for v in ordered))
    return [v.name for v in sorted(ordered, key=lambda v: kinds.index(v.fmi_type))]


@dataclass(frozen=True)
class Schedule:
    """Who steps when.

    Attributes
    ----------
    algorithm : the master algorithm
    stages : components, stage by stage
    periods : communication steps that one step of a component takes
    """

    algorithm: Algorithm
    stages: Sequence[Sequence[str]]
    periods: Mapping[str, int]


def make_plan(
    assembly: Assembly,
    instances: Mapping[str, FmuInstance],
    wiring: Wiring,
    how: Schedule,
    texts: Texts,
) -> data.Plan:
    """Resolve names to indices and functions to addresses."""
    names = list(assembly.fmus)
    index = {name: k for k, name in enumerate(names)}
    inputs, fmus = wiring.inputs, list(assembly.fmus.values())
    ends = [each.key for each in inputs]
    place_y = {key: i for i, key in enumerate(wiring.outputs)}
    place_u = {key: i for i, key in enumerate(ends)}
    dependent = set(assembly.coupling.dependent())
    algorithm, rolling = how.algorithm, how.algorithm.sweeps > 1
    into = transfers(assembly, instances, ends, "Set", texts)
    out = transfers(assembly, instances, wiring.outputs, "Get", texts)
    return data.Plan(
        stage_begin=_begins([len(stage) for stage in how.stages]),
        order=_whole([index[name] for stage in how.stages for name in stage]),
        handle=_whole([instances[name].handle for name in names]),
        version=_whole([fmu.version for fmu in fmus]),
        period=_whole([how.periods[name] for name in names]),
        flexible=np.array([fmu.takes_any_step for fmu in fmus]),
        do_step=_whole([instances[name].address("DoStep") for name in names]),
        get_state=_whole([instances[name].state_function("Get") if rolling else 0 for name in names]),
        set_state=_whole([instances[name].state_function("Set") if rolling else 0 for name in names]),
        state=np.zeros(len(names), dtype=np.int64),
        answer=np.zeros((len(names), 2)),
        inputs=into,
        outputs=out,
        u=np.zeros(len(inputs)),
        u_word=np.zeros(len(inputs), dtype=np.int64),
        y=np.zeros(len(wiring.outputs)),
        y_word=np.zeros(len(wiring.outputs), dtype=np.int64),
        wide=wide(assembly, wiring.outputs),
        exact=np.array([_is_exact(each, assembly) for each in inputs], dtype=bool),
        source=_whole([0 if each.source is None else place_y[each.source] for each in inputs]),
        gain=np.array([each.gain for each in inputs]),
        offset=np.array([each.offset for each in inputs]),
        share=np.array([algorithm.share if rolling and name not in dependent else 1.0 for name, _ in ends]),
        u_before=np.zeros(len(inputs)),
        u_last=np.zeros(len(inputs)),
        u_scale=np.array([[assembly.fmus[e].variables[v].nominal or 0.0, 0.0] for e, v in ends]).reshape(-1, 2),
        ending=_whole([-1]),
        sweeps=_whole([algorithm.sweeps, 0, 0, 0]),
        tolerance=np.array([algorithm.tolerance]),
        scratch=np.zeros(max(into.size.max(initial=1), out.size.max(initial=1)), dtype=np.uint64),
        bond_force=_whole([place_u[b.force.wire.end_element, b.force.wire.end_connector] for b in assembly.bonds]),
        bond_velocity=_whole([place_y[_start(b.velocity)] for b in assembly.bonds]),
        bond_way=_whole([-1 if b.way is None else place_y[_start(b.way)] for b in assembly.bonds]),
        bond_gain=np.array([b.factors for b in assembly.bonds]).reshape(-1, 2),
        bond_owner=_whole([index[b.velocity.wire.start_element] for b in assembly.bonds]),
        bond_before=np.zeros((len(assembly.bonds), 2)),
        energy=np.zeros((len(assembly.bonds), 2)),
    )


def _start(link: Link) -> Key:
    """Return the output that a connection begins at."""
    return link.wire.start_element, link.wire.start_connector


def wide(assembly: Assembly, keys: Sequence[Key]) -> NDArray[np.int64]:
    """Return the positions of whole numbers of 64 bits, which a double need not hold, among some variables.

    Enumerations of FMI 3.0 are such, too.
    """
    kinds = [(assembly.fmus[e].variables[name].fmi_type, assembly.fmus[e].version) for e, name in keys]
    large = {("Int64", 3), ("UInt64", 3), ("Enumeration", 3)}
    return _whole([k for k, kind in enumerate(kinds) if kind in large])


def _is_exact(each: Input, assembly: Assembly) -> bool:
    """Return whether an input is a whole number just as another FMU puts it out."""
    if each.source is None or (each.gain, each.offset) != (1.0, 0.0):
        return False
    return all(assembly.fmus[element].variables[name].type in WHOLE for element, name in (each.source, each.key))


def transfers(
    assembly: Assembly,
    instances: Mapping[str, FmuInstance],
    keys: Sequence[Key],
    direction: str,
    texts: Texts | None = None,
) -> data.Transfers:
    """Return the calls that set or get variables: one per component and type, and one for the texts of a component.

    Variables that share a value reference are exchanged once. An input that a table feeds is in no call but that of
    the texts, and stands in the plan so that an iteration sees its source change.
    """
    own: dict[str, dict[str, list[int]]] = {}
    for place, (element, name) in enumerate(keys):
        kind = assembly.fmus[element].variables[name].fmi_type
        if direction == "Get" or texts is None or not texts.looks_up(element, name):
            own.setdefault(element, {}).setdefault(kind, []).append(place)
    begin, functions, calls = [0], [], []
    for name, fmu in assembly.fmus.items():
        for kind, places in own.get(name, {}).items():
            variables = [fmu.variables[keys[place][1]] for place in places]
            functions.append(instances[name].value_function(direction, kind))
            calls.append(_Call.of(variables, places, LAYOUTS.index(instances[name].layout(kind))))
        if texts is not None and texts.function(name, direction):
            functions.append(texts.function(name, direction))
            calls.append(_Call(-1, [], 0, [], []))
        begin.append(len(functions))
    return data.Transfers(
        begin=_whole(begin),
        function=_whole(functions),
        layout=_whole([call.layout for call in calls]),
        reference_begin=_begins([len(call.references) for call in calls]),
        size=_whole([call.size for call in calls]),
        direct=np.array([call.direct for call in calls], dtype=bool),
        value_begin=_begins([len(call.places) for call in calls]),
        place=_whole([place for call in calls for place in call.places]),
        slot=_whole([slot for call in calls for slot in call.slots]),
        reference=np.array([r for call in calls for r in call.references], dtype=np.uint32),
    )


@dataclass(frozen=True)
class _Call:
    """One call that sets or gets variables, see `data.Transfers`."""

    layout: int
    references: list[int]
    size: int
    places: list[int]
    slots: list[int]

    @classmethod
    def of(cls, variables: Sequence[Variable], places: list[int], layout: int) -> _Call:
        """Return the call that exchanges variables of one type, each value reference once."""
        sizes = {v.valueReference: v.size for v in variables}
        first = dict(zip(sizes, _begins(list(sizes.values())).tolist(), strict=False))
        slots = [first[v.valueReference] + v.element for v in variables]
        return cls(layout, list(sizes), sum(sizes.values()), places, slots)

    @property
    def direct(self) -> bool:
        """Whether the values stand in the plan just as the function exchanges them."""
        side_by_side = self.places == list(range(self.places[0], self.places[0] + self.size)) if self.places else False
        return self.layout == _DOUBLES and side_by_side and self.slots == list(range(self.size))


def _whole(values: Sequence[int]) -> NDArray[np.int64]:
    return np.array(values, dtype=np.int64)


def _begins(lengths: Sequence[int]) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
