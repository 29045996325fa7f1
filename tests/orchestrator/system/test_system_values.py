"""Values of parameters in systems, through bindings, mappings, units and connectors: the numbers are closed forms."""

from __future__ import annotations

import re
import zipfile
from io import StringIO
from pathlib import Path

import pytest
from block_systems import (
    FLAT,
    FROM_FILE,
    INNER,
    NAMESPACES,
    ONE,
    UNITS,
    archive,
    component,
    connector,
    description,
    inline,
    mapping,
    outputs,
    parameter_set,
    simulate,
    system,
    wire,
)
from rich.console import Console

from orchestrator.commands.systems.info import tables
from orchestrator.coupling.assembly import assemble
from orchestrator.errors import InputError
from orchestrator.stability.cases import system_inputs
from orchestrator.system.inspection import describe
from orchestrator.system.reader import read_system


def test_bindings_of_a_higher_level_win_and_later_ones_of_the_same(tmp_path: Path, block: Path) -> None:
    """Component, inner system and root bind the same parameter; each also binds one that nobody above does."""
    leaf = component("m", inline({"b": 1.0, "k": 1.0, "n": 1}) + inline({"n": 2}))
    inner = system(leaf, bindings=inline({"m.b": 2.0, "m.k": 5.0}), name="inner")
    root = system(inner, bindings=inline({"inner.m.b": 100.0}) + inline({"b": 4.0}, prefix="inner.m."))
    assert outputs(tmp_path, block, description(root)) == {"inner.m.y": 8.0}
    assert simulate(tmp_path / "b.ssp").assembly.parameters["inner.m"] == {"b": 4.0, "k": 5.0, "n": 2}


def test_parameters_of_every_type_arrive(tmp_path: Path, block: Path) -> None:
    values = {"b": 2.5, "n": -3, "on": True, "s": "two words"}
    run = simulate(archive(tmp_path / "a.ssp", block, description(system(component("m", inline(values))))))
    assert run.outputs == {"m.y": -7.5}
    assert run.assembly.parameters["m"] == values
    off = description(system(component("m", inline({**values, "on": False}))))
    assert outputs(tmp_path, block, off) == {"m.y": 0.0}


def test_mappings_convert_before_they_transform(tmp_path: Path, block: Path) -> None:
    """Into the unit of the target first: 4 ell are 2 m, times 10 plus 1; suppressed, it is 4 times 10 plus 1."""
    change = '<ssc:LinearTransformation factor="10" offset="1"/>'
    entry = f'<ssm:MappingEntry source="x" target="b"{{}}>{change}</ssm:MappingEntry>'
    for more, expected in (("", 21.0), (' suppressUnitConversion="true"', 41.0)):
        ssm = f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{entry.format(more)}</ssm:ParameterMapping>'
        binding = inline({"x": 4.0}, "ell", f"<ssd:ParameterMapping>{ssm}</ssd:ParameterMapping>")
        ports = connector("b", "parameter", "m")
        ssd = description(system(component("m", binding, connectors=ports)), more=UNITS)
        assert outputs(tmp_path, block, ssd) == {"m.y": expected}


def test_mapping_tables_of_numbers_and_truth(tmp_path: Path, block: Path) -> None:
    number = (
        '<ssc:IntegerMappingTransformation><ssc:MapEntry source="1" target="7"/></ssc:IntegerMappingTransformation>'
    )
    truth = (
        '<ssc:BooleanMappingTransformation><ssc:MapEntry source="false" target="true"/>'
        '<ssc:MapEntry source="true" target="false"/></ssc:BooleanMappingTransformation>'
    )
    table = mapping(("count", "n", number), ("off", "on", truth), ("b", "b", ""))
    binding = inline(
        {"count": 1, "off": False, "b": 2.0}, mapping=f"<ssd:ParameterMapping>{table}</ssd:ParameterMapping>"
    )
    assert outputs(tmp_path, block, description(system(component("m", binding)))) == {"m.y": 14.0}


