"""The coupled system: what the master algorithms make of it, in this process and in the linear step map.

Growth rates are compared, not trajectories: a spurious one decides about squeal.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from coupled import Coupled, linear_contact, modes_of, output, rail_of, scheme_error, wheel
from numpy.typing import NDArray

from fmus.contact.component import contact
from fmus.contact.layout import S
from fmus.wheel.wheelset import DATA, read_wheelset
from orchestrator.stability.poles import Poles, closed_loop_matrix, exact_poles
from orchestrator.stability.step_map import step_map

CASES = (1, 2, 3, 4)
WHEEL = modes_of(wheel())
TALLEST_HZ = 5000.0


def parts(case: int) -> tuple[object, object, object]:
    return WHEEL, modes_of(rail_of(case)), linear_contact(case)


def poles(case: int, **parameters: float) -> Poles:
    return exact_poles(WHEEL, modes_of(rail_of(case)), linear_contact(case, **parameters))


def eigenvector(
    case: int, frequency_hz: float, growth: float
) -> tuple[complex, NDArray[np.complex128], NDArray[np.complex128]]:
    """Return the closed-loop eigenvalue with a frequency and growth rate, its right and its left eigenvector."""
    A = closed_loop_matrix(*parts(case))  # type: ignore[arg-type]
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
    """Two routes to the same step: the compiled components, linearised by a small start, and the matrix.

    The tolerance is what the non-linear terms and finite differences leave at 1e-7 of the sliding velocity.
    """
    h = 5e-6
    random = np.random.default_rng(case)
    w, r, linear = parts(case)
    n = len(w) + len(r)  # type: ignore[arg-type]
    start = 1e-8 * random.standard_normal(n)
    system = Coupled.of(case, h, start, jacobi=jacobi)
    M = step_map(w, r, linear, h, "jacobi" if jacobi else "staggered")  # type: ignore[arg-type]
    turn = linear.turn  # type: ignore[attr-defined]
    held = turn @ system.wheel.inputs
    z = np.concatenate([start, np.zeros(n), held, held, turn @ (system.wheel.outputs[:4] - system.rail.outputs[:4])])
    for _ in range(40):
        system.step()
        z = M @ z
    np.testing.assert_allclose(system.state[:n], z[:n], atol=2e-4 * abs(z[:n]).max())
    np.testing.assert_allclose(
        turn @ system.wheel.inputs, z[2 * n : 2 * n + 4], atol=2e-4 * abs(z[2 * n : 2 * n + 4]).max()
    )


@pytest.mark.parametrize("case", CASES)
def test_staggered_growth_rates_are_right(case: int) -> None:
    """At 5 us every mode below 5 kHz within 1 % or 0.05 1/s; at 10 us no stable mode turns unstable."""
    fine = scheme_error(*parts(case), 5e-6, "staggered", TALLEST_HZ)  # type: ignore[arg-type]
    wrong = (abs(fine.error) > 0.05) & (abs(fine.error) > 0.01 * abs(fine.exact))
    assert not wrong.any(), list(zip(fine.frequency_hz[wrong], fine.exact[wrong], fine.error[wrong], strict=True))
    coarse = scheme_error(*parts(case), 10e-6, "staggered", TALLEST_HZ)  # type: ignore[arg-type]
    assert coarse.invented == 0
    assert abs(coarse.error[coarse.exact > -5]).max() < 0.5


@pytest.mark.parametrize("case", CASES)
def test_jacobi_invents_squeal(case: int) -> None:
    """Plain Jacobi at 10 us turns stable modes unstable; with the rigid rail eight or nine of them."""
    assert scheme_error(*parts(case), 10e-6, "jacobi", TALLEST_HZ).invented >= (8 if case in (2, 4) else 2)  # type: ignore[arg-type]


@pytest.mark.parametrize("case", [1, 4])
def test_compensated_components_step_as_the_step_map_says(case: int) -> None:
    """As above, under jacobi with the contact's host_delay_steps = 1, once its history is complete."""
    h = 5e-6
    w, r, linear = parts(case)
    n = len(w) + len(r)  # type: ignore[arg-type]
    start = 1e-8 * np.random.default_rng(case).standard_normal(n)
    system = Coupled.of(case, h, start, jacobi=True, host_delay_steps=1)
    M = step_map(w, r, linear, h, "compensated")  # type: ignore[arg-type]
    turn = linear.turn  # type: ignore[attr-defined]
    forces = []
    for _ in range(6):
        system.step()
        forces.append(turn @ system.wheel.inputs)
    in_order = np.array([0, 1, 3, 2])  # from lon, lat, spin, normal
    v, rest, older = (
        system.contact.state[[first + i for i in in_order]] for first in (S.v_lon, S.rest_lon, S.older_rest_lon)
    )
    z = np.concatenate([system.state, *forces[:-3:-1], v, forces[-3], rest, older])
    for _ in range(40):
        system.step()
        z = M @ z
    np.testing.assert_allclose(system.state[:n], z[:n], atol=2e-4 * abs(z[:n]).max())
    np.testing.assert_allclose(
        turn @ system.wheel.inputs, z[2 * n : 2 * n + 4], atol=2e-4 * abs(z[2 * n : 2 * n + 4]).max()
    )


