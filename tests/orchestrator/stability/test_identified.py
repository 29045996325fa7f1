"""Structures that show no modes: what their response tells against the modes that it comes from."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.coupling.assembly import Assembly
from orchestrator.coupling.settings import Settings
from orchestrator.probing.response import CONTRACT
from orchestrator.runs.scenario import Scenario
from orchestrator.stability.identified import identify
from orchestrator.stability.linear_model import LinearModel, model_of_assembly
from orchestrator.stability.poles import Poles
from orchestrator.stability.scheme import growth_of_scheme, spurious_growth
from orchestrator.stability.step_map import compare_growth, discrete_poles, step_map

STEP = 5e-6
AUDIBLE = -50.0
"""Growth rates above this are compared [1/s], as the figure of a scheme is asked for."""


@pytest.fixture(scope="module")
def case1() -> Assembly:
    return Scenario("case1", step=STEP).prepare()[0]


def largest_difference(found: Poles, expected: Poles) -> float:
    """Return the largest difference of growth rates below 5 kHz, for each pole that was found.

    The modal model has poles that the contact cannot see, where modes of one frequency move it in fewer ways than they
    are; no response tells of them.
    """
    pairs = compare_growth(found.below(5e3), expected)
    return float(np.abs(pairs.error[pairs.exact > AUDIBLE]).max())


@pytest.mark.parametrize("place", ["rail", pytest.param("wheel", marks=pytest.mark.slow)])
def test_an_identified_structure_gives_the_figure_of_its_modes(case1: Assembly, place: str) -> None:
    """Exact and discrete growth rates by two routes, within 0.01 1/s; seen: 1e-8."""
    modal = model_of_assembly(case1, STEP)
    found = identify(case1.fmus[place], case1.parameters[place], STEP, CONTRACT)
    parts = {"wheel": modal.wheel, "rail": modal.rail, place: found}
    model = LinearModel(parts["wheel"], parts["rail"], modal.contact, identified=(place,))
    assert largest_difference(model.poles, modal.poles) < 0.01
    for algorithm, step in (("staggered", STEP), ("jacobi", 2 * STEP)):
        maps = [step_map(m.wheel, m.rail, m.contact, step, algorithm) for m in (model, modal)]
        assert largest_difference(*(discrete_poles(each, step) for each in maps)) < 0.01
        figures = [growth_of_scheme(m, step, algorithm).modes for m in (model, modal)]
        assert figures[0].invented == figures[1].invented


def test_a_rail_of_other_names_and_units_gets_its_figure(tmp_path: Path, built: Path) -> None:
    """`examples/own_rail`: kN and mm/s, axes of its own, no modes shown."""
    from pythonfmu.builder import FmuBuilder  # noqa: PLC0415 - only here

    own = Path(__file__).parents[3] / "examples" / "own_rail"
    FmuBuilder.build_FMU(own / "own_rail.py", dest=tmp_path, needsExecutionTool=False)
    (tmp_path / "own_rail.ssd").write_text((own / "own_rail.ssd").read_text())
    for name in ("wheel", "contact"):
        (tmp_path / f"{name}.fmu").write_bytes((built / f"{name}.fmu").read_bytes())
    assembly, _ = Scenario(str(tmp_path / "own_rail.ssd"), step=1e-5).prepare()
    model = model_of_assembly(assembly, 1e-5)
    assert model.identified == ("rail",)
    spurious = spurious_growth(assembly, Settings(1e-5, 0.01, "staggered"))
    assert spurious.largest is not None, spurious.sentence
    assert "makes no stable mode unstable" in spurious.sentence
