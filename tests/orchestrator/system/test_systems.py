"""Systems as other tools write them, each a real SSP of real FMUs run by the master: the numbers are closed forms."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Mapping
from io import StringIO
from pathlib import Path

import pytest
from block_systems import (
    NAMESPACES,
    archive,
    block_fmu,
    component,
    connector,
    description,
    inline,
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


@pytest.fixture(scope="module")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return block_fmu(tmp_path_factory.mktemp("block"))


PAIR = wire("m1.y", "m2.u")
FROM_FILE = '<ssd:ParameterBinding source="resources/values.ssv"/>'
EXPECTED = {"m1.y": 3.0, "m2.y": 7.0}
"""Outputs of two blocks in a row: m1 gives b = 3, m2 gives 2 u + 1."""

ONE, TWO = inline({"b": 3.0}), inline({"k": 2.0, "b": 1.0})
FLAT = system(component("m1", ONE) + component("m2", TWO), PAIR)


def mapping(*entries: tuple[str, str, str]) -> str:
    """Return a ParameterMapping element of sources, targets and transformations."""
    rows = "".join(
        f'<ssm:MappingEntry source="{s}" target="{t}">{change}</ssm:MappingEntry>' for s, t, change in entries
    )
    return f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{rows}</ssm:ParameterMapping>'


def table_of(kind: str, entries: Mapping[str, str]) -> str:
    """Return a mapping transformation."""
    rows = "".join(f'<ssc:MapEntry source="{s}" target="{t}"/>' for s, t in entries.items())
    return f"<ssc:{kind}MappingTransformation>{rows}</ssc:{kind}MappingTransformation>"


MAPPED = mapping(("slope", "k", '<ssc:LinearTransformation factor="0.5" offset="-3"/>'), ("height", "b", ""))
INNER = system(
    component("m2", TWO),
    wire("u", "m2.u") + wire("m2.y", "y"),
    connector("u", "input") + connector("y", "output"),
    name="inner",
)
UNITS = (
    '<ssd:Units><ssc:Unit name="m"><ssc:BaseUnit m="1"/></ssc:Unit>'
    '<ssc:Unit name="ell"><ssc:BaseUnit m="1" factor="0.5"/></ssc:Unit></ssd:Units>'
)

VARIANTS: dict[str, tuple[str, Mapping[str, str | bytes]]] = {
    "A inline values": (description(FLAT), {}),
    "B version 2.0": (description(FLAT, version="2.0"), {}),
    "C other prefixes": (
        re.sub(r"\bss([dcv])([:=])", r"tool\1\2", description(FLAT)),
        {},
    ),
    "D units on connectors": (
        description(
            system(
                component("m1", ONE, units=("m", "m"))
                + component("m2", inline({"k": 1.0, "b": 1.0}), units=("ell", "m")),
                PAIR,
            ),
            more=UNITS,
        ),
        {},
    ),
    "E system connectors": (
        description(
            system(
                component("m1") + component("m2", TWO),
                wire("in", "m1.u") + PAIR + wire("m2.y", "out"),
                connector("in", "input") + connector("out", "output"),
                inline({"in": 3.0}),
            )
        ),
        {},
    ),
    "F external SSV": (
        description(system(component("m1", ONE) + component("m2", FROM_FILE), PAIR)),
        {"resources/values.ssv": parameter_set({"k": 2.0, "b": 1.0})},
    ),
    "G SSV through SSM": (
        description(
            system(
                component("m1", ONE)
                + component(
                    "m2",
                    '<ssd:ParameterBinding source="resources/values.ssv">'
                    '<ssd:ParameterMapping source="resources/names.ssm"/></ssd:ParameterBinding>',
                ),
                PAIR,
            )
        ),
        {
            "resources/values.ssv": parameter_set({"slope": 10.0, "height": 1.0, "b": 99.0}),
            "resources/names.ssm": MAPPED,
        },
    ),
    "H LinearTransformation": (
        description(
            system(
                component("m1", ONE) + component("m2", inline({"k": -4.0})),
                wire("m1.y", "m2.u", '<ssc:LinearTransformation factor="-1" offset="1.25"/>'),
            )
        ),
        {},
    ),
    "I nested system": (description(system(component("m1", ONE) + INNER, wire("m1.y", "inner.u"))), {}),
    "J system-level SSV": (
        description(system(component("m1") + component("m2", ONE), PAIR, bindings=FROM_FILE)),
        {"resources/values.ssv": parameter_set({"m1.b": 3.0, "m2.k": 2.0, "m2.b": 1.0})},
    ),
    "K percent-encoded source": (description(FLAT.replace("resources/block.fmu", "resources/my%20block.fmu")), {}),
}


@pytest.mark.parametrize("name", VARIANTS)
def test_every_spelling_gives_the_same_numbers(tmp_path: Path, fmu: Path, name: str) -> None:
    """One system, eleven spellings that tools read differently."""
    ssd, files = VARIANTS[name]
    path = archive(tmp_path / "a.ssp", fmu, ssd, {**files, "resources/my block.fmu": fmu.read_bytes()})
    run = simulate(path)
    found = {key.removeprefix("inner."): value for key, value in run.outputs.items()}
    assert found == EXPECTED
    assert not [notice for notice in run.assembly.notices if "connected to nothing" not in notice]


def outputs(tmp_path: Path, fmu: Path, ssd: str, files: Mapping[str, str | bytes] | None = None) -> dict[str, float]:
    """Write a system and return what it puts out in the end."""
    return simulate(archive(tmp_path / "b.ssp", fmu, ssd, files)).outputs


def test_bindings_of_a_higher_level_win_and_later_ones_of_the_same(tmp_path: Path, fmu: Path) -> None:
    """Component, inner system and root bind the same parameter; each also binds one that nobody above does."""
    leaf = component("m", inline({"b": 1.0, "k": 1.0, "n": 1}) + inline({"n": 2}))
    inner = system(leaf, bindings=inline({"m.b": 2.0, "m.k": 5.0}), name="inner")
    root = system(inner, bindings=inline({"inner.m.b": 100.0}) + inline({"b": 4.0}, prefix="inner.m."))
    assert outputs(tmp_path, fmu, description(root)) == {"inner.m.y": 8.0}
    assert simulate(tmp_path / "b.ssp").assembly.parameters["inner.m"] == {"b": 4.0, "k": 5.0, "n": 2}


def test_parameters_of_every_type_arrive(tmp_path: Path, fmu: Path) -> None:
    values = {"b": 2.5, "n": -3, "on": True, "s": "two words"}
    run = simulate(archive(tmp_path / "a.ssp", fmu, description(system(component("m", inline(values))))))
    assert run.outputs == {"m.y": -7.5}
    assert run.assembly.parameters["m"] == values
    off = description(system(component("m", inline({**values, "on": False}))))
    assert outputs(tmp_path, fmu, off) == {"m.y": 0.0}


def test_mappings_convert_before_they_transform(tmp_path: Path, fmu: Path) -> None:
    """Into the unit of the target first: 4 ell are 2 m, times 10 plus 1; suppressed, it is 4 times 10 plus 1."""
    change = '<ssc:LinearTransformation factor="10" offset="1"/>'
    entry = f'<ssm:MappingEntry source="x" target="b"{{}}>{change}</ssm:MappingEntry>'
    for more, expected in (("", 21.0), (' suppressUnitConversion="true"', 41.0)):
        ssm = f'<ssm:ParameterMapping {NAMESPACES} version="1.0">{entry.format(more)}</ssm:ParameterMapping>'
        binding = inline({"x": 4.0}, "ell", f"<ssd:ParameterMapping>{ssm}</ssd:ParameterMapping>")
        ports = connector("b", "parameter", "m")
        ssd = description(system(component("m", binding, connectors=ports)), more=UNITS)
        assert outputs(tmp_path, fmu, ssd) == {"m.y": expected}


def test_mapping_tables_of_numbers_and_truth(tmp_path: Path, fmu: Path) -> None:
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
    assert outputs(tmp_path, fmu, description(system(component("m", binding)))) == {"m.y": 14.0}


def test_units_change_at_every_connector_on_the_way(tmp_path: Path, fmu: Path) -> None:
    """3 m leave m1, pass a connector in mm, are doubled there, and enter m2 in km; suppressed, 3 stays 3."""

    def nested(more: str) -> str:
        inner = system(
            component("m2", units=("km", "")), wire("u", "m2.u"), connector("u", "input", "mm"), name="inner"
        )
        change = '<ssc:LinearTransformation factor="2"/>'
        return description(system(component("m1", ONE, units=("", "m")) + inner, wire("m1.y", "inner.u", change, more)))

    assert outputs(tmp_path, fmu, nested(""))["inner.m2.y"] == pytest.approx(6e-3, rel=1e-15)
    suppressed = nested(' suppressUnitConversion="true"')
    assert outputs(tmp_path, fmu, suppressed)["inner.m2.y"] == pytest.approx(6e-6, rel=1e-15)


def test_values_of_system_connectors_reach_parameters_through_their_connections(tmp_path: Path, fmu: Path) -> None:
    """A parameter connector of an inner system, bound at the root in mm, wired with a factor to a block's b in m."""
    ports = connector("b", "parameter", "m") + connector("y", "output")
    inner = system(
        component("m", inline({"b": 50.0}), connectors=ports),
        wire("length", "m.b", '<ssc:LinearTransformation factor="3"/>') + wire("m.y", "y"),
        connector("length", "parameter", "mm") + connector("y", "output"),
        name="inner",
    )
    root = system(inner, wire("inner.y", "out"), connector("out", "output"), inline({"inner.length": 4.0}, "m"))
    run = simulate(archive(tmp_path / "a.ssp", fmu, description(root)))
    assert run.outputs == pytest.approx({"inner.m.y": 12.0}, rel=1e-15)
    assert [str(link.wire) for link in run.assembly.outputs] == ["inner.m.y -> out"]


