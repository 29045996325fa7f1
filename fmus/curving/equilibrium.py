"""Newton's method and continuation for the twelve equations of `balance`. Kernels."""

import math

from ..compile import kernel
from .balance import add_up, put_residual, unscale
from .layout import PER_AXLE, D, N, X
from .parameters import P
from .wheel_rail import put_geometry, put_wheels

TOLERANCE = 1e-12
"""Largest residual of a solution, relative to axle load and lever."""

ROUNDING = 1e-9
"""Residual below which a step that gains nothing ends the iteration: stiff springs leave that much rounding."""

MOST_ITERATIONS = 25
MOST_HALVINGS = 8

FIRST_STEP = 5e-5
"""First step of the curvature on the way from straight track [1/m]."""

SMALLEST_PART = 1e-5
"""Part of the way below which a step that still fails is given up."""

_DIFFERENCE = 1e-6
"""Step of the difference quotients, in scaled unknowns."""


@kernel
def start_straight(unknowns):  # type: ignore[no-untyped-def]
    """Put the solution on straight track into the unknowns: half the load on each wheel."""
    for i in range(N):
        unknowns[i] = 0.0
    for i in range(2):
        axle = i * PER_AXLE
        unknowns[axle + X.load_left] = 0.5
        unknowns[axle + X.load_right] = 0.5


@kernel
def _largest(derived, at):  # type: ignore[no-untyped-def]
    """Return the largest residual; infinity where one is no number."""
    worst = 0.0
    for i in range(N):
        size = abs(derived[at + i])
        if not size < math.inf:
            return math.inf
        worst = max(worst, size)
    return worst


@kernel
def eliminate(derived, at, n):  # type: ignore[no-untyped-def]
    """Solve n linear equations, rows of n coefficients and a right side from `at`, by elimination with pivots.

    The solution takes the place of the right sides. Return whether there is one.
    """
    width = n + 1
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(derived[at + i * width + k]) > abs(derived[at + pivot * width + k]):
                pivot = i
        if derived[at + pivot * width + k] == 0.0:
            return False
        for j in range(k, width):
            kept = derived[at + k * width + j]
            derived[at + k * width + j] = derived[at + pivot * width + j]
            derived[at + pivot * width + j] = kept
        for i in range(k + 1, n):
            factor = derived[at + i * width + k] / derived[at + k * width + k]
            for j in range(k + 1, width):
                derived[at + i * width + j] -= factor * derived[at + k * width + j]
    for k in range(n - 1, -1, -1):
        total = derived[at + k * width + n]
        for j in range(k + 1, n):
            total -= derived[at + k * width + j] * derived[at + j * width + n]
        derived[at + k * width + n] = total / derived[at + k * width + k]
    return True


@kernel
def _find_direction(parameters, derived, unknowns, curvature, load, mu):  # type: ignore[no-untyped-def]
    """Put Newton's step into the last column of the Jacobian's block; return whether there is one.

    An unknown of an axle changes the wheels of that axle only, and their geometry only if it is the shift; those of the
    frame change no wheel.
    """
    width = N + 1
    unscale(parameters, derived, unknowns, D.trial)
    for j in range(N):
        axle = 0 if j < PER_AXLE else 1 if j < 2 * PER_AXLE else 2
        x = D.trial + axle * PER_AXLE
        unit = 1e-3 if axle > 1 or j - axle * PER_AXLE < X.load_left else parameters[P.axle_load]
        kept = derived[D.trial + j]
        derived[D.trial + j] = kept + _DIFFERENCE * unit
        shifts = axle < 2 and j == axle * PER_AXLE
        if shifts:
            put_geometry(parameters, derived, axle, x)
        if axle < 2:
            put_wheels(parameters, derived, axle, x, curvature, mu)
        add_up(parameters, derived, curvature, load, D.residual_trial)
        derived[D.trial + j] = kept
        if shifts:
            put_geometry(parameters, derived, axle, x)
        if axle < 2 and j == axle * PER_AXLE + X.load_right:
            put_wheels(parameters, derived, axle, x, curvature, mu)
        for i in range(N):
            change = derived[D.residual_trial + i] - derived[D.residual + i]
            derived[D.jacobian + i * width + j] = change / _DIFFERENCE
    for i in range(N):
        derived[D.jacobian + i * width + N] = -derived[D.residual + i]
    return eliminate(derived, D.jacobian, N)


@kernel
def newton(parameters, derived, unknowns, curvature, load, mu):  # type: ignore[no-untyped-def]
    """Solve from the unknowns given; return iterations (-1: none found) and the largest residual.

    The unknowns become the solution; without one they are of no use.
    """
    put_residual(parameters, derived, unknowns, curvature, load, mu, D.residual)
    worst = _largest(derived, D.residual)
    for iteration in range(MOST_ITERATIONS):
        if worst < TOLERANCE:
            return iteration, worst
        if not worst < math.inf:
            return -1, worst
        if not _find_direction(parameters, derived, unknowns, curvature, load, mu):
            return -1, worst
        width = N + 1
        part = 1.0
        before = worst
        for halving in range(MOST_HALVINGS + 1):
            for i in range(N):
                unknowns[i] += part * derived[D.jacobian + i * width + N]
            put_residual(parameters, derived, unknowns, curvature, load, mu, D.residual_trial)
            worst = _largest(derived, D.residual_trial)
            if worst < before or halving == MOST_HALVINGS:
                break
            for i in range(N):
                unknowns[i] -= part * derived[D.jacobian + i * width + N]
            part *= 0.5
        if not worst < before:
            return (iteration + 1, worst) if worst < ROUNDING else (-1, worst)
        for i in range(N):
            derived[D.residual + i] = derived[D.residual_trial + i]
    return -1, worst


@kernel
def _carries(unknowns):  # type: ignore[no-untyped-def]
    """Return whether every wheel is pressed onto its rail."""
    for i in range(2):
        axle = i * PER_AXLE
        if unknowns[axle + X.load_left] <= 0.0 or unknowns[axle + X.load_right] <= 0.0:
            return False
    return True


@kernel
def follow(parameters, derived, unknowns, last, wanted, first):  # type: ignore[no-untyped-def]
    """Follow the solution from one curve to another; return iterations, residual and the part reached.

    Without a solution at the end, iterations are -1, or -2 if it is a wheel that lifts.

    Parameters
    ----------
    unknowns : (12,) solution at `last`; that at `wanted` takes its place, or the last one that was found
    last, wanted : curvature [1/m], `lateral_load` [N] and friction coefficient
    first : first part of the way to be tried, 0 to 1
    """
    reached = 0.0
    part = first
    total = 0
    residual = 0.0
    for i in range(N):
        derived[D.kept + i] = unknowns[i]
    while reached < 1.0:
        t = min(reached + part, 1.0)
        curvature = last[0] + t * (wanted[0] - last[0])
        load = last[1] + t * (wanted[1] - last[1])
        mu = last[2] + t * (wanted[2] - last[2])
        iterations, residual = newton(parameters, derived, unknowns, curvature, load, mu)
        lifts = iterations >= 0 and not _carries(unknowns)
        if iterations >= 0 and not lifts:
            for i in range(N):
                derived[D.kept + i] = unknowns[i]
            total += iterations
            reached = t
            part *= 1.5 if iterations < 6 else 1.0
        else:
            for i in range(N):
                unknowns[i] = derived[D.kept + i]
            part *= 0.5
            if part < SMALLEST_PART:
                return -2 if lifts else -1, residual, reached
    return total, residual, 1.0
