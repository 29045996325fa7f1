"""Structures that show no modes: their cycles are those of the modes that they hide, or of what was found of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fmus.modal.modes import Modes
from orchestrator import InputError
from orchestrator.limit_cycles.catalogue import find_cycles
from orchestrator.limit_cycles.model import SquealModel
from orchestrator.limit_cycles.parts import Part
from orchestrator.limit_cycles.search import cycles_of
from orchestrator.probing.response import CONTRACT
from orchestrator.runs.scenario import Scenario
from orchestrator.runs.starts import on_cycle
from orchestrator.stability.identified import identify
from orchestrator.stability.linear_model import model_of_assembly
from orchestrator.stability.poles import Identified

STEP = 5e-6


@pytest.mark.parametrize("rounding", [0.0, 1e-12, -1e-12])
def test_real_poles_are_real_whatever_their_rounding(rounding: float) -> None:
    """An overdamped mode in partial fractions: v/F is s1/(s1 - s2)/(s - s1) plus the same with both swapped."""
    omega, zeta, shape = 2 * np.pi * 100.0, 3.0, np.array([0.0, 0.2, 0.1, 0.0])
    root = omega * np.sqrt(zeta**2 - 1)
    poles = np.array([-zeta * omega + root, -zeta * omega - root])
    drive = (poles / (poles - poles[::-1]))[:, None] * shape
    found = Identified(poles * (1 + 1j * rounding), np.stack([shape, shape], axis=1).astype(complex), drive + 0j)
    exact = Part.of(Modes(np.array([omega]), np.array([zeta]), shape[None]))
    s = 2j * np.pi * np.array([0.0, 10.0, 100.0, 1000.0])
    values, wanted = Part.of(found).receptance(s)[0], exact.receptance(s)[0]
    np.testing.assert_allclose(values, wanted, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.slow
def test_a_rail_that_hides_its_modes_makes_the_same_cycle() -> None:
    """Case 1's rail by its response alone: level and exponent agree to the accuracy of the identification."""
    assembly, _ = Scenario("case1", step=STEP).prepare()
    modal = model_of_assembly(assembly, STEP)
    hidden = identify(assembly.fmus["rail"], assembly.parameters["rail"], STEP, CONTRACT)
    shown, found = (
        find_cycles(SquealModel(modal.wheel, rail, modal.law), tone_hz=1100.0).near(1100.0)
        for rail in (modal.rail, hidden)
    )
    assert found.frequency_hz == pytest.approx(shown.frequency_hz, rel=1e-7)
    for d in ("lat", "ver"):
        assert found.wheel_velocity_rms[d] == pytest.approx(shown.wheel_velocity_rms[d], rel=1e-5)
        assert found.rail_velocity_rms[d] == pytest.approx(shown.rail_velocity_rms[d], rel=1e-5)
    assert found.stability is not None
    assert shown.stability is not None
    assert found.stability.largest == pytest.approx(shown.stability.largest, abs=1e-3)


@pytest.mark.slow
def test_a_foreign_rail_has_cycles_and_cannot_start_on_one(tmp_path: Path, built: Path) -> None:
    """`examples/own_rail`: kN, mm/s, own axes, no modes. Its cycles need its response only, a start needs its state."""
    from pythonfmu.builder import FmuBuilder  # noqa: PLC0415 - only here

    own = Path(__file__).parents[3] / "examples" / "own_rail"
    FmuBuilder.build_FMU(own / "own_rail.py", dest=tmp_path, needsExecutionTool=False)
    (tmp_path / "own_rail.ssd").write_text((own / "own_rail.ssd").read_text())
    for name in ("wheel", "contact"):
        (tmp_path / f"{name}.fmu").write_bytes((built / f"{name}.fmu").read_bytes())
    scenario = Scenario(str(tmp_path / "own_rail.ssd"), step=STEP)
    assembly, settings = scenario.prepare()
    model = model_of_assembly(assembly, settings.step)
    assert model.identified == ("rail",)
    tone = float(
        model.poles.unstable().below(6e3).frequency_hz[np.argmax(model.poles.unstable().below(6e3).growth_rate)]
    )
    cycle = cycles_of(assembly, settings.step, tone_hz=tone).near(tone)
    assert cycle.residual < 1e-6
    assert cycle.stability is not None
    assert cycle.rail_velocity_rms["lat"] > 0
    with pytest.raises(InputError, match="rail: has no initial_velocity and initial_displacement of its modes"):
        on_cycle(scenario, tone)