def test_ends_of_a_connection_do_not_tell_its_direction(tmp_path: Path, fmu: Path) -> None:
    """SSP takes the direction from the kinds of the connectors."""
    root = system(component("m1", ONE) + component("m2", TWO), wire("m2.u", "m1.y"))
    assert outputs(tmp_path, fmu, description(root)) == EXPECTED


def test_elements_of_arrays_have_their_indices_in_their_names(tmp_path: Path, fmu: Path) -> None:
    """As the variables of FMI 3.0 FMUs are called here, element by element."""
    matrix = connector("y", "output", content='<ssc:Real unit="m"/><ssc:Dimension size="2"/><ssc:Dimension size="3"/>')
    root = system(
        component("m1", connectors=matrix) + component("m2", units=("mm", "")),
        wire("m1.y", "m2.u", more=' startIndices="2 3"'),
    )
    found = read_system(archive(tmp_path / "a.ssp", fmu, description(root, version="2.0")))
    assert [str(link) for link in found.wires] == ["m1.y[2,3] -> m2.u"]
    assert found.elements["m1"].connectors["y"].type == "Real"
    with pytest.raises(InputError, match=r"m1.y\[2,3\] -> m2.u: block.fmu has no variable 'y\[2,3\]'"):
        assemble(found)


def test_signal_dictionary_joins_systems_of_two_levels(tmp_path: Path, fmu: Path) -> None:
    """m1 puts its output on the bus, in mm; a block in a system inside takes it off, in m."""
    signals = '<ssb:DictionaryEntry name="way"><ssc:Real unit="mm"/></ssb:DictionaryEntry>'
    bus = f'<ssb:SignalDictionary {NAMESPACES} version="1.0">{signals}</ssb:SignalDictionary>'

    def reference(unit: str) -> str:
        ports = f"<ssd:Connectors>{connector('way', 'inout', unit)}</ssd:Connectors>"
        return f'<ssd:SignalDictionaryReference name="bus" dictionary="bus">{ports}</ssd:SignalDictionaryReference>'

    inner = system(component("m2", TWO, units=("m", "")) + reference("mm"), wire("bus.way", "m2.u"), name="inner")
    root = system(
        component("m1", inline({"b": 3000.0}), units=("", "mm")) + reference("m") + inner, wire("m1.y", "bus.way")
    )
    for where, files in (
        (f'name="bus">{bus}', {}),
        ('name="bus" source="resources/bus.ssb">', {"resources/bus.ssb": bus}),
    ):
        dictionary = (
            f"<ssd:SignalDictionaries><ssd:SignalDictionary {where}</ssd:SignalDictionary></ssd:SignalDictionaries>"
        )
        whole = description(root.removesuffix("</ssd:System>") + dictionary + "</ssd:System>")
        assert outputs(tmp_path, fmu, whole, files)["inner.m2.y"] == pytest.approx(7.0, rel=1e-15)


