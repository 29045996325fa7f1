"""Mapping tables in connections: what comes out is worked out by hand; tables are such that twice is not once."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fmi3_fmu import write_ssd
from foreign_fmus import ANY_STEP, Rows, U, Y, foreign_fmu, variable
from table_fmus import COMPILER, WHOLE_SLOTS, Rule, Table, Var

from orchestrator.coupling.assembly import Assembly, assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.results.file import open_results
from orchestrator.runs.export import export_system
from orchestrator.runs.identity import difference, resolved
from orchestrator.runs.run import Report, run_scenario
from orchestrator.runs.scenario import Scenario
from orchestrator.system.inspection import describe
from orchestrator.system.model import Hop, MapTable
from orchestrator.system.reader import read_system

pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMUs")

FOUR = Settings(0.25, 1.0, record_every=1)
AROUND = {1: 2, 2: 3, 3: 4, 4: 1, 0: 9}


def table_of(kind: str, entries: Mapping[Any, object]) -> str:
    """Return a mapping transformation."""
    rows = "".join(f'<ssc:MapEntry source="{s}" target="{t}"/>' for s, t in entries.items())
    return f"<ssc:{kind}MappingTransformation>{rows}</ssc:{kind}MappingTransformation>"


def counter(folder: Path, fmi: int, kind: str = "", size: int = 0) -> tuple[Path, Path]:
    """Return an FMU that counts its steps in `n`, and one whose `m` is its input `k` at once."""
    whole = kind or ("Integer" if fmi == 2 else "Int32")
    n, slots = Var("n", 1, whole, "output", WHOLE_SLOTS, size=size), max(size, 1)
    count = tuple(Rule("s", "w", WHOLE_SLOTS + k, 1.0, 1.0 + k) for k in range(slots))
    k, m = (
        Var("k", 1, whole, "input", WHOLE_SLOTS, 0, size),
        Var("m", 2, whole, "output", WHOLE_SLOTS + slots, None, size),
    )
    same = tuple(Rule("o", "w", m.slot + i, terms=((k.slot + i, 1.0),)) for i in range(slots))
    return (
        Table("count", fmi, (n,), count, {"n": ()}).write(folder),
        Table("same", fmi, (k, m), same, {"m": ("k",)}).write(folder),
    )


def connected(ssd: Path, change: str) -> Path:
    """Put a transformation into all connections of an SSD."""
    head, mark, tail = ssd.read_text().partition("<ssd:Connection ")
    ssd.write_text(head + mark + tail.replace("/><ssd:Connection ", f">{change}</ssd:Connection><ssd:Connection ")
                   .replace("/></ssd:Connections>", f">{change}</ssd:Connection></ssd:Connections>"))  # fmt: skip
    return ssd


def run(assembly: Assembly, how: Settings = FOUR) -> dict[str, list[float]]:
    """Return the signals of a run."""
    rows = Rows()
    with Master(assembly, how) as master:
        master.run(rows)
        return {name: values.tolist() for name, values in rows.columns(master.signals()).items()}


@pytest.mark.parametrize("fmi", [2, 3])
def test_whole_numbers_are_looked_up_once_per_exchange(tmp_path: Path, fmi: int) -> None:
    """At once, a step later with jacobi, and at the end of an iteration, which sees its source change."""
    count, same = counter(tmp_path, fmi)
    ssd = connected(
        write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")]), table_of("Integer", AROUND)
    )
    wanted = [9, 2, 3, 4, 1]
    for algorithm in ("staggered", "iterative"):
        found = run(assemble(read_system(ssd)), replace(FOUR, algorithm=algorithm))
        assert (found["a.n"], found["b.m"]) == ([0, 1, 2, 3, 4], wanted)
    late = run(assemble(read_system(ssd)), replace(FOUR, algorithm="jacobi"))
    assert late["b.m"] == [9, *wanted[:-1]]


def test_arrays_are_looked_up_element_by_element(tmp_path: Path) -> None:
    count, same = counter(tmp_path, 3, size=2)
    wide = {k: 40 - 3 * k for k in range(9)}
    ssd = connected(write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")]), table_of("Integer", wide))
    found = run(assemble(read_system(ssd)))
    for k in (1, 2):
        assert found[f"b.m[{k}]"] == [40 - 3 * n for n in found[f"a.n[{k}]"]]
    assert found["a.n[2]"][-1] == 8
    part = write_ssd(tmp_path / "part.ssd", {"a": count, "b": same}, [("a.n[1]", "b.k[2]")])
    with pytest.raises(InputError, match=r"input b\.k: mapping tables feed a part of it, not b?\.?k\[1\]; must be all"):
        assemble(read_system(connected(part, table_of("Integer", wide))))


def test_whole_numbers_of_64_bits_stay_exact(tmp_path: Path) -> None:
    """In tables of SSP 2.0; those of 1.0 have 32 bits."""
    count, same = counter(tmp_path, 3, "Int64")
    ssd = write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")])
    table = table_of("Integer", {k: 2**62 + 1 + k for k in range(5)})
    ssd.write_text(ssd.read_text().replace('Description version="1.0"', 'Description version="2.0"'))
    found = assemble(read_system(connected(ssd, table)))
    with Master(found, FOUR) as master:
        master.run()
        assert master.instances["b"].get_words(["k"]) == [2**62 + 5]


def levels(folder: Path, name: str, items: dict[str, int], causality: str, step: str) -> Path:
    """Return an FMU with an enumeration `e`, the number `n` that it sees, and a truth value `b`."""
    rows = "".join(f'<Item name="{key}" value="{value}"/>' for key, value in items.items())
    types = (
        f'<TypeDefinitions><SimpleType name="Level"><Enumeration>{rows}</Enumeration></SimpleType></TypeDefinitions>'
    )
    start = ' start="1"' if causality == "input" else ""
    truth = ' start="false"' if causality == "input" else ""
    variables = (
        f'<ScalarVariable name="e" valueReference="0" causality="{causality}" variability="discrete">'
        f'<Enumeration declaredType="Level"{start}/></ScalarVariable>'
        f'<ScalarVariable name="b" valueReference="1" causality="{causality}" variability="discrete">'
        f"<Boolean{truth}/></ScalarVariable>"
    )
    variables += variable("n", 2, "output", "Integer") + variable("t", 3, "output", "Integer")
    return foreign_fmu(
        folder / f"{name}.fmu", variables, step=step, init=step, create="m->i[0]=1", before=types, attributes=ANY_STEP
    )


def test_items_and_truth_values_are_looked_up(tmp_path: Path) -> None:
    """Items by name, each FMU with its own numbers for them; true becomes false."""
    first = levels(tmp_path, "x", {"low": 1, "high": 2}, "output", "m->i[0]=1+m->n%2; m->i[1]=m->n%2")
    second = levels(tmp_path, "z", {"off": 7, "on": 3}, "input", "m->i[2]=m->i[0]; m->i[3]=m->i[1]")
    parts = {"a": first, "b": second}
    ssd = connected(
        write_ssd(tmp_path / "s.ssd", parts, [("a.e", "b.e")]), table_of("Enumeration", {"low": "off", "high": "on"})
    )
    found = run(assemble(read_system(ssd)))
    assert (found["a.e"], found["b.n"]) == ([1, 2, 1, 2, 1], [7, 3, 7, 3, 7])
    not_b = table_of("Boolean", {"true": "false", "0": "1"})
    found = run(assemble(read_system(connected(write_ssd(tmp_path / "b.ssd", parts, [("a.b", "b.b")]), not_b))))
    assert (found["a.b"], found["b.t"]) == ([False, True, False, True, False], [1, 0, 1, 0, 1])
    half = connected(write_ssd(tmp_path / "h.ssd", parts, [("a.e", "b.e")]), table_of("Enumeration", {"low": "on"}))
    with pytest.raises(
        SimulationError, match=r"connection a\.e -> b\.e: the mapping table has no MapEntry for 2 \(high\)$"
    ):
        run(assemble(read_system(half)))
    bad = connected(write_ssd(tmp_path / "i.ssd", parts, [("a.e", "b.e")]), table_of("Enumeration", {"low": "up"}))
    with pytest.raises(InputError, match=r"a\.e -> b\.e: MapEntry: e has no item 'up'; it has off, on"):
        assemble(read_system(bad))


def of_items(table: Table, name: str, items: list[str]) -> Table:
    """Return an FMU of FMI 3.0 whose Int64 of this name is an enumeration, its items counted from 1."""
    rows = "".join(f'<Item name="{item}" value="{k}"/>' for k, item in enumerate(items, 1))
    types = f'<TypeDefinitions><EnumerationType name="L">{rows}</EnumerationType></TypeDefinitions><ModelVariables>'
    typed = re.sub(
        f'<Int64 name="{name}"(.*?)(/>|></Int64>)', rf'<Enumeration declaredType="L" name="{name}"\1/>', table._xml3()
    )
    return replace(table, xml=typed.replace("<ModelVariables>", types))


def test_items_of_fmi_3(tmp_path: Path) -> None:
    """They have 64 bits: looked up, recorded and written as the whole numbers that they are."""
    n, k, m = (Var("n", 1, "Int64", "output", WHOLE_SLOTS), Var("k", 1, "Int64", "input", WHOLE_SLOTS, 1),
               Var("m", 2, "Int64", "output", WHOLE_SLOTS + 1))  # fmt: skip
    count = Table("count", 3, (replace(n, start=1),), (Rule("s", "w", n.slot, 1.0, 1.0),), {"n": ()})
    same = Table("same", 3, (k, m), (Rule("o", "w", m.slot, terms=((k.slot, 1.0),)),), {"m": ("k",)})
    parts = {
        "a": of_items(count, "n", ["low", "high", "top"]).write(tmp_path),
        "b": of_items(same, "k", ["on", "off"]).write(tmp_path),
    }
    ssd = write_ssd(tmp_path / "s.ssd", parts, [("a.n", "b.k")], stop=0.5)
    table = table_of("Enumeration", {"low": "off", "high": "on", "top": "off"})
    outcome = run_scenario(
        Scenario(str(connected(ssd, table)), step=0.25, record_every=1), tmp_path / "r", Report(picture=False)
    )
    with open_results(outcome.results) as data:
        assert data["a.n"].dtype == "int64"
        assert (data["a.n"].to_numpy().tolist(), data["b.m"].to_numpy().tolist()) == ([1, 2, 3], [2, 1, 2])


def test_a_value_without_an_entry_ends_the_run(tmp_path: Path) -> None:
    """In one sentence with connection, value and time; what was computed is kept."""
    count, same = counter(tmp_path, 2)
    parts = {"a": count, "b": same}
    ssd = connected(write_ssd(tmp_path / "s.ssd", parts, [("a.n", "b.k")]), table_of("Integer", {0: 5, 1: 6, 2: 7}))
    rows = Rows()
    with Master(assemble(read_system(ssd)), FOUR) as master, pytest.raises(SimulationError) as caught:
        master.run(rows)
    assert str(caught.value) == (
        "b: setting inputs returned error at t = 0.5 s: connection a.n -> b.k: the mapping table has no MapEntry for 3"
    )
    assert rows.columns(master.signals())["b.m"].tolist() == [5, 6, 7]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (table_of("Boolean", {1: 0}), "a.n -> b.k: BooleanMappingTransformation is for Boolean; n is Integer"),
        (table_of("Enumeration", {"a": "b"}), ": EnumerationMappingTransformation is for Enumeration; n is Integer"),
        (table_of("Integer", {1: 2**31}), "'2147483648' is not a valid value of the atomic type 'xs:int'"),
        (
            table_of("Integer", {1: 2}).replace("</ssc:I", '<ssc:MapEntry source="+1" target="3"/></ssc:I'),
            "the IntegerMappingTransformation has two entries for '+1', and they differ",
        ),
    ],
)  # fmt: skip
def test_tables_that_do_not_fit_are_refused(tmp_path: Path, change: str, message: str) -> None:
    count, same = counter(tmp_path, 2)
    ssd = connected(write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")]), change)
    with pytest.raises(InputError) as caught:
        assemble(read_system(ssd))
    assert message in str(caught.value)


def test_tables_on_one_way_are_looked_up_one_after_the_other(tmp_path: Path) -> None:
    """As through the connectors of a system; what the second one does not have has no entry; no factor besides."""
    count, same = counter(tmp_path, 3)
    system = read_system(write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")]))

    def with_way(*hops: Hop) -> Assembly:
        return assemble(replace(system, wires=(replace(system.wires[0], hops=hops),)))

    first = Hop(table=MapTable("Integer", ((0, 3), (1, 5), (2, 7), (3, 3), (4, 5))))
    found = run(with_way(first, Hop(), Hop(table=MapTable("Integer", ((3, -3), (5, 2), (7, 0), (0, 8))))))
    assert found["b.m"] == [-3, 2, 0, -3, 2]
    with pytest.raises(SimulationError, match=r"has no MapEntry for 2$"):
        run(with_way(first, Hop(table=MapTable("Integer", ((3, -3), (5, 2))))))
    for other in (Hop(factor=2.0, declared=True), Hop(table=MapTable("Boolean", ((True, False),)))):
        with pytest.raises(
            InputError, match=r"a\.n -> b\.k: IntegerMappingTransformation and a transformation of another"
        ):
            with_way(first, other)


def test_a_real_input_takes_no_table(tmp_path: Path) -> None:
    count, _ = counter(tmp_path, 2)
    real = foreign_fmu(tmp_path / "r.fmu", U + Y, step="m->r[1]=m->r[0]")
    ssd = write_ssd(tmp_path / "s.ssd", {"a": count, "b": real}, [("a.n", "b.u")])
    with pytest.raises(InputError, match=r"b.u: IntegerMappingTransformation is for Integer; u is Real"):
        assemble(read_system(connected(ssd, table_of("Integer", AROUND))))


def test_export_info_and_identity_have_the_table(tmp_path: Path) -> None:
    count, same = counter(tmp_path, 2)
    ssd = connected(
        write_ssd(tmp_path / "s.ssd", {"a": count, "b": same}, [("a.n", "b.k")]), table_of("Integer", AROUND)
    )
    assembly = assemble(read_system(ssd))
    export_system(assembly, FOUR, tmp_path / "out.ssp")
    again = assemble(read_system(tmp_path / "out.ssp"))
    assert run(again) == run(assembly)
    assert difference(resolved(assembly, FOUR), resolved(again, FOUR)) is None
    ssd.write_text(ssd.read_text().replace('source="4" target="1"', 'source="4" target="8"'))
    other = assemble(read_system(ssd))
    assert difference(resolved(assembly, FOUR), resolved(other, FOUR)) == (
        "tables: a.n -> b.k was [[0, 9], [1, 2], [2, 3], [3, 4], [4, 1]] and is "
        "[[0, 9], [1, 2], [2, 3], [3, 4], [4, 8]]"
    )
    assert "1 becomes 2, 2 becomes 3" in str(describe(ssd))