def test_units_change_at_every_connector_on_the_way(tmp_path: Path, block: Path) -> None:
    """3 m leave m1, pass a connector in mm, are doubled there, and enter m2 in km; suppressed, 3 stays 3."""

    def nested(more: str) -> str:
        inner = system(
            component("m2", units=("km", "")), wire("u", "m2.u"), connector("u", "input", "mm"), name="inner"
        )
        change = '<ssc:LinearTransformation factor="2"/>'
        return description(system(component("m1", ONE, units=("", "m")) + inner, wire("m1.y", "inner.u", change, more)))

    assert outputs(tmp_path, block, nested(""))["inner.m2.y"] == pytest.approx(6e-3, rel=1e-15)
    suppressed = nested(' suppressUnitConversion="true"')
    assert outputs(tmp_path, block, suppressed)["inner.m2.y"] == pytest.approx(6e-6, rel=1e-15)


def test_values_of_system_connectors_reach_parameters_through_their_connections(tmp_path: Path, block: Path) -> None:
    """A parameter connector of an inner system, bound at the root in mm, wired with a factor to a block's b in m."""
    ports = connector("b", "parameter", "m") + connector("y", "output")
    inner = system(
        component("m", inline({"b": 50.0}), connectors=ports),
        wire("length", "m.b", '<ssc:LinearTransformation factor="3"/>') + wire("m.y", "y"),
        connector("length", "parameter", "mm") + connector("y", "output"),
        name="inner",
    )
    root = system(inner, wire("inner.y", "out"), connector("out", "output"), inline({"inner.length": 4.0}, "m"))
    run = simulate(archive(tmp_path / "a.ssp", block, description(root)))
    assert run.outputs == pytest.approx({"inner.m.y": 12.0}, rel=1e-15)
    assert [str(link.wire) for link in run.assembly.outputs] == ["inner.m.y -> out"]


def test_shared_parameter_sets_are_passed_over_with_a_notice(tmp_path: Path, block: Path) -> None:
    """SSP ignores what matches no variable, so that components can share a set; the user hears of it."""
    root = system(component("m", FROM_FILE), bindings=inline({"axle.b": 1.0}))
    files = {"resources/values.ssv": parameter_set({"b": 2.0, "kk": 1.0})}
    run = simulate(archive(tmp_path / "a.ssp", block, description(root), files))
    assert run.outputs == {"m.y": 2.0}
    said = "\n".join(run.assembly.notices)
    assert "SystemStructure.ssd, line 2, Parameter 'axle.b': no component has it, so it is not applied" in said
    assert "values.ssv, line 1, Parameter 'kk': not applied to m: block.fmu has no variable 'kk'; did you mean" in said


def test_info_shows_nesting_values_and_changes(tmp_path: Path, block: Path) -> None:
    """As data for programs, and as a tree and tables for people."""
    change = '<ssc:LinearTransformation factor="-2" offset="1"/>'
    root = system(component("m1", ONE) + INNER, wire("m1.y", "inner.u", change), bindings=inline({"inner.m2.b": 4.0}))
    path = archive(tmp_path / "a.ssp", block, description(root), {"b.ssd": description(FLAT, "flat")})
    found = describe(path)
    assert (found["system"], found["ssp"], found["variants"]) == ("blocks", "1.0", ["blocks", "flat"])
    first, second = found["components"]
    assert [(p["name"], p["value"]) for p in second["parameters"]] == [("k", 2.0), ("b", 4.0)]
    assert first["parameters"][0]["from"].endswith("a.ssp: SystemStructure.ssd, line 2, Parameter 'b'")
    assert found["connections"] == [{"from": "m1.y", "to": "inner.m2.u", "change": "* -2 + 1"}]
    screen = Console(width=100, record=True, file=StringIO())
    for shown in tables(found):
        screen.print(shown)
    text = screen.export_text()
    assert re.search(r"└── inner\n +└── m2  \(block.fmu\)\n +├── k = 2.0\n +└── b = 4.0\n", text)
    assert [c["name"] for c in describe(Path(f"{path}#flat"))["components"]] == ["m1", "m2"]


