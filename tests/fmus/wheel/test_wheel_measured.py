"""A wheel from measured functions: modes of both families found again, and what cannot be known refused."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from fmus.cases import read_cases
from fmus.interface import DIRECTIONS
from fmus.measured.modal_fit import fit_functions
from fmus.measured.modal_model import Functions
from fmus.modal.modes import Modes, mobility, receptance
from fmus.wheel.class158 import class158
from fmus.wheel.measured import MeasuredWheel, wheel_from_frf
from orchestrator.stability.cases import NONE, case_inputs, find_rail, find_wheel
from orchestrator.stability.poles import exact_poles

TRUTH = Modes(
    omega=2 * np.pi * np.array([10.0, 150.0, 417.1, 417.1, 620.0]),
    zeta=np.array([0.5, 1e-2, 3e-4, 3e-4, 1e-3]),
    shape=np.array(
        [
            [0, 0.03, 0.01, 0], [0, 0.07, -0.009, 0], [0, -0.115, 0.02, 0], [0.02, 0, 0, 0.5], [0, 0.03, 0.05, 0],
        ]
    ),
)  # fmt: skip
"""Suspension, an axle mode, a doublet and a radial mode."""
F = np.arange(100.0, 700.0, 0.25)


def measured(
    modes: Modes, f: NDArray[np.float64], noise: float, directions: tuple[str, ...] = DIRECTIONS
) -> dict[tuple[str, str], NDArray[np.complex128]]:
    """Return the functions that are not zero, with relative noise."""
    H = receptance(2 * np.pi * f, modes)
    random = np.random.default_rng(1)
    functions = {}
    for j, k in itertools.combinations_with_replacement(range(4), 2):
        if H[:, j, k].any() and {DIRECTIONS[j], DIRECTIONS[k]} <= set(directions):
            parts = random.standard_normal((2, f.size))
            functions[DIRECTIONS[j], DIRECTIONS[k]] = H[:, j, k] * (1 + noise / np.sqrt(2) * (parts[0] + 1j * parts[1]))
    return functions


@pytest.fixture(scope="module")
def found() -> MeasuredWheel:
    """Return the wheel of the truth with 1 % of noise."""
    return wheel_from_frf(F, measured(TRUTH, F, 0.01))


def test_modes_of_both_families_are_found_again(found: MeasuredWheel) -> None:
    """Frequencies within 1e-5, damping ratios and amplitudes within 2 %: 1 % of noise, ten lines in each resonance."""
    for i in range(1, 5):
        moving = np.flatnonzero(np.sign(TRUTH.shape[i]))
        same = [k for k in range(len(found.modes)) if abs(found.modes.omega[k] / TRUTH.omega[i] - 1) < 1e-4]
        same = [k for k in same if found.modes.shape[k, moving].any()]
        assert len(same) == 1, TRUTH.omega[i]
        mode = same[0]
        assert found.modes.omega[mode] == pytest.approx(TRUTH.omega[i], rel=1e-4 if TRUTH.zeta[i] > 5e-3 else 1e-5)
        assert found.modes.zeta[mode] == pytest.approx(TRUTH.zeta[i], rel=0.02)
        shape = found.modes.shape[mode] * np.sign(found.modes.shape[mode] @ TRUTH.shape[i])
        np.testing.assert_allclose(shape[moving], TRUTH.shape[i, moving], rtol=0.02)


def test_the_fit_is_nearer_to_the_truth_than_the_data(found: MeasuredWheel) -> None:
    """The median over the lines of each function, all below the noise; the quality of the fit is the noise itself."""
    H, fitted = receptance(2 * np.pi * F, TRUTH), receptance(2 * np.pi * F, found.modes)
    for j, k in ((0, 0), (1, 1), (1, 2), (2, 2), (0, 3), (3, 3)):
        assert np.median(np.abs(fitted[:, j, k] / H[:, j, k] - 1)) < 0.005
    for quality in found.quality.values():
        assert quality["noise"] == pytest.approx(0.01, rel=0.15)
        # the median of the size of one part of complex noise of 1 %: 0.674 * 0.01 / sqrt 2, times 20 / ln 10; a fifth
        # more for the suspension, which is below the band
        assert 0.95 * 0.0414 < quality["median_db"] < 1.25 * 0.0414
    assert found.notes == (
        "no function couples lon and spin with lat and ver: taken as 0, as of an axisymmetric wheel",
    )


def test_a_measured_wheel_is_passive(found: MeasuredWheel) -> None:
    """Re Y is positive semi-definite at all frequencies, far outside the band, too."""
    Y = mobility(2 * np.pi * np.geomspace(0.01, 1e5, 400), found.modes).real
    scale = np.abs(Y).max(axis=(1, 2), keepdims=True)
    assert (np.linalg.eigvalsh(Y / scale) > -1e-12).all()  # rounding


def test_directions_that_were_not_measured_are_rigid() -> None:
    wheel = wheel_from_frf(F, measured(TRUTH, F, 0.0, ("lat",)))
    assert not wheel.modes.shape[:, [0, 2, 3]].any()
    assert wheel.notes == ("not measured, so the wheel is rigid there: lon, ver, spin",)


def test_functions_that_couple_all_directions_split_a_doublet() -> None:
    """With cross functions between the families there is one group of four directions; the doublet is two modes.

    Turned by 0.3 rad about the axle, both of its members move in all directions; their sum of products is what counts.
    """
    shape = TRUTH.shape.copy()
    c, s = np.cos(0.3), np.sin(0.3)
    shape[2], shape[3] = c * TRUTH.shape[2] + s * TRUTH.shape[3], c * TRUTH.shape[3] - s * TRUTH.shape[2]
    shape[[1, 4], 0] = 0.01
    turned = Modes(TRUTH.omega, TRUTH.zeta, shape)
    omega = 2 * np.pi * np.arange(380.0, 450.0, 0.25)
    H = receptance(omega, turned)
    pairs = tuple(itertools.combinations_with_replacement(range(4), 2))
    values = np.array([H[:, j, k] for j, k in pairs])
    fit = fit_functions(Functions(omega, pairs, values, np.full(values.shape, 0.01)))
    near = np.abs(fit.omega / TRUTH.omega[2] - 1) < 1e-4
    assert near.sum() == 2
    wanted = turned.shape[2:4].T @ turned.shape[2:4]
    np.testing.assert_allclose(fit.shape[near].T @ fit.shape[near], wanted, atol=1e-2 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        ([("lat", "lat"), ("ver", "ver")], "lat due to ver is missing; it has the sign between lat and ver"),
        ([("lat", "lat"), ("lat", "ver")], "ver has no point function; must be measured, too"),
        ([("lat", "lat"), ("lat", "ver"), ("ver", "lat"), ("ver", "ver")], "a second function of ver due to lat"),
    ],
)
def test_what_would_have_to_be_guessed_is_refused(pairs: list[tuple[str, str]], message: str) -> None:
    values = np.ones(F.size, dtype=complex)
    with pytest.raises(ValueError, match=message):
        wheel_from_frf(F, dict.fromkeys(pairs, values))


@pytest.mark.slow
def test_the_wheel_of_the_cases_survives_its_own_measurement() -> None:
    """Functions of class158 from 20 to 6600 Hz on lines of 0.5 Hz with 1 % of noise, in all four cases below 5 kHz.

    Every growth rate above -25 1/s within 5 % or 0.2 1/s, but one of -0.24 1/s at 167.8 Hz in Case 2, which comes out
    as +0.09. Faster decays belong to modes that overlap with others; at most three of some eighty in a case are off by
    more.
    """
    f = np.arange(20.0, 6600.1, 0.5)
    found = wheel_from_frf(f, measured(class158().modes, f, 0.01))
    wheel, rail = find_wheel("class158"), find_rail("modal")
    for case in read_cases():
        if case.wheel != "wheel":  # made for another wheel, whose contact spring is another
            continue
        structures, contact = case_inputs(case, wheel, rail)
        assert wheel.modes is not None
        rail_modes = NONE if structures.rail_modes is None else structures.rail_modes
        true = exact_poles(wheel.modes, rail_modes, contact).below(5000.0)
        own = exact_poles(found.modes, rail_modes, contact)
        off = []
        for frequency, growth in zip(true.frequency_hz, true.growth_rate, strict=True):
            near = np.abs(own.frequency_hz / frequency - 1) < 3e-3
            error = np.abs(own.growth_rate[near] - growth).min(initial=np.inf)
            if frequency > 20 and error > max(0.2, 0.05 * abs(growth)):
                off.append((round(float(frequency), 1), round(float(growth), 1)))
        known = [(167.8, -0.2)] if case.name == "case2" else []
        assert all(growth < -25 for frequency, growth in off if (frequency, growth) not in known), (case.name, off)
        assert len(off) <= 3 + len(known), (case.name, off)