def test_systems_in_files_of_their_own(tmp_path: Path, fmu: Path) -> None:
    """An SSD and an SSP take the place of a component; what the component binds wins over what is inside."""
    inner = description(INNER, name="inner").replace("resources/block.fmu", "block.fmu")
    packed = archive(tmp_path / "inner.ssp", fmu, description(INNER, name="inner"))
    ports = connector("u", "input") + connector("y", "output")
    for kind, source in (("definition", "resources/inner.ssd"), ("package", "resources/inner.ssp")):
        part = component("inner", inline({"m2.b": 10.0}), source=source, connectors=ports)
        part = part.replace("x-fmu-sharedlibrary", f"x-ssp-{kind}")
        root = system(component("m1", ONE) + part, wire("m1.y", "inner.u"))
        files: dict[str, str | bytes] = {"resources/inner.ssd": inner, "resources/inner.ssp": packed.read_bytes()}
        assert outputs(tmp_path, fmu, description(root), files) == {"m1.y": 3.0, "inner.m2.y": 16.0}


def test_variants_are_found_by_name_and_by_file(tmp_path: Path, fmu: Path) -> None:
    other = description(system(component("m1", inline({"b": -1.0}))), name="other way")
    path = archive(tmp_path / "a.ssp", fmu, description(FLAT), {"VariantB.ssd": other})
    assert read_system(path).variants == ("blocks", "other way")
    for variant in ("other way", "VariantB.ssd"):
        assert simulate(path, variant=variant).outputs == {"m1.y": -1.0}
    assert read_system(Path(f"{path}#VariantB.ssd")).name == "other way"
    with pytest.raises(InputError, match=r"has no variant 'third'; it has blocks, other way$"):
        read_system(path, "third")


