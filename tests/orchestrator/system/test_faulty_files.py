"""Files with faults: those that change no number are told and passed over, or refused strictly; others are errors."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import pytest
from block_systems import (
    archive,
    component,
    connector,
    description,
    inline,
    parameter_set,
    system,
    wire,
)
from fmi3_fmu import needs_compiler, write_ssd
from foreign_fmus import U, Y, foreign_fmu, variable

from orchestrator.errors import Fault, InputError
from orchestrator.fmi.file import open_fmu
from orchestrator.runs.scenario import Scenario
from orchestrator.system.reader import read_system

OURS = (
    "<ssd:Annotations>"
    '<ssc:Annotation type="curvesqueal"><cs:Component xmlns:cs="urn:curvesqueal:ssp" {}/></ssc:Annotation>'
    "</ssd:Annotations>"
)
TWO = component("m1") + component("m2")
PAIR = wire("m1.y", "m2.u")


def twice(first: str, second: str) -> str:
    """Return a binding whose parameter set has `b` twice."""
    one = parameter_set({"b": 1.0})
    rows = "".join(f'<ssv:Parameter name="b"><ssv:Real value="{v}"/></ssv:Parameter>' for v in (first, second))
    changed = one[: one.index("<ssv:Parameter name")] + rows + one[one.index("</ssv:Parameters>") :]
    return inline({"b": 1.0}).replace(one, changed)


FAULTY = {
    "annotation": (
        system(component("m1", more=OURS.format('stage="0" colour="red"')) + component("m2"), PAIR),
        "line 2, Component: attribute 'colour' of the annotation is not known; passed over",
    ),
    "model exchange": (
        system(TWO, PAIR).replace('source="resources', 'implementation="ModelExchange" source="resources', 1),
        "Component 'm1': wants ModelExchange; it is run as co-simulation",
    ),
    "empty element": (
        system(TWO, PAIR + wire("in", "m1.u").replace("<ssd:Connection ", '<ssd:Connection startElement="" '),
               connector("in", "input")),
        "connection in -> m1.u: startElement is empty; read as the system itself",
    ),
    "same value twice": (
        system(component("m1", twice("2.5", "2.50")) + component("m2"), PAIR),
        "Parameter 'b': the parameter set has it twice, with the same value",
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", FAULTY)
def test_faults_of_a_description_are_told(tmp_path: Path, block: Path, what: str) -> None:
    """File, line and element; the same is an error where everything is read strictly."""
    root, message = FAULTY[what]
    path = archive(tmp_path / "a.ssp", block, description(root))
    told = [notice for notice in read_system(path).notices if isinstance(notice, Fault)]
    assert len(told) == 1
    assert message in told[0]
    assert "a.ssp: SystemStructure.ssd, line " in told[0]
    Scenario(str(path), step=1e-3).prepare()
    with pytest.raises(InputError, match="refused, as everything is read strictly"):
        Scenario(str(path), step=1e-3, strict=True).prepare()


def test_values_that_differ_are_an_error(tmp_path: Path, block: Path) -> None:
    path = archive(tmp_path / "a.ssp", block, description(system(component("m1", twice("2.5", "2.6")))))
    with pytest.raises(
        InputError, match=r"line 2, Parameter 'b': the parameter set has two of this name, and they differ"
    ):
        read_system(path)


def test_a_broken_other_variant_is_passed_over(tmp_path: Path, block: Path) -> None:
    path = archive(tmp_path / "a.ssp", block, description(system(TWO, PAIR)), {"Draft.ssd": "<a:b/>"})
    (told,) = read_system(path).notices
    assert isinstance(told, Fault)
    assert "Draft.ssd is not well-formed XML" in told
    with pytest.raises(InputError, match=r"Draft\.ssd is not well-formed XML"):
        read_system(path, "Draft.ssd")


def test_an_entry_for_the_folder_itself_is_told(tmp_path: Path, block: Path) -> None:
    path = archive(tmp_path / "a.ssp", block, description(system(TWO, PAIR)), {"./": ""})
    assert read_system(path).notices == (f"{path}: entry './' is the folder itself",)
    file = tmp_path / "b.fmu"
    shutil.copy(block, file)
    with zipfile.ZipFile(file, "a") as packed:
        packed.writestr("./", "")
    assert open_fmu(file).faults == (f"{file}: entry './' is the folder itself",)


FMU_FAULTS = {
    "unit": (Y.replace("<Real", '<Real unit="furlong"'), "variable 'y': the unit 'furlong' is not defined"),
    "display unit": (Y.replace("<Real", '<Real displayUnit="mm"'), "variable 'y': has a display unit and no unit"),
    "start": (Y + variable("p", 2, "parameter"), 'Variable "p" (line 1) has no start value'),
    "variability": (
        Y + variable("n", 3, "output", "Integer").replace(' variability="discrete"', ""),
        "variable 'n': is of type Integer and has no variability; read as discrete",
    ),
    "parameter's variability": (
        Y + variable("n", 3, "parameter", "Integer", 1).replace('"tunable"', '"continuous"'),
        "variable 'n': is of type Integer and has continuous variability; read as fixed",
    ),
    "combination": (
        Y + variable("z", 4, "local").replace('"local"', '"local" initial="exact"').replace('"continuous"', '"fixed"'),
        'The combination causality="local" and variability="fixed"',
    ),
}


@needs_compiler
@pytest.mark.parametrize("what", FMU_FAULTS)
def test_faults_of_an_fmu_are_told(tmp_path: Path, what: str) -> None:
    variables, message = FMU_FAULTS[what]
    fmu = open_fmu(foreign_fmu(tmp_path / "x.fmu", variables, step="m->r[1]=1"))
    assert any(message in fault for fault in fmu.faults), fmu.faults
    assert all("x.fmu: modelDescription.xml" in fault for fault in fmu.faults)


@needs_compiler
@pytest.mark.parametrize(
    ("variables", "message"),
    [
        (Y + Y, r'The variable name "y" \(line 1\) is not unique'),
        (Y.replace("<Real/>", '<Real start="one"/>'), r"line 1: Element 'Real', attribute 'start'"),
        (U.replace('valueReference="0"', ""), r"line 1: Element 'ScalarVariable'.*'valueReference' is required"),
    ],
)
def test_faults_that_change_a_number_are_errors(tmp_path: Path, variables: str, message: str) -> None:
    with pytest.raises(InputError, match=rf"x\.fmu: modelDescription\.xml is not valid: {message}"):
        open_fmu(foreign_fmu(tmp_path / "x.fmu", variables))


@needs_compiler
def test_a_parameter_without_a_start_keeps_that_of_the_fmu(tmp_path: Path) -> None:
    """The step puts out the parameter, which the FMU itself has at 7; wildcards set it."""
    from orchestrator.coupling.master import Master  # noqa: PLC0415

    fmu = foreign_fmu(tmp_path / "x.fmu", Y + variable("p", 2, "parameter"), create="m->r[2]=7", step="m->r[1]=m->r[2]")
    ssd = write_ssd(tmp_path / "s.ssd", {"c": fmu, "d": fmu}, [], stop=1.0)
    for values, expected in (({}, 7.0), ({"?": {"*": "2.5"}}, 2.5), ({"*": {"p": "2.5"}, "d": {"p": "3"}}, 2.5)):
        with Master(*Scenario(str(ssd), step=0.5, values=values).prepare()) as master:
            master.run()
            assert master.plan.y[0] == expected
    with pytest.raises(InputError, match=r"c\.q\*: stands for nothing that can be set"):
        Scenario(str(ssd), step=0.5, values={"c": {"q*": 1.0}}).prepare()
