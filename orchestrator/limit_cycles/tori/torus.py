"""Two tones at once and their combinations: a solution in, frequencies, velocities, forces and lines out."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.interface import DIRECTIONS
from fmus.modal.modes import Modes

from ..level import Radiator
from .balance import TwoToneBalance, TwoTones

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

TOLD_DB = -30.0
"""Level, against the strongest line, down to which lines are told [dB]."""


@dataclass(frozen=True)
class Line:
    """A line of the wheel's lateral velocity: k1 and k2, [Hz], amplitude [m/s], level against the strongest [dB]."""

    numbers: tuple[int, int]
    frequency_hz: float
    amplitude: float
    level_db: float


@dataclass(frozen=True)
class Torus:
    """Two tones at once, with their combinations.

    Attributes
    ----------
    balance, state : equations and solution
    residual : largest scaled residual of the equations
    rms_change : relative change of the rms velocity when there were more lines the last time
    """

    balance: TwoToneBalance
    state: TwoTones
    residual: float
    rms_change: float

    @property
    def frequencies_hz(self) -> tuple[float, float]:
        """Both frequencies [Hz]."""
        w1, w2 = self.state.omega
        return w1 / (2 * np.pi), w2 / (2 * np.pi)

    @cached_property
    def _on_wheel(self) -> Complex:
        """Contact forces on the wheel at the lines, track axes, (M, 4)."""
        model = self.balance.model
        forces = np.zeros((len(self.state.forces), 4), complex)
        forces[:, list(model.active)] = self.state.forces
        return np.asarray(forces @ model.turn)

    def _velocity(self, part: int) -> Complex:
        """Return the velocity lines of wheel (0) or rail (1), track axes, (M, 4)."""
        s = self.balance.frequencies(self.state)
        T, _ = self.balance.model.parts[part].receptance(s)
        return np.asarray(s[:, None] * (T @ self._on_wheel[:, :, None])[:, :, 0])

    @property
    def wheel_velocity_rms(self) -> dict[str, float]:
        """Rms velocity of the wheel by direction [m/s, rad/s]."""
        return _rms(self._velocity(0))

    @property
    def rail_velocity_rms(self) -> dict[str, float]:
        """Rms velocity of the rail by direction [m/s, rad/s]."""
        return _rms(self._velocity(1))

    @property
    def normal_force(self) -> tuple[float, float]:
        """Smallest and largest normal force on the grid of both phases [N]."""
        force = self.balance.normal_force(self.state)
        return float(force.min()), float(force.max())

    def level_dba(self, radiator: Radiator) -> float:
        """Return the level at 7.5 m [dB(A)]."""
        model = self.balance.model
        modes = len(model.wheel) if isinstance(model.wheel, Modes) else 0
        s = self.balance.frequencies(self.state)
        forces = self._on_wheel @ model.turn.T  # contact axes
        displacement = model.whole.states(s, forces)[:, :modes, 1]
        return radiator.level_of_lines(np.abs(s[1:].imag), displacement[1:])

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Lateral lines of the wheel, strongest first, down to `TOLD_DB`."""
        amplitude = 2 * np.abs(self._velocity(0)[1:, 1])
        level = 20 * np.log10(np.maximum(amplitude, 1e-300) / amplitude.max())
        frequency = np.abs(self.balance.frequencies(self.state)[1:].imag) / (2 * np.pi)
        numbers = self.balance.lines.numbers[1:]
        return tuple(
            Line((int(numbers[k, 0]), int(numbers[k, 1])), float(frequency[k]), float(amplitude[k]), float(level[k]))
            for k in np.argsort(-amplitude)
            if level[k] >= TOLD_DB
        )

    @property
    def words(self) -> str:
        """Its strongest lines in words."""
        return " + ".join(f"{line.frequency_hz:.0f}" for line in self.lines[:3]) + " Hz"


def _rms(lines: Complex) -> dict[str, float]:
    return dict(zip(DIRECTIONS, np.sqrt(2 * np.sum(np.abs(lines[1:]) ** 2, axis=0)).tolist(), strict=True))