def test_inputs_that_nothing_feeds_keep_their_values(tmp_path: Path, fmu: Path) -> None:
    """A bound start value without a notice, the FMU's own with one; SSP and FMI let both stay for the whole run."""
    root = system(component("m1", inline({"u": 5.0, "m": 2})) + component("m2", inline({"b": 1.0, "m": 2})))
    run = simulate(archive(tmp_path / "a.ssp", fmu, description(root)))
    assert run.outputs == {"m1.y": 5.0, "m2.y": 1.0}
    assert [n.partition(";")[0] for n in run.assembly.notices] == ["input m2.u of block.fmu is connected to nothing"]


def test_shared_parameter_sets_are_passed_over_with_a_notice(tmp_path: Path, fmu: Path) -> None:
    """SSP ignores what matches no variable, so that components can share a set; the user hears of it."""
    root = system(component("m", FROM_FILE), bindings=inline({"axle.b": 1.0}))
    files = {"resources/values.ssv": parameter_set({"b": 2.0, "kk": 1.0})}
    run = simulate(archive(tmp_path / "a.ssp", fmu, description(root), files))
    assert run.outputs == {"m.y": 2.0}
    said = "\n".join(run.assembly.notices)
    assert "SystemStructure.ssd, line 2, Parameter 'axle.b': no component has it, so it is not applied" in said
    assert "values.ssv, line 1, Parameter 'kk': not applied to m: block.fmu has no variable 'kk'; did you mean" in said


