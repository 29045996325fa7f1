"""What the model descriptions and the SSP say: references, scalars, labels, start values of the cases."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import fmpy
import fmpy.validation
import pytest
from slaves import NAMES, Slave3

from fmus.cases import read_cases
from fmus.packaging.build import build_fmus
from fmus.packaging.catalogue import components
from fmus.packaging.description.fmi3 import model_description3
from fmus.packaging.target import Target

SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"
SSD = "{http://ssp-standard.org/SSP1/SystemStructureDescription}"


@pytest.mark.parametrize("only_scalars", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_fmi3_references_are_the_positions_of_the_variables(name: str, only_scalars: bool) -> None:
    """Who reads `dependencies` as positions and who reads them as value references find the same variables."""
    root = model_description3(components()[name], "0", "0", only_scalars)
    variables = root.find("ModelVariables")
    assert variables is not None
    assert [int(v.attrib["valueReference"]) for v in variables] == list(range(1, len(variables) + 1))
    if only_scalars:
        assert not list(variables.iter("Dimension"))
        assert len(variables) == len(components()[name].variables) + 1


def test_fmi3_with_scalars_only_runs_and_is_valid(tmp_path: Path) -> None:
    component = components()["rail"]
    file = build_fmus({"rail": component}, tmp_path, Target("native", 3, (), True))["rail"]
    assert fmpy.validation.validate_fmu(str(file)) == []
    slave = Slave3(file)
    assert slave.variables["frequency_001"].dimensions == []
    slave.set("initial_velocity_002", [1e-3])
    slave.start()
    assert slave.get("v_lon")[0] == pytest.approx(1e-3 * slave.get("shape_lon_002")[0])
    assert slave.get("modal_velocity_002")[0] == 1e-3
    slave.close()


def test_scalars_only_belong_to_fmi3() -> None:
    with pytest.raises(ValueError, match="FMI 2 has no arrays, all is scalars; must be FMI 3 for scalars only"):
        Target("native", 2, (), True)


def test_fmi2_has_no_terminals_and_fmi3_has_them(native: Path, native3: Path) -> None:
    """FMI Library compares their fmiVersion with the model description's and calls a difference fatal."""
    found = []
    for folder in (native, native3):
        with zipfile.ZipFile(folder / "contact.fmu") as archive:
            found.append("terminalsAndIcons/terminalsAndIcons.xml" in archive.namelist())
            assert "model.png" in archive.namelist()
    assert found == [False, True]


def test_descriptions_of_modal_parameters_have_the_labels_of_the_modes() -> None:
    described = {v.name: v.description for v in components()["wheel"].variables}
    assert described["damping_ratio_002"] == "damping ratio of mode 2, (0,0) cosine"
    assert described["modal_velocity_002"] == "modal velocity of mode 2, (0,0) cosine"


def test_every_contact_in_the_ssp_starts_with_the_values_of_its_case(native: Path, tmp_path: Path) -> None:
    """A host that ignores parameter sets runs the same case."""
    with zipfile.ZipFile(native / "curvesqueal.ssp") as archive:
        archive.extractall(tmp_path)
    for number, case in enumerate(read_cases()):
        root = ElementTree.parse(tmp_path / ("SystemStructure.ssd" if number == 0 else f"{case.name}.ssd")).getroot()
        for part in root.iter(f"{SSD}Component"):
            description = fmpy.read_model_description(str(tmp_path / part.attrib["source"]))
            starts = {v.name: v.start for v in description.modelVariables}
            binding = next(part.iter(f"{SSD}ParameterBinding")).attrib["source"]
            for parameter in ElementTree.parse(tmp_path / binding).getroot().iter(f"{SSV}Parameter"):
                assert float(starts[parameter.attrib["name"]]) == float(parameter[0].attrib["value"])


def test_other_start_values_are_checked() -> None:
    contact = components()["contact"]
    with pytest.raises(ValueError, match="contact has no parameter 'mu'"):
        contact.with_starts({"mu": 0.3})
    with pytest.raises(ValueError, match="mu0 = 3: must be in the range 0 to 2"):
        contact.with_starts({"mu0": 3.0})