def test_stability_takes_values_in_the_fmus_units(tmp_path: Path, built: Path) -> None:
    """A contact stiffness in kN/mm is the same contact as one in N/m."""
    folder = tmp_path / "system"
    with zipfile.ZipFile(built / "curvesqueal.ssp") as packed:
        packed.extractall(folder)
    values = folder / "resources" / "contact-case1.ssv"
    text = re.sub(r'<ssv:Parameter name="hertz_stiffness">.*?</ssv:Parameter>', "", values.read_text(), flags=re.DOTALL)
    stiffnesses = []
    for value, unit in ((1.5e9, "N/m"), (1.5e3, "kN/mm")):
        more = f'<ssv:Parameter name="hertz_stiffness"><ssv:Real value="{value}" unit="{unit}"/></ssv:Parameter>'
        values.write_text(text.replace("</ssv:Parameters>", f"{more}</ssv:Parameters>"))
        _, contact = system_inputs(str(folder / "SystemStructure.ssd"), "class158", "rigid")
        stiffnesses.append(contact.stiffness)
    assert stiffnesses[0] == pytest.approx(1.5e9, rel=1e-6)  # a difference quotient
    assert stiffnesses[1] == pytest.approx(stiffnesses[0], rel=1e-9)


def test_enumerations_and_units_of_the_fmu_count(tmp_path: Path, block: Path) -> None:
    """A block whose n is of the FMU's own enumeration and whose b is in a unit that only the FMU defines."""
    with zipfile.ZipFile(block) as packed:
        content = {name: packed.read(name) for name in packed.namelist()}
    types = (
        '<UnitDefinitions><Unit name="ell"><BaseUnit m="1" factor="0.5"/></Unit></UnitDefinitions><TypeDefinitions>'
        '<SimpleType name="Gear"><Enumeration><Item name="slow" value="1"/><Item name="fast" value="3"/></Enumeration>'
        "</SimpleType></TypeDefinitions><LogCategories>"
    )
    text = content["modelDescription.xml"].decode().replace("<LogCategories>", types)
    text = re.sub(r'(name="n".*?)<Integer', r'\1<Enumeration declaredType="Gear"', text, flags=re.DOTALL)
    text = re.sub(r'(name="b".*?)<Real', r'\1<Real unit="ell"', text, flags=re.DOTALL)
    with zipfile.ZipFile(tmp_path / "geared.fmu", "w") as packed:
        for name, data in {**content, "modelDescription.xml": text.encode()}.items():
            packed.writestr(name, data)

    def ssd(item: str) -> str:
        items = '<ssc:Item name="slow" value="0"/><ssc:Item name="fast" value="1"/>'
        kind = f'<ssv:Enumerations><ssc:Enumeration name="G">{items}</ssc:Enumeration></ssv:Enumerations>'
        values = inline({"b": 1.0, "n": 1}, "mm").replace("</ssv:Parameters>", f"</ssv:Parameters>{kind}")
        values = values.replace('<ssv:Integer value="1"', f'<ssv:Enumeration name="G" value="{item}"')
        return description(system(component("m", values)))

    run = simulate(archive(tmp_path / "a.ssp", tmp_path / "geared.fmu", ssd("fast")))
    assert run.assembly.parameters["m"] == pytest.approx({"b": 2e-3, "n": 3}, rel=1e-15)
    assert run.outputs == pytest.approx({"m.y": 6e-3}, rel=1e-15)
    with pytest.raises(InputError, match=r"Parameter 'n': 'reverse' is no item of 'G'; it has slow, fast"):
        read_system(archive(tmp_path / "b.ssp", tmp_path / "geared.fmu", ssd("reverse")))
    given = read_system(tmp_path / "a.ssp").with_parameters({"m": {"n": "reverse"}})
    with pytest.raises(InputError, match=r"parameter m.n = reverse: must be one of slow, fast"):
        assemble(given)
