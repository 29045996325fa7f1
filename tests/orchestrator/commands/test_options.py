"""The options that change a system: the same for every command about one, and the same change behind each."""

from __future__ import annotations

import json
import sys
from inspect import signature
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.cli import command_line
from orchestrator.commands.analysis.competition import competition
from orchestrator.commands.analysis.coupling import coupling
from orchestrator.commands.analysis.cycle import cycle
from orchestrator.commands.analysis.stability import stability
from orchestrator.commands.options import OPTIONS
from orchestrator.commands.pages.listen import listen
from orchestrator.commands.systems.export import export
from orchestrator.commands.systems.run import run
from orchestrator.errors import InputError
from orchestrator.runs.changes import Changes
from orchestrator.stability.cases import Changed, find_stability
from orchestrator.stability.linear_model import model_of_assembly


@pytest.mark.parametrize("command", [run, export, coupling, stability, cycle, competition, listen])
def test_every_command_about_a_system_takes_the_same_changes(command: Any) -> None:
    """Five options, three of them word for word the same; `changes` itself is nothing that a user gives."""
    found = signature(command).parameters
    assert list(OPTIONS) == [name for name in found if name in OPTIONS]
    assert "changes" not in found
    for name in ("values", "replace", "damp"):
        assert found[name].annotation is OPTIONS[name]


def test_a_wheel_by_name_brings_its_contact_stiffness_unless_it_is_given() -> None:
    values, sources = Changes(wheel="generic840").resolved("case1")
    assert values["contact"]["hertz_stiffness"] == 1.2e9
    assert sources["wheel"].suffix == ".fmu"
    given = Changes({"contact": {"hertz_stiffness": 2e9}}, wheel="generic840").resolved("case1")[0]
    assert given["contact"]["hertz_stiffness"] == 2e9


def test_stability_and_coupling_see_the_same_change() -> None:
    """Two routes: poles of the case with twice the wheel's damping, by `stability` and by the model of its FMUs."""
    changes = Changes({"contact": {"mu0": 0.3}}, damp=("wheel=x2",))
    values, sources = changes.resolved("case2")
    found = find_stability("case2", changed=Changed.of("case2", values, sources))
    model = model_of_assembly(changes.scenario("case2").prepare()[0], 5e-6)
    assert found.poles is not None
    ours, theirs = (np.sort_complex(p.growth_rate + 1j * p.frequency_hz) for p in (found.poles, model.poles))
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-6 * abs(theirs).max())  # numbers of FMUs have 17 digits
    assert {m for i in found.instabilities for m in i.modes} <= {f"({n},0)" for n in range(8)} | {"(0,x)", "(1,x)"}


def test_gains_follow_the_friction() -> None:
    """With constant friction far below saturation the loop gain goes as the friction coefficient does."""
    base, more = (
        find_stability("case4", changed=Changed.of("case4", {"contact": {"mu0": mu}}, {})) for mu in (0.3, 0.303)
    )
    gains = [[i.crossing.gain for i in found.instabilities] for found in (base, more)]
    np.testing.assert_allclose(gains[1], 1.01 * np.array(gains[0]), rtol=2e-3)  # the loop is nearly linear in mu


def test_results_are_not_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.setattr(sys, "argv", ["curvesqueal", "listen", "r.nc", "--set", "contact.mu0=0.3"])
    assert command_line() == 1
    assert "r.nc: is the result of a run; only a case or a system can be changed" in capsys.readouterr().err


def test_another_rail_for_a_rigid_one_is_refused(native: Path) -> None:
    changed = Changed.of("case2", {}, {"rail": native / "rail.fmu"})
    with pytest.raises(InputError, match="case2 has a rigid rail; take case1 or case3"):
        find_stability("case2", changed=changed)


@pytest.mark.slow
def test_listen_runs_a_case_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    out = tmp_path / "a.wav"
    options = ["--out", str(out), "--duration", "0.4", "--damp", "wheel=x2", "--wheel", "generic840", "--json"]
    monkeypatch.setattr(sys, "argv", ["curvesqueal", "listen", "case1", *options])
    assert command_line() == 0
    assert json.loads(capsys.readouterr().out)["file"] == str(out)
    assert out.is_file()
