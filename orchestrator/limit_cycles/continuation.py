"""Curves of solutions: Newton's method and pseudo-arclength continuation of n equations in n + 1 unknowns."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.floating[Any]]

TOLERANCE = 1e-9
"""Largest scaled residual of a solution."""

STANDING = 1e-6
"""Largest scaled residual that is accepted where it does not fall any more: the law has kinks."""

_SMALLEST_DAMPING = 1 / 16


class Equations(Protocol):
    """What can be solved: n equations in n + 1 scaled unknowns."""

    @property
    def weights(self) -> Real:
        """Weights of the unknowns in the length of the curve."""
        ...

    def residual(self, x: Real) -> Real:
        """Return the n residuals."""
        ...

    def linearise(self, x: Real) -> tuple[Real, Real]:
        """Return the residuals and their Jacobian, (n, n + 1)."""
        ...


@dataclass(frozen=True)
class Solution:
    """What Newton's method came to.

    Attributes
    ----------
    x : the unknowns
    residual : largest scaled residual
    iterations : Newton steps
    jacobian : of the equations at the last step
    """

    x: Real
    residual: float
    iterations: int
    jacobian: Real

    @property
    def solved(self) -> bool:
        """Whether it is a solution."""
        return bool(self.residual < STANDING)


def newton(equations: Equations, x: Real, row: Real, value: float, limit: int = 20) -> Solution:
    """Solve the equations with one more, row . x = value.

    Parameters
    ----------
    x : first guess
    limit : largest number of steps
    """
    residual, jacobian = equations.linearise(x)
    size = _size(residual, float(row @ x) - value)
    for iteration in range(limit):
        if size < TOLERANCE:
            return Solution(x, size, iteration, jacobian)
        step = np.linalg.solve(np.vstack([jacobian, row]), -np.append(residual, float(row @ x) - value))
        trial = x + step
        trial_residual, trial_jacobian = equations.linearise(trial)
        if _size(trial_residual, float(row @ trial) - value) > 0.9 * size:
            damped = _damped(equations, x, step, row, value, size)
            if damped is None:
                return Solution(x, size, iteration + 1, jacobian)
            trial = damped
            trial_residual, trial_jacobian = equations.linearise(trial)
        x, residual, jacobian = trial, trial_residual, trial_jacobian
        size = _size(residual, float(row @ x) - value)
    return Solution(x, size, limit, jacobian)


def _size(residual: Real, further: float) -> float:
    return max(float(np.abs(residual).max()), abs(further))


def _damped(equations: Equations, x: Real, step: Real, row: Real, value: float, size: float) -> Real | None:
    """Return the point after the largest part, at most half, of a step that makes the residual smaller, or None."""
    damping = 0.5
    while damping >= _SMALLEST_DAMPING:
        trial = x + damping * step
        if _size(equations.residual(trial), float(row @ trial) - value) < size * (1 - 0.1 * damping):
            return trial
        damping /= 2
    return None


def tangent(jacobian: Real, weights: Real, before: Real) -> Real:
    """Return the direction of the curve, of length one, that goes on from the direction `before`."""
    row = weights**2 * before
    right = np.zeros(len(before))
    right[-1] = 1.0
    t = np.linalg.solve(np.vstack([jacobian, row]), right)
    return np.asarray(t / np.linalg.norm(weights * t))


@dataclass
class Curve:
    """A walk along a curve of solutions.

    Attributes
    ----------
    x, direction : where it stands and in which direction it goes
    step : length of the next step
    largest, smallest : largest length of a step, and the one below which it goes no further
    newton_steps : largest number for a point
    """

    equations: Equations
    x: Real
    direction: Real
    step: float = 0.1
    largest: float = 0.4
    smallest: float = 1e-4
    newton_steps: int = 10

    def advance(self) -> Solution | None:
        """Go to the next point; None if there is none that can be reached."""
        weights = self.equations.weights
        while self.step >= self.smallest:
            predicted = self.x + self.step * self.direction
            row = weights**2 * self.direction
            found = newton(self.equations, predicted, row, float(row @ predicted), limit=self.newton_steps)
            if found.solved and self._near(found):
                direction = tangent(found.jacobian, weights, self.direction)
                if (weights**2 * direction) @ self.direction > 0.8:
                    self.x, self.direction = found.x, direction
                    if found.iterations <= 3:
                        self.step = min(1.5 * self.step, self.largest)
                    return found
            self.step /= 2
        return None

    def _near(self, found: Solution) -> bool:
        """Whether a point is no more than two steps away."""
        return bool(np.linalg.norm(self.equations.weights * (found.x - self.x)) < 2 * self.step)
