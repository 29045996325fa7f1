"""The running vehicle: curvature, speed, cant and friction in, operating points of the four contacts out. Kernels.

Steady-state curving: the vehicle has no memory of its own but the last solution, which Newton's method starts from. As
long as the inputs stay as they are, a step has nothing to do.
"""

import math

from ..compile import kernel
from .balance import lateral_load, put_residual
from .equilibrium import FIRST_STEP, follow, start_straight
from .geometry import prepare_table
from .layout import N_COLUMNS, N_WHEEL, PER_AXLE, WHEEL_OUTPUTS, C, D, N, S, X
from .parameters import N_FIXED, P

FLATTEST = 1e-9
"""Curvature of what counts as straight track [1/m]."""


@kernel
def _on_table(parameters, derived):  # type: ignore[no-untyped-def]
    """Return whether both axles, whose unknowns `unscale` put last, are within the table of contact geometry."""
    n = (parameters.size - N_FIXED) // N_COLUMNS
    if n < 2:
        return True
    first = parameters[P.table_start]
    last = first + (n - 1) * parameters[P.table_spacing]
    for axle in range(2):
        y = derived[D.trial + axle * PER_AXLE + X.y]
        if abs(y) > min(-first, last):
            return False
    return True


@kernel
def _on_arc(parameters, derived):  # type: ignore[no-untyped-def]
    """Return whether no flange of cone and arc is climbed beyond its steepest angle."""
    n = (parameters.size - N_FIXED) // N_COLUMNS
    if n > 1:
        return True
    rise = math.sin(parameters[P.flange_angle]) - math.sin(math.atan(parameters[P.conicity]))
    for axle in range(2):
        y = derived[D.trial + axle * PER_AXLE + X.y]
        if abs(y) > parameters[P.flange_clearance] + parameters[P.flange_arc_radius] * rise:
            return False
    return True


@kernel
def _put_outputs(derived, outputs, iterations, residual):  # type: ignore[no-untyped-def]
    """Put the wheels' values and the monitors into the outputs."""
    for wheel in range(4):
        for i in range(WHEEL_OUTPUTS):
            outputs[wheel * WHEEL_OUTPUTS + i] = derived[D.wheels + wheel * N_WHEEL + i]
    at = 4 * WHEEL_OUTPUTS
    for axle in range(2):
        outputs[at + 2 * axle] = derived[D.trial + axle * PER_AXLE + X.y]
        outputs[at + 2 * axle + 1] = derived[D.trial + axle * PER_AXLE + X.yaw]
    outputs[at + 4] = iterations
    outputs[at + 5] = residual


@kernel
def _solve(parameters, derived, state, inputs, outputs, last, first):  # type: ignore[no-untyped-def]
    """Follow the solution from `last` to the inputs; outputs are no numbers where there is none."""
    curvature = inputs[C.curvature]
    wanted = (curvature, lateral_load(parameters, curvature, inputs[C.velocity], inputs[C.cant]), inputs[C.mu0])
    unknowns = state[S.unknowns : S.unknowns + N]
    iterations, residual, reached = follow(parameters, derived, unknowns, last, wanted, first)
    state[S.reached] = 1.0 / max(abs(last[0] + reached * (wanted[0] - last[0])), FLATTEST)
    failure = -min(iterations, 0)
    if failure == 0:
        put_residual(parameters, derived, unknowns, wanted[0], wanted[1], wanted[2], D.residual)
        if not (_on_table(parameters, derived) and _on_arc(parameters, derived)):
            failure = 3
    state[S.failed] = failure
    if failure > 0:
        for i in range(outputs.size):
            outputs[i] = math.nan
        return
    state[S.curvature], state[S.load], state[S.mu0] = wanted
    state[S.velocity] = inputs[C.velocity]
    state[S.cant] = inputs[C.cant]
    _put_outputs(derived, outputs, iterations, residual)


@kernel
def initialise(parameters, derived, state, inputs, outputs):  # type: ignore[no-untyped-def]
    """Find the steady state in the first curve, on the way from straight track."""
    prepare_table(parameters, derived)
    unknowns = state[S.unknowns : S.unknowns + N]
    start_straight(unknowns)
    part = FIRST_STEP / max(abs(inputs[C.curvature]), FIRST_STEP)
    straight = (0.0, 0.0, inputs[C.mu0])
    _solve(parameters, derived, state, inputs, outputs, straight, part)


@kernel
def do_step(parameters, derived, state, inputs, outputs, h):  # type: ignore[no-untyped-def]
    """Find the steady state at the inputs from the last one; what does not change costs nothing."""
    if (
        state[S.failed] == 0.0
        and inputs[C.curvature] == state[S.curvature]
        and inputs[C.velocity] == state[S.velocity]
        and inputs[C.cant] == state[S.cant]
        and inputs[C.mu0] == state[S.mu0]
    ):
        outputs[4 * WHEEL_OUTPUTS + 4] = 0.0
        return
    last = (state[S.curvature], state[S.load], state[S.mu0])
    _solve(parameters, derived, state, inputs, outputs, last, 1.0)
