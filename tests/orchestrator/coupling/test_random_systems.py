"""Random systems of random FMUs: the master against a plain interpreter, written from the standard, to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import Rows
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from table_fmus import COMPILER, UNITS, WHOLE_SLOTS, Rule, Table, Twin, Var

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")

NUMBERS = st.sampled_from([-1.5, -0.75, 0.1, 0.3, 1.0, 2.5])
WEIGHTS = st.sampled_from([-0.5, -0.3, 0.1, 0.25, 0.7])


@dataclass
class Draft:
    """An FMU while it is drawn."""

    fmi: int
    variables: list[Var] = field(default_factory=list)
    rules: list[Rule] = field(default_factory=list)
    real: int = 0
    whole: int = 0

    def add(
        self, name: str, kind: str, causality: str, start: float | None = None, size: int = 0, unit: str = ""
    ) -> Var:
        """Add a variable of a kind; slots and references in the order of adding, shared by the types of FMI 2.0."""
        types = {"Real": "Float64", "Integer": "Int64", "Boolean": "Boolean"}
        kind, own = (kind, kind) if kind in types else ("Integer" if "Int" in kind else "Real", kind)
        slot = self.real if kind == "Real" else WHOLE_SLOTS + self.whole
        reference = slot % WHOLE_SLOTS if self.fmi == 2 else len(self.variables) + 1
        fmi_type = kind if self.fmi == 2 else types.get(own, own)
        variable = Var(name, reference, fmi_type, causality, slot, start, size if self.fmi == 3 else 0, unit)
        self.real, self.whole = (
            (self.real + variable.count, self.whole) if kind == "Real" else (self.real, self.whole + variable.count)
        )
        self.variables.append(variable)
        return variable

    def alias(self, of: Var, name: str) -> None:
        """Give a variable a second name."""
        self.variables.append(Var(**{**vars(of), "name": name, "alias": of.name}))


@st.composite
def tables(draw: Any, name: str) -> Table:
    """Return an FMU: inputs, parameters, states and outputs of all types, aliases, dependencies told or not."""
    d = Draft(draw(st.sampled_from([2, 3])))
    units = st.sampled_from(["", "", *UNITS])
    real = [
        d.add(f"u{k}", "Real", "input", draw(NUMBERS), draw(st.sampled_from([0, 0, 2])), draw(units))
        for k in range(draw(st.integers(0, 2)))
    ]
    whole = [d.add(f"n{k}", "Integer", "input", draw(st.integers(-9, 9))) for k in range(draw(st.integers(0, 2)))]
    switch = [d.add("b", "Boolean", "input", draw(st.booleans()))] if draw(st.booleans()) else []
    gain = d.add("p", "Real", "parameter", draw(NUMBERS))
    fed = [v.slot + k for v in (*real, *whole, *switch) for k in range(v.count)]
    states = [d.add(f"x{k}", "Real", "local") for k in range(draw(st.integers(1, 2)))]
    for v in states:
        d.rules.append(Rule("s", "r", v.slot, 0.5, 0.0, draw(NUMBERS), _terms(draw, [*fed, gain.slot])))
    outputs = [
        d.add(
            f"y{k}",
            draw(st.sampled_from(["Real", "Float32"])),
            "output",
            None,
            draw(st.sampled_from([0, 0, 3])),
            draw(units),
        )
        for k in range(draw(st.integers(1, 2)))
    ]
    depends = {}
    for v in outputs:
        used = _terms(draw, fed) if draw(st.booleans()) else ()
        for k in range(v.count):
            terms = ((draw(st.sampled_from(states)).slot, 1.0 + k), *used)
            d.rules.append(Rule("o", "r", v.slot + k, terms=terms))
        if draw(st.booleans()):
            slots = {slot for slot, _ in used}
            held = [u for u in (*real, *whole, *switch) if slots & set(range(u.slot, u.slot + u.count))]
            depends[v.name] = tuple(u.name for u in held)
    if draw(st.booleans()):
        m = d.add("m", draw(st.sampled_from(["Integer", "Int32", "Int16", "UInt8"])), "output")
        summed = tuple((v.slot, 2.0) for v in whole)
        d.rules.append(Rule("s", "w", m.slot, 1.0, float(draw(st.integers(1, 7))), 0.0, summed))
        depends["m"] = ()
    if draw(st.booleans()):
        c = d.add("c", "Boolean", "output")
        d.rules.append(Rule("s", "b", c.slot, add=draw(NUMBERS), terms=((states[0].slot, -1.0),)))
        depends["c"] = ()
    for v in draw(st.lists(st.sampled_from([*outputs, *states]), max_size=2, unique_by=lambda v: v.name)):
        d.alias(v, f"{v.name}_again")
        if d.fmi == 2 and v.name in depends:
            depends[f"{v.name}_again"] = depends[v.name]
    d.variables = draw(st.permutations(d.variables))
    step = draw(st.sampled_from(["true", "false", ""]))
    flags = f'canHandleVariableCommunicationStepSize="{step}"' if step else ""
    return Table(name, d.fmi, tuple(d.variables), tuple(d.rules), depends, flags)


def _terms(draw: Any, slots: list[int]) -> tuple[tuple[int, float], ...]:
    chosen = draw(st.lists(st.sampled_from(slots), max_size=3, unique=True)) if slots else []
    return tuple((slot, draw(WEIGHTS)) for slot in chosen)


@dataclass(frozen=True)
class Case:
    """A system, how it is run, and values that are given."""

    parts: dict[str, Table]
    wires: dict[tuple[str, str], tuple[str, str]]
    values: dict[str, dict[str, float]]
    algorithm: str
    step: float
    steps: int
    every: int


def _fits(source: Var, target: Var) -> bool:
    """Return whether an output may feed an input."""
    return source.kind == target.kind or ((source.kind, target.kind) == ("Integer", "Real") and not target.unit)


@st.composite
def cases(draw: Any) -> Case:
    """Return a system of up to three FMUs."""
    parts = {name: draw(tables(f"f_{name}")) for name in "abc"[: draw(st.integers(1, 3))]}
    wires = {}
    for name, table in parts.items():
        for v in table.of("input"):
            sources = [(o, w) for o, t in parts.items() if o != name for w in t.of("output") if _fits(w, v)]
            for element in v.elements:
                if sources and draw(st.integers(0, 3)):
                    owner, source = draw(st.sampled_from(sources))
                    wires[name, element] = (owner, draw(st.sampled_from(source.elements)))
    values = {n: {"p": draw(NUMBERS)} for n in parts if draw(st.booleans())}
    step, steps = draw(st.sampled_from([0.125, 0.1, 0.07])), draw(st.integers(1, 9))
    algorithm = draw(st.sampled_from(["jacobi", "staggered"]))
    return Case(parts, wires, values, algorithm, step, steps, draw(st.integers(1, 4)))


class Interpreter:
    """A fixed-step master, one variable at a time, as FMI has the calls follow each other."""

    def __init__(self, case: Case, stages: list[list[str]]) -> None:
        self.case, self.stages = case, stages
        self.twins = {name: Twin(table) for name, table in case.parts.items()}
        self.latest: dict[tuple[str, str], float] = {}
        for name, values in case.values.items():
            for variable in case.parts[name].variables:
                if variable.name in values:
                    self.twins[name].set(variable, [values[variable.name]])
        for stage in stages:
            for name in stage:
                self.set_inputs(name)
                self.get_outputs(name)
        for name in self.twins:
            self.set_inputs(name)
        for name in self.twins:
            self.get_outputs(name)

    def set_inputs(self, name: str) -> None:
        """Set each input of which an element is connected; the other elements keep their start values."""
        for v in self.case.parts[name].of("input"):
            if not any((name, element) in self.case.wires for element in v.elements):
                continue
            held: list[float] = [v.start or 0] * v.count
            for k, element in enumerate(v.elements):
                source = self.case.wires.get((name, element))
                if source is not None:
                    held[k] = self._converted(source, v)
            self.twins[name].set(v, held)

    def _converted(self, source: tuple[str, str], target: Var) -> float:
        owner, element = source
        start = next(v for v in self.case.parts[owner].of("output") if element in v.elements)
        value = self.latest.get(source, 0)
        if start.unit and target.unit and start.unit != target.unit:
            return UNITS[start.unit] / UNITS[target.unit] * value
        return float(value) if target.kind == "Real" else value

    def get_outputs(self, name: str) -> None:
        """Get all outputs."""
        for v in self.case.parts[name].of("output"):
            for element, value in zip(v.elements, self.twins[name].get(v), strict=True):
                self.latest[name, element] = value

    def rows(self) -> Iterator[dict[str, float]]:
        """Yield what there is after the initialisation and after each step."""
        yield self.row()
        h, steps = self.case.step, self.case.steps
        stop = steps * h
        for n in range(steps):
            for stage in self.stages:
                for name in stage:
                    self.set_inputs(name)
                for name in stage:
                    last = n == steps - 1 and "true" in self.case.parts[name].flags and n * h + h > stop
                    self.twins[name].step(stop - n * h if last else h)
                for name in stage:
                    self.get_outputs(name)
            yield self.row()

    def row(self) -> dict[str, float]:
        """Return all outputs and local variables."""
        found = {f"{name}.{element}": value for (name, element), value in self.latest.items()}
        for name, table in self.case.parts.items():
            for v in table.of("local"):
                values = self.twins[name].get(v)
                found.update({f"{name}.{e}": x for e, x in zip(v.elements, values, strict=True)})
        return found


def compare(case: Case, folder: Path) -> None:
    """Run a system with the master and with the interpreter: the same rows, to the bit and in the same types."""
    files = {name: table.write(folder) for name, table in case.parts.items()}
    wires = [(f"{o}.{e}", f"{n}.{u}") for (n, u), (o, e) in case.wires.items()]
    system = read_system(write_ssd(folder / "system.ssd", files, wires)).with_parameters(
        {name: dict(values) for name, values in case.values.items()}
    )
    how = Settings(case.step, case.steps * case.step, case.algorithm, case.every, ("*",))
    assembly = assemble(system)
    if case.algorithm == "staggered" and assembly.coupling.order.loops:
        with pytest.raises(InputError, match="algebraic loop"):
            Master(assembly, how)
        how = replace(how, algorithm="jacobi")
    with Master(assembly, how) as master:
        found, columns = Rows(), master.signals()
        master.run(found)
    expected = list(Interpreter(case, [list(stage) for stage in master.stages]).rows())
    numbers = sorted({0, case.steps, *range(0, case.steps, case.every)})
    assert found.times == [n * case.step for n in numbers]
    table = np.vstack(found.parts)
    for place, column in enumerate(columns):
        wanted = [expected[n][column.name] for n in numbers]
        np.testing.assert_array_equal(column.values(table, place), np.array(wanted, column.stored), column.name)


@settings(max_examples=40, suppress_health_check=list(HealthCheck))
@given(case=cases())
def test_random_systems_run_as_the_standard_has_it(case: Case, tmp_path_factory: pytest.TempPathFactory) -> None:
    compare(case, tmp_path_factory.mktemp("system"))


@pytest.mark.slow
@settings(max_examples=1000, suppress_health_check=list(HealthCheck))
@given(case=cases())
def test_a_thousand_random_systems_run_as_the_standard_has_it(
    case: Case, tmp_path_factory: pytest.TempPathFactory
) -> None:
    compare(case, tmp_path_factory.mktemp("system"))
