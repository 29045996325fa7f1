"""From a pole to its cycles: the growth rate at an amplitude, followed from zero; its zeros are the cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from threadpoolctl import threadpool_limits

from ..stability.poles import NORMAL, TANGENTIAL, OpenSystem, closed_loop_matrix
from .balance import AMPLITUDE_SCALE, Balance, State, Truncation, reference_of
from .continuation import Curve, Solution, newton, tangent
from .model import SquealModel

Real = NDArray[np.floating[Any]]
Complex = NDArray[np.complexfloating[Any, Any]]

START = 0.004
"""Amplitude at which a curve starts [m/s]: a fiftieth of the sliding velocity of the cases."""

LARGEST = 0.6
"""Amplitude up to which a curve is followed [m/s]."""

_LARGEST_STEP = 0.35

LOWEST = -40.0
"""Growth rate down to which a curve is followed [1/s]."""

_SLOWEST = 1e-6


@dataclass(frozen=True)
class Effort:
    """How much is done for a curve until it is given up.

    Attributes
    ----------
    points : largest number of points
    newton_steps : largest number of Newton's method for a point
    smallest : smallest scaled distance of points
    """

    points: int = 200
    newton_steps: int = 10
    smallest: float = 1e-4


EFFORT = Effort()
"""What is enough for all curves of the cases."""


@dataclass(frozen=True)
class Pole:
    """A pole of the coupled system and how the contact moves there.

    Attributes
    ----------
    value : [1/s]
    motion : (4,) relative velocities and the normal displacement, contact axes
    forces : (4,) contact forces
    """

    value: complex
    motion: Complex
    forces: Complex

    @property
    def frequency_hz(self) -> float:
        """Frequency [Hz]."""
        return self.value.imag / (2 * np.pi)

    @property
    def growth_rate(self) -> float:
        """Growth rate [1/s]."""
        return self.value.real


def find_poles(model: SquealModel) -> list[Pole]:
    """Return the poles that move the contact, sorted by frequency."""
    linear, matrix = model.linear, closed_loop_matrix(model.wheel, model.rail, model.linear)
    open_system = OpenSystem.of(model.wheel, model.rail, linear.turn)
    count, part = connected_components(matrix != 0, directed=False)
    poles: list[Pole] = []
    for number in range(count):
        places = np.flatnonzero(part == number)
        with threadpool_limits(1, "blas"):  # matrices of this size are slower on several threads
            values, vectors = np.linalg.eig(matrix[np.ix_(places, places)])
        kept = np.flatnonzero(values.imag > _SLOWEST)
        motion = open_system.V[:, places] @ vectors[:, kept]
        motion[NORMAL] = open_system.U[NORMAL, places] @ vectors[:, kept]
        forces = np.zeros_like(motion)
        forces[NORMAL] = -linear.stiffness * motion[NORMAL]
        forces[TANGENTIAL] = linear.H1 @ motion[TANGENTIAL] + np.outer(linear.h2, forces[NORMAL])
        poles += [Pole(complex(v), motion[:, k], forces[:, k]) for k, v in enumerate(values[kept])]
    moving = (p for p in poles if np.abs(p.motion[TANGENTIAL]).max() > 0)
    return sorted(moving, key=lambda p: p.frequency_hz)


@dataclass(frozen=True)
class Trace:
    """The curve of a pole.

    Attributes
    ----------
    pole : where it starts
    balance : the equations that its points solve
    amplitude, sigma, frequency_hz : (m,) along the curve; sigma is the growth rate at that amplitude
    crossings : solutions with sigma = 0, at the same truncation
    ended : why it ends where it does, and what was tried, in words
    complete : whether it was followed as far as it should be
    lost : zeros that were passed and not solved, one sentence each
    """

    pole: Pole
    balance: Balance
    amplitude: Real
    sigma: Real
    frequency_hz: Real
    crossings: tuple[State, ...]
    ended: str
    complete: bool
    lost: tuple[str, ...] = ()


def equations_of(model: SquealModel, pole: Pole, truncation: Truncation) -> Balance:
    """Return the equations of the cycles of a pole, with sigma free."""
    return Balance(model, truncation, reference_of(model.active, pole.motion), omega_scale=0.01 * pole.value.imag)


def start_of(balance: Balance, pole: Pole, newton_steps: int = 20) -> Solution:
    """Return the motion at the small amplitude `START` beside a pole."""
    H = balance.truncation.harmonics
    y = pole.motion[balance.reference] * balance.reference_factor
    forces = np.zeros((H + 1, len(balance.active)), complex)
    forces[1] = pole.forces[list(balance.active)] * START / (2 * y)
    x = balance.pack(State(forces, pole.value.imag, START, pole.growth_rate))
    row = np.zeros(balance.size)
    row[-2] = 1.0
    return newton(balance, x, row, float(x[-2]), newton_steps)


def trace(model: SquealModel, pole: Pole, truncation: Truncation, effort: Effort = EFFORT) -> Trace:
    """Follow the curve of a pole from small amplitude on.

    The curve ends at the amplitude `LARGEST`, where it comes back to zero or to itself, or where the growth rate has
    fallen far.
    """
    balance = equations_of(model, pole, truncation)
    start = start_of(balance, pole, 2 * effort.newton_steps)
    none = np.zeros(0)
    if not start.solved:
        words = f"does not start: residual {start.residual:.1e} after {start.iterations} Newton steps at {START:g} m/s"
        return Trace(pole, balance, none, none, none, (), words, complete=False)
    up = np.zeros(balance.size)
    up[-2] = 1.0
    curve = Curve(
        balance, start.x, tangent(start.jacobian, balance.weights, up), largest=_LARGEST_STEP,
        smallest=effort.smallest, newton_steps=effort.newton_steps,
    )  # fmt: skip
    points, crossings, lost = [start.x], list[State](), list[str]()
    ended = "that are as many as are made"
    lowest = min(LOWEST, pole.growth_rate + LOWEST)
    complete = False
    while len(points) < effort.points and not complete:
        found = curve.advance()
        if found is None:
            ended = (
                f"with {truncation.harmonics} harmonics and {effort.newton_steps} Newton steps for a point "
                f"none beyond is found at distances down to {effort.smallest:g}"
            )
            break
        points.append(found.x)
        crossing = _crossing(balance, points[-2], points[-1]) if points[-2][-1] * found.x[-1] <= 0 else None
        if isinstance(crossing, str):
            lost.append(crossing)
        closed = isinstance(crossing, State) and any(_same(crossing, c) for c in crossings)
        if isinstance(crossing, State) and not closed:
            crossings.append(crossing)
        state = balance.unpack(found.x)
        complete = closed or not 0 < state.amplitude < LARGEST or state.free < lowest
    x = np.array(points)[:, -3:] * (balance.omega_scale / (2 * np.pi), AMPLITUDE_SCALE, balance.free_scale)
    ended = (
        f"was followed over {len(points)} points to {x[-1, 1]:.3f} m/s, where the growth rate is {x[-1, 2]:.3g} 1/s"
        + ("" if complete else f"; {ended}")
    )
    return Trace(pole, balance, x[:, 1], x[:, 2], x[:, 0], tuple(crossings), ended, complete, tuple(lost))


def _crossing(balance: Balance, before: Real, after: Real) -> State | str:
    """Return the solution with sigma = 0 between two points, or what Newton's method came to instead."""
    part = before[-1] / (before[-1] - after[-1])
    guess = before + part * (after - before)
    guess[-1] = 0.0
    row = np.zeros(balance.size)
    row[-1] = 1.0
    found = newton(balance, guess, row, 0.0, limit=30)
    state, first = balance.unpack(found.x), balance.unpack(guess)
    if not found.solved:
        words = f"Newton's method ends at a residual of {found.residual:.1e} after {found.iterations} steps"
    elif abs(state.amplitude - first.amplitude) > 0.3 * first.amplitude + 0.005:
        words = f"Newton's method goes to {state.amplitude:.3f} m/s"
    else:
        return state
    return f"the cycle near {first.frequency_hz:.1f} Hz, {first.amplitude:.3f} m/s, is not solved: {words}"


def _same(a: State, b: State) -> bool:
    return abs(a.frequency_hz - b.frequency_hz) < 0.05 and abs(a.amplitude - b.amplitude) < 2e-3