@pytest.mark.parametrize("case", CASES)
def test_compensated_jacobi_invents_nothing(case: int) -> None:
    """At 10 us: no stable mode turns unstable; errors of modes above -5 1/s at least 100 times smaller than without.

    Every mode that decays more slowly than 30 1/s is 20 times better or within 0.15 1/s; all but a dozen, strongly
    damped ones, are 20 times better or within 0.05 1/s.
    """
    plain, found = (scheme_error(*parts(case), 10e-6, how, TALLEST_HZ) for how in ("jacobi", "compensated"))  # type: ignore[arg-type]
    assert found.invented == 0
    weak = found.exact > -5
    assert abs(found.error[weak]).max() < min(0.15, 0.01 * abs(plain.error[weak]).max())
    slow = found.exact > -30
    better = abs(found.error) <= abs(plain.error) / 20
    assert (better | (abs(found.error) < 0.15))[slow].all()
    assert (~better & (abs(found.error) > 0.05)).sum() <= 12


def growth_in_stick(case: int, h: float, share: float, directions: tuple[int, int, int] = (1, 1, 1)) -> float:
    """Return the largest growth per step, less 1, at a share of the creep slope of full stick."""
    w, r, _ = parts(case)
    stick = linear_contact(case, steady_creepage_lat=0.0)
    M = step_map(w, r, replace(stick, H1=stick.H1 * share * np.outer(directions, directions)), h, "compensated")  # type: ignore[arg-type]
    return float(abs(np.linalg.eigvals(M)).max()) - 1


@pytest.mark.parametrize("share", [0.05, 0.2, 1.0])
@pytest.mark.parametrize("case", [1, 2])
def test_compensated_jacobi_is_stable_in_stick(case: int, share: float) -> None:
    """From little creep to full stick nothing grows at 10 us; plain jacobi grows 1.38-fold at every step there."""
    assert growth_in_stick(case, 10e-6, share) < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("h", [5e-6, 20e-6])
@pytest.mark.parametrize("case", [1, 2])
def test_compensated_jacobi_is_stable_at_any_creep_slope(case: int, h: float) -> None:
    """At half and twice the step, from full sliding to twice the slope of full stick, in all directions or one."""
    for share in (0.01, 0.05, 0.1, 0.4, 1.0, 2.0):
        for directions in ((1, 1, 1), (1, 0, 0), (0, 1, 0)):
            assert growth_in_stick(case, h, share, directions) < 1e-9


def test_long_compensated_jacobi_run_behaves_like_the_staggered_one() -> None:
    """Case 1 to its limit cycle through stick and slip: the level of the force within 8 % at 10 us, 5 % at 5 us.

    In stick the prediction is of first order, so the difference falls with the step. Plain jacobi is 12 times too high.
    """

    def level(h: float, **how: object) -> float:
        force = friction_in_stick(h, seconds=0.3, **how)  # type: ignore[arg-type]
        return float(np.std(force[len(force) // 2 :]))

    compensated = {"jacobi": True, "host_delay_steps": 1}
    for h, tolerance in ((10e-6, 0.08), (5e-6, 0.05)):
        assert level(h, **compensated) == pytest.approx(level(h), rel=tolerance)
    assert level(10e-6, jacobi=True) > 10 * level(10e-6)


def test_compensated_friction_in_stick_does_not_alternate() -> None:
    """What turns back from step to step vanishes with the step, as in the staggered scheme; no zigzag is left."""
    steps, speeds = (10e-6, 5e-6, 2.5e-6, 1.25e-6), (0.21, 0.22, 0.23, 0.24)
    runs = [[reversals(friction_in_stick(h, speed=v, jacobi=True, host_delay_steps=1)) for v in speeds] for h in steps]
    largest = [np.mean([r.max() for r in of_step]) for of_step in runs]
    assert all(later < 0.65 * earlier for earlier, later in pairwise(largest)), largest
    assert largest[0] < 400
    assert max(zigzag(r) for of_step in runs for r in of_step) < 1e-3 * 18e3


def test_false_squeal_grows_in_a_jacobi_run_and_not_in_a_staggered_one() -> None:
    """Case 4 at 10 us, the invented mode that grows fastest: it decays as it should in the staggered run."""
    e = scheme_error(*parts(4), 10e-6, "jacobi", TALLEST_HZ)  # type: ignore[arg-type]
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
        e = scheme_error(*parts(3), h, "staggered", 2000.0)  # type: ignore[arg-type]
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
        e = scheme_error(*parts(3), h, "jacobi", 2000.0)  # type: ignore[arg-type]
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


def friction_in_stick(h: float, seconds: float = 4e-3, speed: float = 0.22, **how: object) -> NDArray[np.float64]:
    """Return the lateral friction force while Case 1 starts at 0.2 m/s on the mode at 1102 Hz, where it sticks."""
    labels = read_wheelset(DATA / "generic840.toml").modes.labels
    mode = labels.index("(3,0) cosine")
    start = np.zeros(len(WHEEL) + len(modes_of(rail_of(1))))
    start[mode] = -speed / WHEEL.shape[mode, 1]
    record = Coupled.of(1, h, start, **how).run(round(seconds / h))  # type: ignore[arg-type]
    force = record["contact"][:, output(contact(), "tangential_force_lat")]
    return force[round(0.5e-3 / h) :]  # after the jolt of the start


def reversals(force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the smaller of two successive changes where they have opposite signs [N], else 0."""
    before, after = np.diff(force)[:-1], np.diff(force)[1:]
    return np.where(before * after < 0, np.minimum(abs(before), abs(after)), 0.0)


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


def zigzag(reversed_: NDArray[np.float64]) -> float:
    """Return the largest force that goes back and forth in three successive steps [N]."""
    return float(np.minimum(reversed_[:-1], reversed_[1:]).max())