def test_settings_of_the_master_are_read(tmp_path: Path, fmu: Path) -> None:
    def annotated(content: str) -> str:
        text = f'<ssc:Annotation type="curvesqueal">{content}</ssc:Annotation>'
        return f'<ssd:Annotations xmlns:cs="urn:curvesqueal:ssp">{text}</ssd:Annotations>'

    def ssd(master: str, stage: str) -> str:
        root = system(component("m1", more=annotated(stage)) + component("m2"), PAIR)
        experiment = '<ssd:DefaultExperiment startTime="0" stopTime="0.01"/>'
        return description(root).replace(experiment, experiment[:-2] + f">{annotated(master)}</ssd:DefaultExperiment>")

    good = ssd('<cs:Master stepSize="2e-5" algorithm="jacobi"/>', '<cs:Component stage="3"/>')
    found = read_system(archive(tmp_path / "a.ssp", fmu, good))
    assert (found.step_size, found.algorithm, found.stages) == (2e-5, "jacobi", {"m1": 3})
    stage = '<cs:Component stage="3"/>'
    for bad, place, message in (
        ('<cs:Master stepSize="-1"/>', stage, "line 2, Master: step size '-1': must be a number > 0"),
        ("<cs:Master/>", '<cs:Component stage="-3"/>', "line 2, Component: stage = '-3': must be a whole number"),
        ("<cs:Master/>", "<cs:Part/>", "line 2, Part: element 'Part' of the annotation is not known"),
        ("<cs:Component/>", stage, "line 2, Component: element 'Component' of the annotation is not known"),
        ("<cs:Master/><cs:Master/>", stage, "line 2: Element"),
    ):
        with pytest.raises(InputError, match=message):
            read_system(archive(tmp_path / "b.ssp", fmu, ssd(bad, place)))


NESTED = system(component("m1") + INNER, wire("m1.y", "inner.v"))
BOTH = component("m1") + component("m2")
LOOP = system("", wire("u", "y"), connector("u", "input") + connector("y", "output"), name="loop")
LIST = ONE.replace('version="1.0"', 'version="2.0"').replace('value="3.0"', 'value="1 2 3"')
CLOCK = component("m1", connectors=connector("y", "output", content="<ssc:Clock/>"))
TWICE = f"<ssd:ParameterMapping>{mapping(('x', 'b', ''), ('y', 'b', ''))}</ssd:ParameterMapping>"
WEB = "https://example.org/a.fmu"

