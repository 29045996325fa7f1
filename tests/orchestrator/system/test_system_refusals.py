"""Systems that are refused: what is not supported, or does not fit its FMUs, is named."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

import pytest
from block_systems import (
    FLAT,
    FROM_FILE,
    INNER,
    ONE,
    PAIR,
    archive,
    component,
    connector,
    description,
    inline,
    mapping,
    system,
    wire,
)

from orchestrator.coupling.assembly import assemble
from orchestrator.errors import InputError
from orchestrator.system.reader import read_system


def table_of(kind: str, entries: Mapping[str, str]) -> str:
    """Return a mapping transformation."""
    rows = "".join(f'<ssc:MapEntry source="{s}" target="{t}"/>' for s, t in entries.items())
    return f"<ssc:{kind}MappingTransformation>{rows}</ssc:{kind}MappingTransformation>"


NESTED = system(component("m1") + INNER, wire("m1.y", "inner.v"))

BOTH = component("m1") + component("m2")

LOOP = system("", wire("u", "y"), connector("u", "input") + connector("y", "output"), name="loop")

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
        system(BOTH, wire("m1.y", "m2.u", table_of("Boolean", {"true": "false", "1": "1"}))),
        "m1.y -> m2.u: the BooleanMappingTransformation has two entries for '1', and they differ",
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
def test_what_is_not_supported_is_named(tmp_path: Path, block: Path, what: str) -> None:
    root, message = REFUSED[what]
    path = archive(tmp_path / "a.ssp", block, description(root, version="2.0"))
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
def test_what_does_not_fit_the_fmus_is_named(tmp_path: Path, block: Path, message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        assemble(read_system(archive(tmp_path / "a.ssp", block, description(MISFITS[message]))))
