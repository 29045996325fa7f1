"""Systems as other tools write them, each a real SSP of real FMUs run by the master: the numbers are closed forms."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest
from block_systems import (
    FLAT,
    FROM_FILE,
    INNER,
    NAMESPACES,
    ONE,
    PAIR,
    TWO,
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

from orchestrator.coupling.assembly import assemble
from orchestrator.errors import InputError
from orchestrator.system.reader import read_system

EXPECTED = {"m1.y": 3.0, "m2.y": 7.0}
"""Outputs of two blocks in a row: m1 gives b = 3, m2 gives 2 u + 1."""

MAPPED = mapping(("slope", "k", '<ssc:LinearTransformation factor="0.5" offset="-3"/>'), ("height", "b", ""))

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
def test_every_spelling_gives_the_same_numbers(tmp_path: Path, block: Path, name: str) -> None:
    """One system, eleven spellings that tools read differently."""
    ssd, files = VARIANTS[name]
    path = archive(tmp_path / "a.ssp", block, ssd, {**files, "resources/my block.fmu": block.read_bytes()})
    run = simulate(path)
    found = {key.removeprefix("inner."): value for key, value in run.outputs.items()}
    assert found == EXPECTED
    assert not [notice for notice in run.assembly.notices if "connected to nothing" not in notice]


def test_ends_of_a_connection_do_not_tell_its_direction(tmp_path: Path, block: Path) -> None:
    """SSP takes the direction from the kinds of the connectors."""
    root = system(component("m1", ONE) + component("m2", TWO), wire("m2.u", "m1.y"))
    assert outputs(tmp_path, block, description(root)) == EXPECTED


def test_elements_of_arrays_have_their_indices_in_their_names(tmp_path: Path, block: Path) -> None:
    """As the variables of FMI 3.0 FMUs are called here, element by element."""
    matrix = connector("y", "output", content='<ssc:Real unit="m"/><ssc:Dimension size="2"/><ssc:Dimension size="3"/>')
    root = system(
        component("m1", connectors=matrix) + component("m2", units=("mm", "")),
        wire("m1.y", "m2.u", more=' startIndices="2 3"'),
    )
    found = read_system(archive(tmp_path / "a.ssp", block, description(root, version="2.0")))
    assert [str(link) for link in found.wires] == ["m1.y[2,3] -> m2.u"]
    assert found.elements["m1"].connectors["y"].type == "Real"
    with pytest.raises(InputError, match=r"m1.y\[2,3\] -> m2.u: block.fmu has no variable 'y\[2,3\]'"):
        assemble(found)


def test_signal_dictionary_joins_systems_of_two_levels(tmp_path: Path, block: Path) -> None:
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
        assert outputs(tmp_path, block, whole, files)["inner.m2.y"] == pytest.approx(7.0, rel=1e-15)


def test_systems_in_files_of_their_own(tmp_path: Path, block: Path) -> None:
    """An SSD and an SSP take the place of a component; what the component binds wins over what is inside."""
    inner = description(INNER, name="inner").replace("resources/block.fmu", "block.fmu")
    packed = archive(tmp_path / "inner.ssp", block, description(INNER, name="inner"))
    ports = connector("u", "input") + connector("y", "output")
    for kind, source in (("definition", "resources/inner.ssd"), ("package", "resources/inner.ssp")):
        part = component("inner", inline({"m2.b": 10.0}), source=source, connectors=ports)
        part = part.replace("x-fmu-sharedlibrary", f"x-ssp-{kind}")
        root = system(component("m1", ONE) + part, wire("m1.y", "inner.u"))
        files: dict[str, str | bytes] = {"resources/inner.ssd": inner, "resources/inner.ssp": packed.read_bytes()}
        assert outputs(tmp_path, block, description(root), files) == {"m1.y": 3.0, "inner.m2.y": 16.0}


def test_variants_are_found_by_name_and_by_file(tmp_path: Path, block: Path) -> None:
    other = description(system(component("m1", inline({"b": -1.0}))), name="other way")
    path = archive(tmp_path / "a.ssp", block, description(FLAT), {"VariantB.ssd": other})
    assert read_system(path).variants == ("blocks", "other way")
    for variant in ("other way", "VariantB.ssd"):
        assert simulate(path, variant=variant).outputs == {"m1.y": -1.0}
    assert read_system(Path(f"{path}#VariantB.ssd")).name == "other way"
    with pytest.raises(InputError, match=r"has no variant 'third'; it has blocks, other way$"):
        read_system(path, "third")


def test_inputs_that_nothing_feeds_keep_their_values(tmp_path: Path, block: Path) -> None:
    """A bound start value without a notice, the FMU's own with one; SSP and FMI let both stay for the whole run."""
    root = system(component("m1", inline({"u": 5.0, "m": 2})) + component("m2", inline({"b": 1.0, "m": 2})))
    run = simulate(archive(tmp_path / "a.ssp", block, description(root)))
    assert run.outputs == {"m1.y": 5.0, "m2.y": 1.0}
    assert [n.partition(";")[0] for n in run.assembly.notices] == ["input m2.u of block.fmu is connected to nothing"]


def test_settings_of_the_master_are_read(tmp_path: Path, block: Path) -> None:
    def annotated(content: str) -> str:
        text = f'<ssc:Annotation type="curvesqueal">{content}</ssc:Annotation>'
        return f'<ssd:Annotations xmlns:cs="urn:curvesqueal:ssp">{text}</ssd:Annotations>'

    def ssd(master: str, stage: str) -> str:
        root = system(component("m1", more=annotated(stage)) + component("m2"), PAIR)
        experiment = '<ssd:DefaultExperiment startTime="0" stopTime="0.01"/>'
        return description(root).replace(experiment, experiment[:-2] + f">{annotated(master)}</ssd:DefaultExperiment>")

    good = ssd('<cs:Master stepSize="2e-5" algorithm="jacobi"/>', '<cs:Component stage="3"/>')
    found = read_system(archive(tmp_path / "a.ssp", block, good))
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
            read_system(archive(tmp_path / "b.ssp", block, ssd(bad, place)))


def test_files_follow_their_own_version(tmp_path: Path, block: Path) -> None:
    """Float64 is of SSP 2.0: allowed in a set of that version, refused in one that says 1.0."""
    wide = parameter_set({"b": 2.0}, version="2.0").replace("ssv:Real", "ssv:Float64")
    ssd = description(system(component("m", FROM_FILE)))
    assert outputs(tmp_path, block, ssd, {"resources/values.ssv": wide}) == {"m.y": 2.0}
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
            outputs(tmp_path, block, ssd, {"resources/values.ssv": text})
    inside = system(component("m", ONE.replace("ssv:Real", "ssv:Float64")))
    with pytest.raises(InputError, match=r"SystemStructure.ssd, line 2: Element '\{.*\}Float64': This element is not"):
        read_system(archive(tmp_path / "c.ssp", block, description(inside)))