REFUSED = {
    "element of a system's array": (
        system(component("m1") + INNER, wire("m1.y", "inner.u", more=' endIndices="1 2"')),
        "connection m1.y -> inner.u: endIndices at a connector of System 'inner' are not supported",
    ),
    "clock": (
        system(CLOCK + component("m2"), PAIR),
        "connection m1.y -> m2.u: m1.y is of type Clock; not supported",
    ),
    "no number": (
        system(BOTH, wire("m1.y", "m2.u", '<ssc:LinearTransformation factor="NaN"/>')),
        "LinearTransformation: factor = nan: must be a finite number",
    ),
    "table in a connection": (
        system(BOTH, wire("m1.y", "m2.u", table_of("Boolean", {"true": "false"}))),
        "m1.y -> m2.u: a BooleanMappingTransformation of a connection is not supported",
    ),
    "other component": (
        FLAT.replace("x-fmu-sharedlibrary", "x-simulink", 1),
        "Component 'm1': type application/x-simulink is not supported",
    ),
    "no source": (
        FLAT.replace('source="resources/block.fmu" ', "", 1),
        "Component 'm1': has no source, so there is nothing to simulate",
    ),
    "source on the web": (FLAT.replace("resources/block.fmu", WEB, 1), f"source '{WEB}' is not relative"),
    "sourceBase": (
        system(component("m", FROM_FILE.replace("/>", ' sourceBase="component"/>'))),
        "sourceBase 'component' is not supported",
    ),
    "no such set": (
        system(component("m", FROM_FILE)),
        "ParameterBinding 'resources/values.ssv': the file 'resources/values.ssv' is missing",
    ),
    "parameter type": (
        system(component("m", ONE.replace('ssv:Real value="3.0"', 'ssv:Binary value="00"'))),
        "Parameter 'b': type Binary is not supported",
    ),
    "two outputs": (system(BOTH, wire("m1.y", "m2.y")), "both connectors give values: m1.y and m2.y"),
    "fed twice": (system(BOTH, PAIR + PAIR), "connection m1.y -> m2.u: m2.u is fed by two connections"),
    "no such connector": (NESTED, "connection m1.y -> inner.v: System 'inner' has no connector 'v'"),
    "same name": (system(component("m1") + component("m1")), "Component 'm1': two elements are named 'm1'"),
    "circle": (
        system(LOOP + component("m1"), wire("loop.y", "loop.u") + wire("loop.y", "m1.u")),
        "the connections go in a circle",
    ),
    "two to one name": (
        system(component("m", inline({"x": 1.0, "y": 2.0}, mapping=TWICE))),
        "MappingEntry 'y': the target 'b' has a mapping already",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_is_not_supported_is_named(tmp_path: Path, fmu: Path, what: str) -> None:
    root, message = REFUSED[what]
    path = archive(tmp_path / "a.ssp", fmu, description(root, version="2.0"))
    with pytest.raises(InputError, match=re.escape(message)) as caught:
        read_system(path)
    assert "\n" not in str(caught.value)
    assert "a.ssp: SystemStructure.ssd, line " in str(caught.value)


WHOLE = component("m2", connectors=connector("m", "input", content="<ssc:Integer/>"))
MISFITS = {
    "connection m1.y -> m2.m: ": system(component("m1") + WHOLE, wire("m1.y", "m2.m")),
    "connector m1.u: is output in the SSD and input in the FMU": (
        system(component("m1", connectors=connector("u", "output")))
    ),
    "connector m1.n: is Real in the SSD and Integer in the FMU": (
        system(component("m1", connectors=connector("n", "parameter")))
    ),
    "line 2, Parameter 'y'): is no parameter but output": system(component("m1", inline({"y": 1.0}))),
    "line 2, Parameter 'b') = True: must be a number": system(component("m1", inline({"b": True}))),
    "line 2, Parameter 'n') = 1.5: must be a whole number": system(component("m1", inline({"n": 1.5}))),
    "connection m1.y -> m2.u: the units do not match: m cannot become N": (
        system(component("m1", units=("", "m")) + component("m2", units=("N", "")), PAIR)
    ),
}


@pytest.mark.parametrize("message", MISFITS)
def test_what_does_not_fit_the_fmus_is_named(tmp_path: Path, fmu: Path, message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        assemble(read_system(archive(tmp_path / "a.ssp", fmu, description(MISFITS[message]))))


def test_files_follow_their_own_version(tmp_path: Path, fmu: Path) -> None:
    """Float64 is of SSP 2.0: allowed in a set of that version, refused in one that says 1.0."""
    wide = parameter_set({"b": 2.0}, version="2.0").replace("ssv:Real", "ssv:Float64")
    ssd = description(system(component("m", FROM_FILE)))
    assert outputs(tmp_path, fmu, ssd, {"resources/values.ssv": wide}) == {"m.y": 2.0}
    for text, message in (
        (
            wide.replace('version="2.0"', 'version="1.0"'),
            r"values.ssv, line 1: Element '\{.*\}Float64': This element is not",
        ),
        (
            wide.replace('version="2.0"', 'version="3.0"'),
            r"values.ssv, line 1: SSP version '3.0'; 1.0 and 2.0 are read",
        ),
    ):
        with pytest.raises(InputError, match=message):
            outputs(tmp_path, fmu, ssd, {"resources/values.ssv": text})
    inside = system(component("m", ONE.replace("ssv:Real", "ssv:Float64")))
    with pytest.raises(InputError, match=r"SystemStructure.ssd, line 2: Element '\{.*\}Float64': This element is not"):
        read_system(archive(tmp_path / "c.ssp", fmu, description(inside)))


def test_info_shows_nesting_values_and_changes(tmp_path: Path, fmu: Path) -> None:
    """As data for programs, and as a tree and tables for people."""
    change = '<ssc:LinearTransformation factor="-2" offset="1"/>'
    root = system(component("m1", ONE) + INNER, wire("m1.y", "inner.u", change), bindings=inline({"inner.m2.b": 4.0}))
    path = archive(tmp_path / "a.ssp", fmu, description(root), {"b.ssd": description(FLAT, "flat")})
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


def test_enumerations_and_units_of_the_fmu_count(tmp_path: Path, fmu: Path) -> None:
    """A block whose n is of the FMU's own enumeration and whose b is in a unit that only the FMU defines."""
    with zipfile.ZipFile(fmu) as packed:
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
