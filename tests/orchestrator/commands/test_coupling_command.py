"""The command `coupling`: growth rates of the schemes, from the parameters of the FMUs, and the largest safe step."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from coupled import linear_contact, modes_of, rail_of, scheme_error
from toy_fmus import toy_fmu, toy_ssd

from fmus.modal.modes import Modes
from fmus.wheel.class158 import identified_stiffness
from fmus.wheel.component import wheel
from orchestrator.cli import command_line
from orchestrator.runs.scenario import Scenario
from orchestrator.stability.linear_model import LinearModel, model_of_assembly
from orchestrator.stability.poles import eigenvalues, exact_poles
from orchestrator.stability.scheme import growth_of_scheme, largest_safe_step
from orchestrator.stability.step_map import step_map


def system(case: str, **how: Any) -> LinearModel:
    """Return the linear model of a case, found through its FMUs."""
    return model_of_assembly(Scenario(case, **how).prepare()[0], 5e-6)


@pytest.fixture(scope="module")
def case2(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    out = tmp_path_factory.mktemp("c") / "out.json"
    with pytest.MonkeyPatch.context() as patch, out.open("w") as file:
        patch.setattr(sys, "argv", ["curvesqueal", "coupling", "case2", "--step", "1e-5", "--json"])
        patch.setattr(sys, "stdout", file)
        assert command_line() == 0
    data: dict[str, Any] = json.loads(out.read_text())
    return data


@pytest.mark.parametrize("case", [1, 2, 3, 4])
def test_default_meets_its_targets(case: int) -> None:
    """5 us: every mode within 1 % or 0.05 1/s. 10 us: nothing invented, weakly damped modes within 0.5 1/s."""
    model = system(f"case{case}")
    fine = growth_of_scheme(model, 5e-6, "staggered").modes
    assert fine.exact.size > 90
    assert ((abs(fine.error) < 0.05) | (abs(fine.error) < 0.01 * abs(fine.exact))).all()
    coarse = growth_of_scheme(model, 10e-6, "staggered").modes
    assert coarse.invented == 0
    assert coarse.largest_weak <= 0.5
    assert growth_of_scheme(model, 10e-6, "staggered").safe


def test_model_from_fmus_is_the_model_from_components() -> None:
    """Two routes: parameters of the FMUs, and the components' data; rounding of eigenvalues of the order 1e5 1/s."""
    found = growth_of_scheme(system("case1"), 5e-6, "staggered").modes
    expected = scheme_error(
        modes_of(wheel()), modes_of(rail_of(1)), linear_contact(1, hertz_stiffness=identified_stiffness()), 5e-6
    )
    np.testing.assert_allclose(found.exact, expected.exact, atol=1e-5)
    np.testing.assert_allclose(found.discrete, expected.discrete, atol=1e-5)


def test_values_that_are_set_count() -> None:
    """A mode's damping ratio and the friction coefficient, set as a user does, arrive in the model."""
    changed = system("case1", values={"wheel": {"damping_ratio_001": "0.01"}, "contact": {"mu0": "0"}})
    plain = system("case1")
    assert isinstance(changed.wheel, Modes)
    assert isinstance(plain.wheel, Modes)
    assert changed.wheel.zeta[0] == 0.01
    np.testing.assert_array_equal(changed.wheel.zeta[1:], plain.wheel.zeta[1:])
    assert changed.poles.growth_rate.max() < 1e-8  # without friction nothing grows
    assert plain.poles.growth_rate.max() > 20


def test_eigenvalues_of_parts_are_those_of_the_whole() -> None:
    model = system("case1")
    M = step_map(model.wheel, model.rail, model.contact, 5e-6)
    whole, parts = (np.sort_complex(np.round(e, 9)) for e in (np.linalg.eigvals(M), eigenvalues(M)))
    np.testing.assert_allclose(parts, whole, atol=1e-7)
    direct = exact_poles(model.wheel, model.rail, model.contact)
    np.testing.assert_allclose(np.sort(direct.growth_rate), np.sort(model.poles.growth_rate), atol=1e-5)


