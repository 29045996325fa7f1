"""Mobilities measured on FMUs through FMI against the matrices of the modal structures."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from coupled import modes_of
from numpy.typing import NDArray
from scipy.linalg import expm

from fmus.interface import DEFAULT_STEP
from fmus.modal.modes import Modes, mobility
from fmus.rail.component import rail
from fmus.wheel.class158 import identified_stiffness
from fmus.wheel.component import wheel
from orchestrator.errors import InputError
from orchestrator.fmi.instance import open_fmu
from orchestrator.probing.response import measure
from orchestrator.stability.analysis import REPORTED_BELOW_HZ, Structures
from orchestrator.stability.cases import find_stability
from orchestrator.stability.eigenloci import Crossing, Eigenloci, crossings, eigenloci, encirclements
from orchestrator.stability.loop import Loop, linear_contact, of_modes

Complex = NDArray[np.complex128]

MODES = {"wheel": modes_of(wheel()), "rail": modes_of(rail())}


def sampled(modes: Modes, step: float, omega: NDArray[np.float64]) -> Complex:
    """Return C (z - Phi)^-1 Gamma of the modes with the forces held over a step."""
    z = np.exp(1j * omega * step)
    out = np.zeros((omega.size, 4, 4), dtype=complex)
    for w, zeta, shape in zip(modes.omega, modes.zeta, modes.shape, strict=True):
        block = expm(step * np.array([[-2 * zeta * w, -(w**2), 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
        (a, b), (c, d) = block[:2, :2]
        response = ((z - d) * block[0, 2] + b * block[1, 2]) / ((z - a) * (z - d) - b * c)
        out += response[:, None, None] * np.outer(shape, shape)
    return out


def scaled_error(got: Complex, wanted: Complex) -> float:
    """Return the largest error, each entry relative to the two point mobilities it lies between."""
    point = np.sqrt(np.abs(np.einsum("kii->ki", wanted)))
    return float((np.abs(got - wanted) / (point[:, :, None] * point[:, None, :])).max())


@pytest.mark.parametrize("name", MODES)
def test_measured_mobility_is_the_sampled_one(name: str, built: Path) -> None:
    """The same to 1e-6 from 20 Hz to 5 kHz and on every resonance of the wheel; the rest is rounding in the fit."""
    modes = MODES[name]
    own = modes.omega[(modes.zeta < 0.1) & (modes.omega < 2 * np.pi * 5000)]
    omega = np.unique(np.concatenate([2 * np.pi * np.geomspace(20, 5000, 200), own, 1.0001 * own]))
    response = measure(open_fmu(built / f"{name}.fmu"), {}, DEFAULT_STEP)
    assert scaled_error(response.sampled_mobility(omega), sampled(modes, DEFAULT_STEP, omega)) < 1e-6


@pytest.mark.parametrize(("advance", "order"), [(0.0, 1.0), (0.5, 2.0)])
def test_sampled_mobility_differs_from_the_continuous_one_by_first_order(advance: float, order: float) -> None:
    """Half the step, half the difference; with the hold's half step taken out, a quarter: order +- 0.1."""
    omega = 2 * np.pi * np.geomspace(100, 2000, 30)
    wanted = mobility(omega, MODES["wheel"])
    errors = []
    for step in (2e-6, 1e-6, 0.5e-6):
        turned = np.exp(1j * advance * omega * step)[:, None, None]
        errors.append(np.abs(sampled(MODES["wheel"], step, omega) * turned - wanted).max())
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(observed, order, atol=0.1)


def test_fmu_without_the_ports_of_a_structure_is_refused(built: Path) -> None:
    with pytest.raises(InputError, match="has no variable 'v_lon', so its mobility cannot be measured"):
        measure(open_fmu(built / "contact.fmu"), {}, DEFAULT_STEP)


@pytest.mark.slow
def test_stability_from_fmus_alone_is_that_of_their_modes(built: Path) -> None:
    """Case 1 with both structures measured: crossings to 0.2 % in gain, what the hold leaves to second order."""
    measured = find_stability("case1", str(built / "rail.fmu"), str(built / "wheel.fmu"))
    known = Structures(of_modes(MODES["wheel"]), of_modes(MODES["rail"]), MODES["wheel"], MODES["rail"])
    result = find_crossings(known)
    assert measured.unstable_pairs == round(float(encirclements(result[0]).sum()))
    gains = [i.crossing.gain for i in measured.instabilities]
    np.testing.assert_allclose(gains, [c.gain for c in result[1]], rtol=2e-3)


def find_crossings(structures: Structures) -> tuple[Eigenloci, list[Crossing]]:
    """Return eigenloci and crossings below 4.5 kHz of modal structures on the contact of Case 1."""
    law = linear_contact({"hertz_stiffness": identified_stiffness()})
    loop = Loop(structures.wheel, structures.rail, law)
    loci = eigenloci(loop.open_loop, structures.frequencies())
    return loci, [c for c in crossings(loop.open_loop, loci) if c.frequency_hz < REPORTED_BELOW_HZ]
