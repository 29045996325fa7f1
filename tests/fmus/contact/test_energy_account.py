"""The account of the energy that holding forces adds: it closes a balance and falls with the square of the step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from coupled import Coupled, modes_of, output, rail_of, wheel
from scipy.integrate import quad

from fmus.contact.law import normal_force
from fmus.wheel.component import wheel as wheel_of

H = 5e-6
NORMAL = 3
"""Place of the contact normal among the local variables of the contact."""


def spring_energy(system: Coupled) -> float:
    """Return the potential of the fluctuating normal force at the place of the wheel, by quadrature."""
    c, p = system.contact, system.contact.parameters
    u = [system.wheel.outputs[output(system.wheel.component, f"u_{d}")] for d in ("lat", "ver")]
    angle = p[c.component.parameter_index["contact_angle"]]
    place = np.sin(angle) * u[0] + np.cos(angle) * u[1]
    load = p[c.component.parameter_index["normal_load"]]
    energy, _ = quad(lambda d: normal_force(p, c.derived, d) - load, 0.0, -place, epsabs=1e-13, epsrel=1e-12)
    return float(energy)


@pytest.mark.parametrize(("jacobi", "linear"), [(False, 0.0), (False, 1.0), (True, 0.0)])
def test_account_closes_the_balance_of_a_wheel_on_a_spring(jacobi: bool, linear: float) -> None:
    """Without friction and damping the energy of wheel and spring changes by what the coupling adds, to rounding.

    A host that steps all at once shows the contact a state that is one step old, so its account is a step behind.
    """
    modes = modes_of(wheel())
    free = wheel_of(replace(modes, zeta=np.zeros_like(modes.zeta)))
    start = np.zeros(len(modes))
    start[:8] = 0.5
    system = Coupled.of(
        2, H, start, jacobi, own_wheel=free, mu0=0.0, linear_spring=linear, host_delay_steps=float(jacobi)
    )
    balance, added = [], []
    for _ in range(400):
        velocity, place = np.split(system.wheel.state, 2)
        energy = 0.5 * np.sum(velocity**2 + (modes.omega * place) ** 2) + spring_energy(system)
        balance.append(energy)
        system.step()
        added.append(system.contact.state[NORMAL])
    change = np.array(balance) - balance[0]
    account = np.array(added) if jacobi else np.concatenate([[0.0], added[:-1]])
    assert np.abs(change).max() > 1e-6 * balance[0]  # there is something to account for
    np.testing.assert_allclose(account, change, atol=1e-10 * balance[0])


def test_added_energy_falls_with_the_square_of_the_step() -> None:
    """Case 1 thrown about in stick and slip for 40 ms; four times less with half the step, 25 % for higher orders."""

    def added(h: float) -> float:
        start = np.zeros(len(modes_of(wheel())) + len(modes_of(rail_of(1))))
        start[:12] = 0.1
        system = Coupled.of(1, h, start)
        total = 0.0
        for _ in range(round(0.04 / h)):
            system.step()
            total = float(np.abs(system.contact.state[:4]).max())
        return total

    coarse, fine = added(8e-6), added(4e-6)
    assert coarse / fine == pytest.approx(4.0, rel=0.25)
