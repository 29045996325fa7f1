"""Exponents of cycles: two routes, the phase, the time domain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import fftconvolve
from squeal_models import class158_case, fused_run, only, start_of, tone_of

from orchestrator.limit_cycles.floquet import monodromy
from orchestrator.limit_cycles.hill import hill
from orchestrator.stability.poles import closed_loop_matrix


@pytest.mark.parametrize(("case", "tone"), [(1, 272.0), (2, 253.7), (3, 272.0)])
def test_monodromy_and_hill_agree(case: int, tone: float) -> None:
    """Growth of perturbations in steps of time and at frequencies: 1 % or 0.1 1/s for complex pairs."""
    judged = only(tone_of(case, tone)).stability
    assert judged is not None
    assert judged.sidebands is not None
    assert judged.sidebands.exponent.real == pytest.approx(judged.largest.real, rel=0.01, abs=0.1)
    assert judged.sidebands.exponent.imag == pytest.approx(judged.largest.imag, rel=1e-3)


@pytest.mark.parametrize(("case", "tone"), [(1, 1100.0), (1, 272.0), (2, 1980.0)])
def test_phase_is_found_by_its_vector_and_does_not_grow(case: int, tone: float) -> None:
    """A shift in time neither grows nor dies; what is off is the error of steps and harmonics."""
    cycle = only(tone_of(case, tone))
    assert cycle.stability is not None
    assert cycle.stability.floquet.overlap > 0.9
    assert cycle.stability.floquet.phase == pytest.approx(0.0, abs=0.25)
    exact = hill(cycle.balance, cycle.state, 0.01 + 0j)
    assert exact is not None
    assert abs(exact.exponent) < 0.25
    k = np.arange(-cycle.balance.truncation.harmonics, cycle.balance.truncation.harmonics + 1)
    whole = np.concatenate([cycle.state.forces[:0:-1].conj(), cycle.state.forces])
    own = (1j * k[:, None] * whole).ravel()
    overlap = abs(np.vdot(own, exact.forces.ravel())) / np.linalg.norm(own) / np.linalg.norm(exact.forces)
    assert overlap > 0.9


def test_exponents_about_rest_are_the_poles() -> None:
    """With the linear slope all over the period the monodromy matrix is the exponential of the state matrix."""
    cycle = only(tone_of(1, 1100.0))
    model, motion = cycle.balance.model, cycle.motion
    rest = replace(motion, relative=0 * motion.relative)
    period = 2 * np.pi / motion.omega
    found = np.log(np.linalg.eigvals(monodromy(model, rest, steps=2000)).astype(complex)) / period
    exact = np.linalg.eigvals(closed_loop_matrix(model.wheel, model.rail, model.linear))
    exact = exact[(np.abs(exact.imag) < motion.omega * 5.9) & (exact.real > -500)]
    folded = exact.real + 1j * ((exact.imag + motion.omega / 2) % motion.omega - motion.omega / 2)
    near = np.abs(np.exp(folded[:, None] * period) - np.exp(found[None] * period)).min(axis=1) / period
    assert near.max() < 0.05  # 1/s; steps of 0.45 us: (omega h)^2 / 12 of the contact's share of a pole


def test_two_steps_are_one_of_twice_the_length() -> None:
    """The exact step of pairs of states, with and without force."""
    part = class158_case(1).whole
    (one, held), (two, held_longer) = part.exact_step(5e-6), part.exact_step(1e-5)
    np.testing.assert_allclose(one @ one, two, atol=1e-12 * np.abs(two).max())
    np.testing.assert_allclose(one @ held + held, held_longer, atol=1e-12 * np.abs(held_longer).max())


@pytest.mark.slow
@pytest.mark.parametrize(("case", "tone"), [(1, 272.0), (1, 415.6), (3, 272.0)])
def test_perturbations_grow_in_time_as_the_exponents_say(case: int, tone: float) -> None:
    """A run from the cycle leaves it at the rate of the largest exponent, 3 %: the fit over some e-foldings."""
    cycle = tone_of(case, tone).near(tone)
    judged = cycle.stability
    assert judged is not None
    h = 5e-6
    velocity = fused_run(cycle.balance.model, start_of(cycle.motion), h, 1.2)[:, 0]
    time = h * np.arange(velocity.size)
    side = 2 * np.pi * min(judged.sideband_hz, key=lambda f: abs(f - judged.largest_hz))
    length = round(0.1 / h)
    window = np.hanning(length) / (length / 2)
    level = np.abs(fftconvolve(velocity * np.exp(-1j * side * time), window, "valid")[:: round(0.005 / h)])
    grown = (level > 20 * level[:10].min()) & (level < 0.01)
    assert grown.sum() > 15
    rate = np.polyfit(0.005 * np.flatnonzero(grown), np.log(level[grown]), 1)[0]
    assert rate == pytest.approx(judged.largest.real, rel=0.03)
