"""What a cycle is like: velocities of wheel and rail, contact force, stick, sound. A solution in, numbers out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.contact.layout import OUT
from fmus.modal.modes import Modes

from ..signals.limit_cycle import STICK
from ..stability.poles import NORMAL
from .balance import Balance, State
from .model import SquealModel
from .sampling import sample_law, sample_monitors

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

SAMPLES = 2048
"""Samples of a period from which extreme values and shares of time are taken."""


@dataclass(frozen=True)
class Motion:
    """The lines of a cycle, 0 to H.

    Attributes
    ----------
    omega : angular frequency of line 1 [rad/s]
    forces : (H + 1, 4) on the wheel, contact axes [N, N m]
    relative : (H + 1, 4) relative velocities lon, lat, displacement normal, velocity spin, contact axes
    states : (H + 1, n, 2) of `model.whole`
    wheel_modal : (H + 1, n) modal displacements of the wheel [kg^1/2 m]; none where it shows no modes
    wheel, rail : (H + 1, 4) velocities in track axes lon, lat, ver, spin [m/s, rad/s]
    """

    omega: float
    forces: Complex
    relative: Complex
    states: Complex
    wheel_modal: Complex
    wheel: Complex
    rail: Complex


def motion_of(balance: Balance, state: State) -> Motion:
    """Return all lines of a cycle."""
    model = balance.model_of(state)
    forces = np.zeros((len(state.forces), 4), complex)
    forces[:, list(balance.active)] = state.forces
    s = 1j * state.omega * np.arange(len(forces))
    states = model.whole.states(s, forces)
    T, _ = model.whole.receptance(s)
    relative: Complex = (T @ forces[:, :, None])[:, :, 0] * np.where(np.arange(4) == NORMAL, 1.0, s[:, None])
    on_wheel = forces @ model.turn  # track axes
    wheel, rail = (s[:, None] * (part.receptance(s)[0] @ on_wheel[:, :, None])[:, :, 0] for part in model.parts)
    modes = len(model.wheel) if isinstance(model.wheel, Modes) else 0
    return Motion(state.omega, forces, relative, states, states[:, :modes, 1], wheel, -rail)


def rms(lines: Complex) -> Real:
    """Return the rms of the fluctuation with some lines, by column."""
    return np.asarray(np.sqrt(2 * np.sum(np.abs(lines[1:]) ** 2, axis=0)))


def over_a_period(lines: Complex, samples: int = SAMPLES) -> Real:
    """Return the samples of a period, (N, ...)."""
    return np.asarray(np.fft.irfft(lines, samples, axis=0) * samples)


def states_at_start(motion: Motion) -> Real:
    """Return the states of `model.whole` at the start of the period, (n, 2)."""
    return np.asarray((motion.states[0] + 2 * motion.states[1:].sum(axis=0)).real)


@dataclass(frozen=True)
class Contact:
    """The contact over a period.

    Attributes
    ----------
    time : (N,) [s]
    monitors : (N, outputs) what the contact's outputs are
    stick : part of the period in which the creep force is below 95 % of the friction limit
    lost : part of the period without contact
    """

    time: Real
    monitors: Real
    stick: float
    lost: float

    def of(self, name: str) -> Real:
        """Return one output over the period."""
        return np.asarray(self.monitors[:, getattr(OUT, name)])


def contact_over_a_period(model: SquealModel, motion: Motion) -> Contact:
    """Return what the contact does."""
    monitors = np.zeros((SAMPLES, len(OUT)))
    instance = model.instance
    relative, forces = over_a_period(motion.relative), np.empty((SAMPLES, 4))
    sample_law(instance.parameters, instance.derived, np.arange(4), relative, forces, np.empty((0, 4, 4)))
    sample_monitors(instance.parameters, instance.derived, relative, forces, monitors)
    time = np.arange(SAMPLES) / SAMPLES * 2 * np.pi / motion.omega
    normal = monitors[:, OUT.normal_force]
    creep = np.hypot(monitors[:, OUT.tangential_force_lon], monitors[:, OUT.tangential_force_lat])
    limit = monitors[:, OUT.friction_coefficient] * normal
    stick = (normal > 0) & (creep < STICK * limit)
    return Contact(time, monitors, float(stick.mean()), float((normal <= 0).mean()))
