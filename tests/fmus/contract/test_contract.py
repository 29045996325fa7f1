"""One contract: what is generated from it, and that the components, the SSP and the kept files agree with it."""

from __future__ import annotations

from pathlib import Path

import fmpy.ssp
import pytest
from lxml import etree

from fmus.cases import SSP_FOLDER, read_cases
from fmus.component import Component, Variable
from fmus.interface import (
    CHANGE,
    UNITS,
    connections,
    contact_inputs,
    contact_outputs,
    operating_point_inputs,
    structure_inputs,
    structure_outputs,
)
from fmus.packaging.catalogue import components
from fmus.packaging.ssp.structure import ssp_files

SCHEMAS = Path(fmpy.ssp.__file__).parent / "schema"
ALL = components()


def ports(component: Component, causality: str) -> list[tuple[str, str]]:
    return [(v.name, v.unit) for v in component.of(causality)]


@pytest.mark.parametrize("name", [n for n in ALL if not n.startswith(("curvesqueal", "vehicle"))])
def test_components_have_the_ports_of_the_contract(name: str) -> None:
    contact = name.startswith("contact")
    inputs, outputs = (structure_inputs(), structure_outputs())
    if contact:
        inputs, outputs = (*contact_inputs(), *operating_point_inputs()), contact_outputs()
    assert ports(ALL[name], "input") == [(p.name, p.unit) for p in inputs]
    assert ports(ALL[name], "output") == [(p.name, p.unit) for p in outputs]


def test_connections_join_outputs_to_inputs_of_the_same_unit_and_feed_every_input_once() -> None:
    parts = {"wheel": ALL["wheel"], "rail": ALL["rail"], "contact": ALL["contact"]}
    fed = []
    for c in connections():
        outputs, inputs = dict(ports(parts[c.start_element], "output")), dict(ports(parts[c.end_element], "input"))
        assert outputs[c.start_connector] == inputs[c.end_connector]
        fed.append((c.end_element, c.end_connector))
    taken = [(name, v) for name, part in parts.items() for v, _ in ports(part, "input")]
    assert sorted(fed) == sorted(end for end in taken if not end[1].endswith(CHANGE))


@pytest.mark.parametrize("name", ALL)
def test_every_unit_is_defined(name: str) -> None:
    assert {v.unit for v in ALL[name].variables} <= UNITS.keys()


@pytest.mark.parametrize("name", ALL)
def test_declaration_survives_its_json(name: str) -> None:
    assert Component.from_json(ALL[name].to_json()) == ALL[name]


def test_kept_system_structure_is_what_the_contract_generates() -> None:
    """The files in ssp/ are written by 'make ssp'; this fails when they are out of date."""
    generated = ssp_files(ALL, read_cases())
    kept = {
        path.relative_to(SSP_FOLDER).as_posix(): path.read_bytes()
        for pattern in ("*.ssd", "resources/*.ssv")
        for path in SSP_FOLDER.glob(pattern)
    }
    assert kept == generated


@pytest.mark.parametrize(
    ("pattern", "schema"),
    [("*.ssd", "SystemStructureDescription"), ("resources/*.ssv", "SystemStructureParameterValues")],
)
def test_system_structure_is_valid_against_the_ssp_schema(pattern: str, schema: str) -> None:
    checker = etree.XMLSchema(etree.parse(SCHEMAS / f"{schema}.xsd"))
    files = sorted(SSP_FOLDER.glob(pattern))
    assert len(files) >= 4
    for file in files:
        checker.assertValid(etree.parse(file))


def test_each_case_has_its_own_name() -> None:
    names = [etree.parse(file).getroot().get("name") for file in sorted(SSP_FOLDER.glob("*.ssd"))]
    assert sorted(names) == [f"{family}{number}" for family in ("case", "inferred") for number in (1, 2, 3, 4)]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"causality": "independent"}, "causality is 'independent'; must be one of"),
        ({"start": 2.0, "maximum": 1.0}, "x = 2: must be"),
    ],
)
def test_bad_declarations_are_refused(change: dict[str, object], message: str) -> None:
    good = {"name": "x", "causality": "parameter", "unit": "1", "description": ""}
    with pytest.raises(ValueError, match=message):
        Variable(**{**good, **change})  # type: ignore[arg-type]
