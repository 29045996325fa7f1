"""The kernels of the component that both wheel and rail are: forces in, velocities and displacements out.

Each mode steps exactly, with the force held (matrix exponential of its 2 x 2 block).
"""

from __future__ import annotations

import math

from ..compile import kernel
from .layout import N_BLOCKS, N_MOBILITIES

# Parameters are blocks of n values each, so that n follows from the length of the array.


@kernel
def _impulse_response(omega, zeta, h):  # type: ignore[no-untyped-def]
    """Return g, g' and the integral of g at time h, where g'' + 2 zeta omega g' + omega^2 g = delta(t).

    Three branches, none of which subtracts nearly equal numbers: power series, under-damped, over-damped.
    """
    wh = omega * h
    decay = zeta * wh
    if wh + 2.0 * decay < 0.05:  # terms c of the series of g, with t^k in them; 10 reach rounding
        before, c = 0.0, h
        g, slope, integral = c, 1.0, 0.5 * h * c
        for k in range(2, 12):
            before, c = c, -(2.0 * decay * c / k + wh * wh * before / (k * (k - 1)))
            g += c
            slope += k * c / h
            integral += h * c / (k + 1)
        return g, slope, integral
    if zeta < 1.0:
        b = wh * math.sqrt(1.0 - zeta * zeta)
        sinc = math.sin(b) / b if b > 1e-4 else 1.0 - b * b / 6.0
        e = math.exp(-decay)
        half = math.sin(0.5 * b)
        g = e * h * sinc
        slope = e * (math.cos(b) - decay * sinc)
        return g, slope, (e * (2.0 * half * half - decay * sinc) - math.expm1(-decay)) / (omega * omega)
    b = wh * math.sqrt(zeta * zeta - 1.0)
    fast = -(decay + b)
    slow = wh * wh / fast
    ratio = -math.expm1(-2.0 * b) / (2.0 * b) if b > 1e-8 else 1.0 - b
    g = h * math.exp(slow) * ratio
    slope = slow * g / h + math.exp(fast)
    return g, slope, (fast * g / h - math.expm1(fast)) / (omega * omega)


@kernel
def tabulate(parameters, derived, h):  # type: ignore[no-untyped-def]
    """Fill `derived`: interface mobility (10), step (1), six tables of the exact step of each mode."""
    n = (parameters.size - 1) // N_BLOCKS
    t = N_MOBILITIES + 1
    derived[N_MOBILITIES] = h
    for p in range(N_MOBILITIES):
        derived[p] = 0.0
    for i in range(n):
        omega = 2.0 * math.pi * parameters[i]
        zeta = parameters[n + i]
        g, slope, integral = _impulse_response(omega, zeta, h)
        derived[t + i] = slope  # velocity per velocity
        derived[t + n + i] = -omega * omega * g  # velocity per displacement
        derived[t + 2 * n + i] = g  # velocity per force
        derived[t + 3 * n + i] = g  # displacement per velocity
        derived[t + 4 * n + i] = slope + 2.0 * zeta * omega * g  # displacement per displacement
        derived[t + 5 * n + i] = integral  # displacement per force
        p = 0
        for row in range(4):
            for column in range(row, 4):
                derived[p] += parameters[(2 + row) * n + i] * parameters[(2 + column) * n + i] * g
                p += 1


@kernel
def _observe(parameters, state, outputs):  # type: ignore[no-untyped-def]
    """Sum the modal velocities and displacements into the velocities and displacements of the contact point."""
    n = (parameters.size - 1) // N_BLOCKS
    v0 = v1 = v2 = v3 = u0 = u1 = u2 = u3 = 0.0
    for i in range(n):
        v = state[i]
        u = state[n + i]
        lon = parameters[2 * n + i]
        lat = parameters[3 * n + i]
        ver = parameters[4 * n + i]
        spin = parameters[5 * n + i]
        v0 += lon * v
        v1 += lat * v
        v2 += ver * v
        v3 += spin * v
        u0 += lon * u
        u1 += lat * u
        u2 += ver * u
        u3 += spin * u
    outputs[0] = v0
    outputs[1] = v1
    outputs[2] = v2
    outputs[3] = v3
    outputs[4] = u0
    outputs[5] = u1
    outputs[6] = u2
    outputs[7] = u3


@kernel
def initialise(parameters, derived, state, inputs, outputs):  # type: ignore[no-untyped-def]
    """Start with the given modal velocities and displacements."""
    n = (parameters.size - 1) // N_BLOCKS
    tabulate(parameters, derived, parameters[N_BLOCKS * n])
    for i in range(n):
        state[i] = parameters[6 * n + i]
        state[n + i] = parameters[7 * n + i]
    _observe(parameters, state, outputs)


@kernel
def do_step(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Advance each mode exactly with the forces held over the step (matrix exponential of its 2 x 2 block)."""
    n = (parameters.size - 1) // N_BLOCKS
    if derived[N_MOBILITIES] != h:
        tabulate(parameters, derived, h)
    t = N_MOBILITIES + 1
    f0 = inputs[0]
    f1 = inputs[1]
    f2 = inputs[2]
    f3 = inputs[3]
    for i in range(n):
        force = (
            parameters[2 * n + i] * f0
            + parameters[3 * n + i] * f1
            + parameters[4 * n + i] * f2
            + parameters[5 * n + i] * f3
        )
        v = state[i]
        u = state[n + i]
        state[i] = derived[t + i] * v + derived[t + n + i] * u + derived[t + 2 * n + i] * force
        state[n + i] = derived[t + 3 * n + i] * v + derived[t + 4 * n + i] * u + derived[t + 5 * n + i] * force
    _observe(parameters, state, outputs)


@kernel
def differentiate(parameters, derived, state, inputs, outputs, h, seed, sensitivity):  # type: ignore[no-untyped-def]
    """Differentiate the outputs at the end of the last step, of size h (0: none yet), along the held forces `seed`.

    The step is linear and exact, and so is this: velocities change by the interface mobility, displacements by the
    integral of the impulse response.
    """
    n = (parameters.size - 1) // N_BLOCKS
    for row in range(8):
        sensitivity[row] = 0.0
    if h <= 0.0:  # no force has acted yet
        return
    p = 0
    for row in range(4):
        sensitivity[row] += derived[p] * seed[row]
        p += 1
        for column in range(row + 1, 4):
            sensitivity[row] += derived[p] * seed[column]
            sensitivity[column] += derived[p] * seed[row]
            p += 1
    integral = N_MOBILITIES + 1 + 5 * n
    for i in range(n):
        force = 0.0
        for row in range(4):
            force += parameters[(2 + row) * n + i] * seed[row]
        for row in range(4):
            sensitivity[4 + row] += parameters[(2 + row) * n + i] * derived[integral + i] * force
