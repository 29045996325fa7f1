"""The coupled system: what the master algorithms make of it, in this process and in the linear step map.

Growth rates are compared, not trajectories: a spurious one decides about squeal.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from coupled import Coupled, linear_contact, modes_of, rail_of, scheme_error
from coupled_poles import CASES, TALLEST_HZ, WHEEL, assert_steps_as, friction_in_stick, parts, reversals, zigzag
from numpy.typing import NDArray

from orchestrator.stability.poles import Poles, closed_loop_matrix, exact_poles
from orchestrator.stability.step_map import step_map


def poles(case: int, **parameters: float) -> Poles:
    return exact_poles(WHEEL, modes_of(rail_of(case)), linear_contact(case, **parameters))


def eigenvector(
    case: int, frequency_hz: float, growth: float
) -> tuple[complex, NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the closed-loop eigenvalue with a frequency and growth rate, its right and its left eigenvector."""
    A = closed_loop_matrix(*parts(case))
    values, right = np.linalg.eig(A)
    k = int(np.argmin(abs(values - growth - 2j * np.pi * frequency_hz)))
    left = np.linalg.inv(right)[k]
    return complex(values[k]), right[:, k], left


def measured_growth(
    case: int, pole: complex, left: NDArray[np.complex128], start: NDArray[np.float64], **how: object
) -> float:
    """Return the growth rate of one mode's amplitude |left x| in a run of 0.1 s from initial modal velocities."""
    h = float(how.pop("h", 5e-6))  # type: ignore[arg-type]
    system = Coupled.of(case, h, start, **how)  # type: ignore[arg-type]
    period = 2 * np.pi / pole.imag
    every, times, levels = max(1, round(period / h)), [], []
    for k in range(round(0.1 / h)):
        system.step()
        if (k + 1) % every == 0 and (k + 1) * h > 0.02:
            times.append((k + 1) * h)
            levels.append(np.log(abs(left @ system.state)))
    return float(np.polyfit(times, levels, 1)[0])


def test_growth_of_the_fastest_mode_is_the_eigenvalue() -> None:
    """Case 1 from 1e-6 m/s: the run grows as the closed loop says, within 2 % at 5 us."""
    unstable = poles(1).below(TALLEST_HZ).unstable()
    fastest = int(unstable.growth_rate.argmax())
    pole, right, left = eigenvector(1, unstable.frequency_hz[fastest], unstable.growth_rate[fastest])
    n = right.size // 2
    lateral = WHEEL.shape[:, 1] @ right[: len(WHEEL)]
    start = (right[:n] / lateral).real * 1e-6
    assert WHEEL.shape[:, 1] @ start[: len(WHEEL)] == pytest.approx(1e-6)
    assert measured_growth(1, pole, left, start) == pytest.approx(pole.real, rel=0.02)


@pytest.mark.parametrize("jacobi", [False, True])
@pytest.mark.parametrize("case", [1, 4])
def test_components_step_as_the_step_map_says(case: int, jacobi: bool) -> None:
    """Two routes to the same step: the compiled components, linearised by a small start, and the matrix."""
    h = 5e-6
    random = np.random.default_rng(case)
    w, r, linear = parts(case)
    n = len(w) + len(r)
    start = 1e-8 * random.standard_normal(n)
    system = Coupled.of(case, h, start, jacobi=jacobi)
    M = step_map(w, r, linear, h, "jacobi" if jacobi else "staggered")
    turn = linear.turn
    held = turn @ system.wheel.inputs
    z = np.concatenate([start, np.zeros(n), held, held, turn @ (system.wheel.outputs[:4] - system.rail.outputs[:4])])
    assert_steps_as(M, z, system, turn)


@pytest.mark.parametrize("case", CASES)
def test_staggered_growth_rates_are_right(case: int) -> None:
    """At 5 us every mode below 5 kHz within 1 % or 0.05 1/s; at 10 us no stable mode turns unstable."""
    fine = scheme_error(*parts(case), 5e-6, "staggered", TALLEST_HZ)
    wrong = (abs(fine.error) > 0.05) & (abs(fine.error) > 0.01 * abs(fine.exact))
    assert not wrong.any(), list(zip(fine.frequency_hz[wrong], fine.exact[wrong], fine.error[wrong], strict=True))
    coarse = scheme_error(*parts(case), 10e-6, "staggered", TALLEST_HZ)
    assert coarse.invented == 0
    assert abs(coarse.error[coarse.exact > -5]).max() < 0.5


@pytest.mark.parametrize("case", CASES)
def test_jacobi_invents_squeal(case: int) -> None:
    """Plain Jacobi at 10 us turns stable modes unstable; with the rigid rail eight or nine of them."""
    assert scheme_error(*parts(case), 10e-6, "jacobi", TALLEST_HZ).invented >= (8 if case in (2, 4) else 2)


