"""Masters that iterate, and components with steps of their own: the two-mass oscillator and rings of gains."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from fmi3_fmu import StateSpace, needs_compiler, state_space_fmu, write_ssd
from numpy.typing import NDArray
from scipy.linalg import expm
from two_masses import DAMPING, MASSES, STIFFNESS, two_masses

from orchestrator.coupling.assembly import assemble
from orchestrator.coupling.master import Master, Progress, Settings
from orchestrator.errors import InputError, SimulationError
from orchestrator.system.model import System
from orchestrator.system.reader import read_system

pytestmark = needs_compiler


def exact(time: float) -> NDArray[np.float64]:
    """Return the motion of both masses: the exponential of the coupled system."""
    (m, n), k, c = MASSES, STIFFNESS, DAMPING
    A = [
        [0, 1, 0, 0],
        [-(1 + k) / m, -c / m, k / m, c / m],
        [0, 0, 0, 1],
        [k / n, c / n, -(1 + k) / n, -c / n],
    ]
    return np.asarray(expm(np.array(A) * time) @ [1, 0, 0, 0])


def end_state(system: System, settings: Settings) -> tuple[NDArray[np.float64], Progress]:
    """Run and return the motion of both masses at the end."""
    with Master(assemble(system), settings) as master:
        progress = master.run()
        last = dict(zip(master.outputs, master.plan.y, strict=True))
    return np.array([last[m, f"y[{i}]"] for m in ("one", "two") for i in (1, 2)]), progress


@pytest.mark.parametrize(("algorithm", "order"), [("staggered", 1), ("jacobi", 1), ("iterative", 2)])
def test_order_of_convergence_on_the_two_mass_oscillator(masses: Path, algorithm: str, order: int) -> None:
    """A spring that knows nothing of the step: held forces are of first order, the converged mean of second."""
    system = two_masses(masses)
    steps = (0.02, 0.01, 0.005)
    errors = [abs(end_state(system, Settings(h, 4.0, algorithm))[0] - exact(4.0)).max() for h in steps]
    orders = [np.log2(a / b) for a, b in pairwise(errors)]
    assert orders == pytest.approx([order] * 2, abs=0.15), errors


def test_iteration_reports_its_sweeps(masses: Path) -> None:
    _, progress = end_state(two_masses(masses), Settings(0.01, 1.0, "iterative"))
    assert 2 <= progress.sweeps <= progress.most_sweeps < 12
    _, plain = end_state(two_masses(masses), Settings(0.01, 1.0))
    assert (plain.sweeps, plain.most_sweeps) == (1.0, 1)


def ring_of_gains(masses: Path, gain: float) -> System:
    """Return two FMUs whose outputs depend on each other within a step: y = gain u + x, x = 1 in the first."""
    file = state_space_fmu(masses, "gain", StateSpace([[0]], [[0]], [[1]], [[gain]]))
    ssd = write_ssd(masses / "ring.ssd", {"a": file, "b": file}, [("a.y[1]", "b.u[1]"), ("b.y[1]", "a.u[1]")])
    return read_system(ssd).with_parameters({"a": {"x0": "1"}})


def test_iteration_solves_an_algebraic_loop(tmp_path: Path) -> None:
    """y_a = y_b/2 + 1, y_b = y_a/2: 4/3 and 2/3 at every step, the first included."""
    system = ring_of_gains(tmp_path, 0.5)
    with pytest.raises(InputError, match=r"algebraic loop: the outputs of a, b depend on each other"):
        Master(assemble(system), Settings(0.1, 1.0))
    with Master(assemble(system), Settings(0.1, 1.0, "iterative")) as master:
        for _ in range(2):
            values = dict(zip(master.outputs, master.plan.y.copy(), strict=True))
            assert values["a", "y[1]"] == pytest.approx(4 / 3, rel=1e-7)
            assert values["b", "y[1]"] == pytest.approx(2 / 3, rel=1e-7)
            master.run()


def test_an_iteration_that_does_not_converge_says_so(tmp_path: Path) -> None:
    with (
        Master(assemble(ring_of_gains(tmp_path, 1.5)), Settings(0.1, 1.0, "iterative")) as master,
        pytest.raises(SimulationError, match=r"iterative: input [ab]\.u\[1\] still changes after 50 sweeps at t = 0 s"),
    ):
        master.run()


def test_iteration_needs_the_state(masses: Path) -> None:
    system = two_masses(masses, one="one_forgetful")
    with pytest.raises(InputError, match=r"iterative: one \(one_forgetful.fmu\) cannot get and set its state"):
        Master(assemble(system), Settings(0.01, 1.0, "iterative"))
    state, _ = end_state(system, Settings(0.01, 1.0))
    same, _ = end_state(two_masses(masses), Settings(0.01, 1.0))
    np.testing.assert_array_equal(state, same)


def with_own_step(system: System, name: str, step: float) -> System:
    """Return the system with a step of its own for a component, as an annotation gives it."""
    return replace(system, elements={**system.elements, name: replace(system.elements[name], step=step)})


def test_component_with_a_longer_step_of_its_own(masses: Path) -> None:
    """One mass steps by 0.04 s among others of 0.01 s: its outputs stay in between, and the whole still converges."""
    system = with_own_step(two_masses(masses), "one", 0.04)
    with Master(assemble(system), Settings(0.01, 0.12)) as master:
        assert master.notices == ["one makes one step of 0.04 s in 4 communication steps"]
        seen = []
        for _ in range(12):
            master.run(steps=1)
            seen.append(master.plan.y[master.outputs.index(("one", "y[1]"))])
    assert [len(set(seen[4 * k + 3 : 4 * k + 7])) for k in range(2)] == [1, 1]
    assert len(set(seen)) == 4  # the start, and three steps
    coarse, _ = end_state(two_masses(masses), Settings(0.04, 4.0))
    mixed, _ = end_state(system, Settings(0.01, 4.0))
    assert abs(mixed - exact(4.0)).max() < abs(coarse - exact(4.0)).max()


def test_steps_that_do_not_fit_are_refused(masses: Path) -> None:
    """Neither a step that is no multiple, nor a run at whose end a slow component has not arrived."""
    system = with_own_step(two_masses(masses), "one", 0.04)
    with pytest.raises(
        InputError, match=r"one: the system has it step by 0.04 s, no whole multiple of .* step of 0.03"
    ):
        Master(assemble(system), Settings(0.03, 1.0))
    with pytest.raises(
        InputError, match=r"one makes one step in 4 communication steps, and the run has 6: it would not"
    ):
        Master(assemble(system), Settings(0.01, 0.06))
    with pytest.raises(InputError, match=r"iterative: one .* steps more slowly than the others"):
        Master(assemble(system), Settings(0.02, 1.0, "iterative"))


def test_an_inner_step_is_advice(masses: Path) -> None:
    """FMI 3.0 fixedInternalStepSize: the FMU steps with the others all the same; that it does not fit is told."""
    system = two_masses(masses, one="one_slow")
    for step, told in ((0.02, 1), (0.08, 0)):
        with Master(assemble(system), Settings(step, 0.8)) as master:
            assert sum("steps inside by 0.04 s" in notice for notice in master.notices) == told
        found, plain = (end_state(s, Settings(step, 0.8))[0] for s in (system, two_masses(masses)))
        np.testing.assert_array_equal(found, plain)
