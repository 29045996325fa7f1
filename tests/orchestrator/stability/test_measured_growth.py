"""Growth rates of any system under each algorithm: against closed forms of a mass on a spring."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import StateSpace, needs_compiler, state_space_fmu, write_ssd

from orchestrator.cli import command_line
from orchestrator.coupling.assembly import Assembly, assemble
from orchestrator.errors import InputError
from orchestrator.stability.measured_growth import as_json, measured_growth
from orchestrator.stability.realisation import realise
from orchestrator.system.reader import read_system

pytestmark = needs_compiler

H, MASS, STIFFNESS = 0.01, 2.0, 200.0
A = H**2 * STIFFNESS / MASS


def oscillator(folder: Path, extra: bool = False) -> Path:
    """Write a mass, whose position goes to a spring without state; `extra`: with an input that nobody drives."""
    forces = [[0, 0], [1 / MASS, 0.3]] if extra else [[0], [1 / MASS]]
    state_space_fmu(folder, "mass", StateSpace([[0, 1], [0, 0]], forces, [[1, 0]]))
    state_space_fmu(folder, "spring", StateSpace([[0]], [[0]], [[0]], [[-STIFFNESS]]))
    wires = [("mass.y", "spring.u"), ("spring.y[1]", "mass.u[1]")]
    return write_ssd(folder / "s.ssd", {n: folder / f"{n}.fmu" for n in ("mass", "spring")}, wires)


def system(file: Path) -> Assembly:
    return assemble(read_system(file))


def jacobi_rate() -> tuple[float, float]:
    """Return growth rate and frequency of a mass that feels the spring's force of a step ago, held over the step."""
    step = np.array([[1, H, H**2 / 2 / MASS], [0, 1, H / MASS], [-STIFFNESS, 0, 0]])
    s = np.log(np.linalg.eigvals(step).astype(complex)) / H
    slow = s[np.argmin(abs(s - 10j))]
    return float(slow.real), float(abs(slow.imag))


@pytest.mark.parametrize("extra", [False, True])
def test_growth_of_a_mass_on_a_spring_is_the_closed_form(tmp_path: Path, extra: bool) -> None:
    """Held force after the new position: |z|^2 = 1 + (h omega)^2/2; the mean of old and new force: |z| = 1."""
    found = as_json(*measured_growth(system(oscillator(tmp_path, extra)), H))
    rates = {name: data["modes"][0]["growth_rate"] for name, data in found["algorithms"].items()}
    assert rates["staggered"] == pytest.approx(np.log(1 + A / 2) / (2 * H), rel=1e-6)
    rate, omega = jacobi_rate()
    assert rates["jacobi"] == pytest.approx(rate, rel=1e-6)
    assert found["algorithms"]["jacobi"]["modes"][0]["frequency_hz"] == pytest.approx(omega / (2 * np.pi), rel=1e-9)
    assert rates["iterative"] == pytest.approx(0.0, abs=1e-6)
    fine = A / 64
    assert found["reference"]["modes"][0]["growth_rate"] == pytest.approx(np.log(1 + fine / 2) / (2 * H / 8), rel=1e-5)


def test_an_algebraic_loop_is_told_for_staggered_and_solved_by_the_others(tmp_path: Path) -> None:
    """Gains of 0.5 and 0.5 in a ring: jacobi has z^2 = 0.25, so -ln 2 per step; iterated, nothing is left to decay."""
    half = StateSpace([[0]], [[0]], [[0]], [[0.5]])
    files = {name: state_space_fmu(tmp_path, name, half) for name in ("one", "two")}
    ring = write_ssd(tmp_path / "r.ssd", files, [("one.y", "two.u"), ("two.y", "one.u")])
    _, found = measured_growth(system(ring), H)
    known = {m.algorithm: m for m in found}
    assert "algebraic loop" in known["staggered"].reason
    assert known["jacobi"].modes.s.real == pytest.approx([-np.log(2) / H] * known["jacobi"].modes.s.size, rel=1e-6)
    assert known["jacobi"].modes.s.size == 2
    assert not known["iterative"].reason


def test_the_command_shows_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    arguments = ["curvesqueal", "coupling", str(oscillator(tmp_path)), "--step", str(H)]
    monkeypatch.setattr(sys, "argv", arguments)
    assert command_line() == 0
    shown = capsys.readouterr().out
    assert all(text in shown for text in ("0.2494", "0.7384", "1.592", "staggered", "iterative")), shown
    monkeypatch.setattr(sys, "argv", [*arguments, "--json"])
    assert command_line() == 0
    data = json.loads(capsys.readouterr().out)
    assert set(data["algorithms"]) == {"staggered", "jacobi", "iterative"}
    assert data["algorithms"]["jacobi"]["fastest_growth_rate"] == pytest.approx(jacobi_rate()[0], rel=1e-6)


def test_modes_are_told_of_any_number_of_outputs() -> None:
    """Three decays, one of them real, seen by two outputs after two disturbances."""
    s = np.array([-0.5 + 40j, 0.2 + 90j, -3.0])
    random = np.random.default_rng(5)
    C, B = random.standard_normal((2, 3)), random.standard_normal((3, 2))
    k = np.arange(2400)[:, None]
    decay = np.einsum("pn,kn,nm->kpm", C, np.exp(s * k * H), B).real
    found = realise(decay, H).s
    np.testing.assert_allclose(found, s[np.argsort(-s.real)], rtol=1e-8, atol=1e-8)


def test_what_is_no_sum_of_exponentials_is_said() -> None:
    time = np.arange(2400.0)[:, None, None]
    with pytest.raises(InputError, match="no sum of"):
        realise(np.sin(1e-5 * time**2) * np.exp(-1e-3 * time), H)