@pytest.mark.parametrize("algorithm", ["staggered", "jacobi", "iterative"])
@pytest.mark.parametrize("integrated", [(), ("rail",), ("wheel", "rail")])
def test_every_scheme_converges_to_the_coupled_system(algorithm: str, integrated: tuple[str, ...]) -> None:
    """At 0.1 us the growth rates are those without a step: nothing in a scheme is wrong by a constant."""
    plain = system("case3")
    model = LinearModel(plain.wheel, plain.rail, plain.contact, integrated)
    fine, finer = (growth_of_scheme(model, h, algorithm).modes.largest_weak for h in (2e-7, 1e-7))
    assert finer < 0.6 * fine
    assert finer < 0.06


def test_staggered_is_the_only_one_of_second_order() -> None:
    """Why there is no further algorithm of second order: the default is, with this contact."""
    model = system("case3")
    error = {
        a: [growth_of_scheme(model, h, a).modes.largest_weak for h in (10e-6, 5e-6)]
        for a in ("staggered", "jacobi", "iterative")
    }
    order = {a: np.log2(coarse / fine) for a, (coarse, fine) in error.items()}
    assert order["staggered"] == pytest.approx(2, abs=0.25)
    assert max(order["jacobi"], order["iterative"]) < 1.6
    assert error["staggered"][0] < 0.15 * min(error["jacobi"][0], error["iterative"][0])


def test_json_names_modes_and_safe_steps(case2: dict[str, Any]) -> None:
    """Jacobi at 10 us makes eight modes of Case 2 unstable; its safe step is far below the default's."""
    assert set(case2) == {"staggered", "jacobi", "iterative"}
    for data in case2.values():
        errors = [abs(mode["discrete"] - mode["exact"]) for mode in data["modes"]]
        assert data["max_growth_rate_error"] == pytest.approx(max(errors))
        frequencies = [mode["frequency_hz"] for mode in data["modes"]]
        assert frequencies == sorted(frequencies)
        assert 0 < frequencies[0] < frequencies[-1] < 5000
    jacobi, staggered = case2["jacobi"], case2["staggered"]
    assert sum(mode["exact"] <= 0 < mode["discrete"] for mode in jacobi["modes"]) == 8
    assert not any(mode["exact"] <= 0 < mode["discrete"] for mode in staggered["modes"])
    assert jacobi["largest_safe_step_s"] < 1e-6
    assert staggered["largest_safe_step_s"] >= 1e-5


@pytest.mark.parametrize("algorithm", ["staggered", "jacobi"])
def test_largest_safe_step_is_safe_and_a_third_more_is_not(algorithm: str) -> None:
    model = system("case4")
    step = largest_safe_step(model, algorithm)
    assert step is not None
    assert growth_of_scheme(model, step, algorithm).safe
    assert not growth_of_scheme(model, 1.33 * step, algorithm).safe


def test_table_is_printed_for_people(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["curvesqueal", "coupling", "case4", "--step", "1e-5"])
    assert command_line() == 0
    out = capsys.readouterr().out
    for word in ("staggered", "jacobi", "iterative", "1976.2", "largest"):
        assert word in out, out


def test_systems_of_which_nothing_is_known_get_a_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bent = "self.y = 0.5 * self.u + self.u * abs(self.u)"
    ring = toy_ssd(tmp_path, toy_fmu(tmp_path, "One", bent), toy_fmu(tmp_path, "Two", bent))
    monkeypatch.setattr(sys, "argv", ["curvesqueal", "coupling", str(ring), "--step", "1e-5"])
    assert command_line() == 1
    said = " ".join(capsys.readouterr().err.split())
    assert "no growth rates can be given" in said, said
    assert "no contact that takes interface mobilities" in said
    assert "the system is not linear there" in said
