"""Rails of other people in place of the rail: what `check` says, `run` says before its first step."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_fmus import foreign_fmu, variable
from plain_rails import KILO, plain_rail
from table_fmus import COMPILER

from fmus.interface import DIRECTIONS
from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.contact_mobility import contact_mobility
from orchestrator.coupling.settings import Settings
from orchestrator.errors import InputError
from orchestrator.probing.rail_check import check_rail
from orchestrator.runs.trial import try_replaced
from orchestrator.system.reader import read_system

STEP = 2e-5
"""Four times the usual step: these rails have no fast modes."""


def tried(native: Path, rail: Path) -> tuple[str, ...]:
    """Put a rail into Case 1 and try it; return the notices."""
    assembly = assemble(read_system(native / "curvesqueal.ssp").with_sources({"rail": rail}))
    try_replaced(assembly, Settings(STEP, 0.01))
    return assembly.notices


def test_a_rail_with_two_directions_is_one_and_rigid_in_the_others(native: Path, tmp_path: Path) -> None:
    """The unfed input keeps its start value; nothing is said of parameters that the first rail had."""
    rail = plain_rail(tmp_path, "TwoWayRail")
    report = check_rail(rail, step=STEP)
    assert [c.name for c in report.failed] == []
    assert "rigid in lon, spin; extra at the start value" in next(c.detail for c in report.checks if c.name == "names")
    notices = tried(native, rail)
    assert "rail (TwoWayRail.fmu) has nothing in lon, spin: it is rigid there" in notices
    assert not any("step_size" in notice or "contact.rail_v_" in notice for notice in notices)


def test_a_rail_in_kilonewtons_and_millimetres_is_the_same_rail(native: Path, tmp_path: Path) -> None:
    """Units are those that the FMU declares, not those of the rail that stood there: the same mobility to rounding."""
    found = []
    for rail in (plain_rail(tmp_path, "SiRail"), plain_rail(tmp_path, "KiloRail", **KILO)):
        assembly = assemble(read_system(native / "curvesqueal.ssp").with_sources({"rail": rail}))
        try_replaced(assembly, Settings(STEP, 0.01))
        found.append(contact_mobility(assembly, STEP))
    assert found[1] == pytest.approx(found[0], rel=1e-9, abs=1e-18)
    assert check_rail(tmp_path / "KiloRail.fmu", step=STEP).failed == ()


FAULTS = {
    "LateRail": ({"late": "True"}, "late by a step"),
    "TurnedRail": ({"sign": "-1.0"}, "wrong sign: a lat force moves it the other way"),
    "HugeRail": ({"newton": "1e3", "metre": "1e-3"}, "wrong units: a lat force of 1 N moves it by"),
    "MilliRail": ({"metre": "1e-3"}, "wrong units: a lat force of 1 N moves it by"),
    "RestlessRail": ({"push": "1.0"}, "without force v_"),
    "StretchedRail": ({"push": "1e6 * self.state[axis][1] ** 2"}, "not linear: ten times the force"),
    "BackwardRail": ({"way": "-1.0"}, "u_lat is 2 off the integral of v_lat"),
    "ActiveRail": ({"damping": "-200.0"}, "active: after a pulse the lat velocity grows by"),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_rail_with_a_fault_is_refused_by_check_and_by_run_in_the_same_words(
    native: Path, tmp_path: Path, name: str
) -> None:
    changes, said = FAULTS[name]
    rail = plain_rail(tmp_path, name, **changes)
    with pytest.raises(InputError, match=rf"rail \({name}.fmu\): {said}"):
        tried(native, rail)
    assert any(c.detail.startswith(said) for c in check_rail(rail, step=STEP).failed)


def test_names_in_other_capitals_are_offered(native: Path, tmp_path: Path) -> None:
    rail = plain_rail(tmp_path, "LoudRail", f="F_", v="V_")
    detail = next(c.detail for c in check_rail(rail, step=STEP).checks if c.name == "names")
    assert "names differ in capitals only: map f_lat=F_lat, f_ver=F_ver, v_lat=V_lat, v_ver=V_ver" in detail
    with pytest.raises(InputError, match=r"did you mean '[FV]_(lat|ver)'"):
        tried(native, rail)


def test_velocities_in_and_forces_out_are_refused(native: Path) -> None:
    """The contact itself has this causality."""
    texts = [f"{k}_{d}={'wheel'}_{k}_{d}" for k in "fv" for d in ("lon", "lat", "ver", "spin")]
    texts += [f"u_{d}=wheel_u_{d}" for d in ("lat", "ver")]
    report = check_rail(native / "contact.fmu", texts)
    causality = next(c for c in report.checks if c.name == "causality")
    assert causality.detail == "it takes velocities and gives forces; a rail must take forces and give velocities"


@pytest.mark.skipif(COMPILER is None, reason="no C compiler for the rail")
def test_a_run_refuses_an_impedance_in_one_sentence(native: Path, tmp_path: Path) -> None:
    """The contract's names with the causality turned round."""
    turned = "".join(
        variable(f"{kind}_{d}", 8 * (kind == "v") + k, causality, start=0 if causality == "input" else None)
        for kind, causality in (("v", "input"), ("f", "output"))
        for k, d in enumerate(DIRECTIONS)
    )
    rail = foreign_fmu(tmp_path / "impedance.fmu", turned, depends="")
    said = r"rail\.f_lon: is input in the SSD and output in the FMU; a structure must take forces and give velocities"
    with pytest.raises(InputError, match=said):
        tried(native, rail)
    causality = next(c for c in check_rail(rail).checks if c.name == "causality")
    assert causality.detail == "it takes velocities and gives forces; a rail must take forces and give velocities"
