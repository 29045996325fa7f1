"""The contact's steady state moved by inputs: by a value, by another FMU, in linear models."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest
from foreign_fmus import Y, foreign_fmu
from table_fmus import COMPILER

from orchestrator.coupling.assembly import Assembly, assemble
from orchestrator.coupling.master import Master, Settings
from orchestrator.errors import InputError
from orchestrator.stability.linear_model import model_of_assembly
from orchestrator.system.reader import read_system

H = 5e-6


def case1(ssp: Path, **contact: float) -> Assembly:
    return assemble(read_system(ssp).with_parameters({"contact": {n: str(v) for n, v in contact.items()}}))


def last(assembly: Assembly, steps: int = 400) -> dict[str, float]:
    """Return the outputs after some steps."""
    with Master(assembly, Settings(H, steps * H)) as master:
        master.run()
        return {".".join(name): value for name, value in zip(master.outputs, master.plan.y.tolist(), strict=True)}


def test_a_value_of_the_input_is_added_to_the_parameter(native: Path) -> None:
    ssp = native / "curvesqueal.ssp"
    moved = case1(ssp, mu0_change=0.05, steady_creepage_lat_change=-0.005)
    whole = case1(ssp, mu0=0.35, steady_creepage_lat=0.015)
    assert not [notice for notice in case1(ssp).notices if "_change" in notice]
    a, b = last(moved), last(whole)
    names = [n for n in a if n != "contact.force_evaluations"]
    np.testing.assert_allclose([a[n] for n in names], [b[n] for n in names], rtol=1e-6, atol=1e-12)
    poles = [model_of_assembly(assembly, H).poles.growth_rate for assembly in (moved, whole)]
    np.testing.assert_allclose(poles[0], poles[1], rtol=1e-6, atol=1e-6)


def test_linear_models_refuse_a_moved_friction_table(native: Path) -> None:
    table = {"friction_law": 3, "friction_points": 2, "friction_abscissa_002": 0.05}
    table |= {"friction_ordinate_001": 0.4, "friction_ordinate_002": 0.2}
    with pytest.raises(InputError, match="moves a friction table; change the table instead, so its linear behaviour"):
        model_of_assembly(case1(native / "curvesqueal.ssp", mu0_change=0.1, **table), H)


@pytest.mark.skipif(COMPILER is None, reason="no C compiler for the test FMU")
def test_another_fmu_moves_the_friction_while_the_contact_runs(native: Path, tmp_path: Path) -> None:
    """A ramp of mu0 from 0.3 to 0.34; at rest the total force follows and nothing moves."""
    with zipfile.ZipFile(native / "curvesqueal.ssp") as archive:
        archive.extractall(tmp_path)
    foreign_fmu(tmp_path / "resources" / "ramp.fmu", Y, step="m->r[1]=1e-4*m->n", depends="")
    ssd = tmp_path / "SystemStructure.ssd"
    drive = '<ssd:Component name="drive" source="resources/ramp.fmu" type="application/x-fmu-sharedlibrary"/>'
    wire = '<ssd:Connection startElement="drive" startConnector="y" endElement="contact" endConnector="mu0_change"/>'
    text = ssd.read_text().replace("</ssd:Elements>", f"{drive}</ssd:Elements>")
    ssd.write_text(text.replace("</ssd:Connections>", f"{wire}</ssd:Connections>"))
    system = read_system(ssd).with_parameters({"contact": {"pulse_force": "0"}})
    found, rest = last(assemble(system)), last(case1(native / "curvesqueal.ssp", pulse_force=0.0), 1)
    total = "contact.tangential_force_lat"
    assert found[total] == pytest.approx(rest[total] * 0.34 / 0.3, rel=1e-6)
    assert abs(found["wheel.v_lat"]) < 1e-9
    with pytest.raises(InputError, match="more than a wheel on a rail"):
        model_of_assembly(assemble(system), H)