@pytest.mark.slow
def test_false_squeal_grows_in_a_jacobi_run_and_not_in_a_staggered_one() -> None:
    """Case 4 at 10 us, the invented mode that grows fastest: it decays as it should in the staggered run."""
    e = scheme_error(*parts(4), 10e-6, "jacobi", TALLEST_HZ)
    invented = np.flatnonzero((e.exact <= 0) & (e.discrete > 0))
    worst = invented[e.discrete[invented].argmax()]
    pole, right, left = eigenvector(4, e.frequency_hz[worst], e.exact[worst])
    assert pole.real < 0
    n = right.size // 2
    start = right[:n].real / abs(right[:n]).max() * 1e-6
    assert measured_growth(4, pole, left, start, h=10e-6, jacobi=True) == pytest.approx(e.discrete[worst], rel=0.1)
    assert measured_growth(4, pole, left, start, h=10e-6) < 0


def test_staggered_scheme_is_of_second_order() -> None:
    """Halving the step quarters the error of the growth rates (Case 3, weakly damped modes below 2 kHz)."""
    errors = []
    for h in (20e-6, 10e-6, 5e-6):
        e = scheme_error(*parts(3), h, "staggered", 2000.0)
        errors.append(np.sqrt(np.mean(e.error[e.exact > -20] ** 2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([2, 2], abs=0.25)


@pytest.mark.parametrize("case", [1, 4])
def test_run_from_random_velocities_is_of_second_order(case: int) -> None:
    """Halving the step quarters what it changes of the modal velocities: the start loses no order."""
    n = len(WHEEL) + len(modes_of(rail_of(case)))
    start = 1e-3 * np.random.default_rng(case).standard_normal(n)
    ends = []
    for h in (4e-6, 2e-6, 1e-6, 0.5e-6):
        system = Coupled.of(case, h, start)
        for _ in range(round(2e-4 / h)):
            system.step()
        ends.append(system.state[:n])
    changes = [np.linalg.norm(coarse - fine) for coarse, fine in pairwise(ends)]
    assert np.log2(np.array(changes[:-1]) / changes[1:]) == pytest.approx([2, 2], abs=0.1)


def test_jacobi_is_of_first_order() -> None:
    errors = []
    for h in (2e-6, 1e-6, 0.5e-6):
        e = scheme_error(*parts(3), h, "jacobi", 2000.0)
        errors.append(np.sqrt(np.mean(e.error[e.exact > -20] ** 2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx([1, 1], abs=0.25)


@pytest.mark.parametrize("case", CASES)
def test_without_friction_nothing_grows(case: int) -> None:
    """With mu = 0: no unstable pole; rounding of an eigenvalue of the order 1e5 rad/s is allowed."""
    assert poles(case, mu0=0.0).growth_rate.max() < 1e-8


@pytest.mark.parametrize("case", [3, 4])
def test_reversed_creepage_is_stable_under_constant_friction(case: int) -> None:
    """The sign of (creepage, contact angle, web offset) decides: reversed, nothing is unstable from 150 Hz up."""
    assert poles(case).unstable().frequency_hz.size > 0
    reversed_ = poles(case, steady_creepage_lat=-0.02).below(TALLEST_HZ).unstable()
    assert not (reversed_.frequency_hz >= 150).any(), reversed_


def test_constant_friction_is_unstable_where_the_paper_says() -> None:
    """Table 4: six unstable modes with the rail, two without; the poles lie within 2 % of its frequencies."""
    with_rail = poles(3).below(4500).unstable().frequency_hz
    without = poles(4).below(4500).unstable().frequency_hz
    assert without == pytest.approx([263.1, 1977], rel=0.02)
    paper = [150.8, 272.5, 418.2, 1102, 1977, 3974]
    assert len(with_rail) == len(paper)
    assert with_rail == pytest.approx(paper, rel=0.02)


def test_friction_in_stick_does_not_alternate_from_step_to_step() -> None:
    """The alternation vanishes with the step, and no zigzag is ever left; an explicit contact chatters at any step."""
    steps = (10e-6, 5e-6, 2.5e-6, 1.25e-6)
    implicit = [reversals(friction_in_stick(h, implicit=True)) for h in steps]
    largest = [r.max() for r in implicit]
    assert all(later < 0.6 * earlier for earlier, later in pairwise(largest)), largest
    assert max(zigzag(r) for r in implicit) < 1.0
    explicit = [reversals(friction_in_stick(h, implicit=False)) for h in steps]
    assert min(r.max() for r in explicit) > 5e3
    assert min(zigzag(r) for r in explicit) > 1e3
