"""Friction as a table: a monotone cubic through points of measured friction, with a continuous slope. Kernels.

The slopes at the points are those of the cubic spline (fourth order where points are evenly spaced), limited so that
the curve rises and falls only where the points do: C. de Boor, B. Swartz, Journal of Approximation Theory 21 (1977)
411-416; J. M. Hyman, SIAM Journal on Scientific and Statistical Computing 4 (1983) 645-654. Beyond its ends the curve
goes on with its slope there, which decays over the length of the table, and sooner where friction would fall below half
of its end value.
"""

import math

from ...compile import kernel
from ..layout import FRICTION, FRICTION_SLOPES, FRICTION_WORK
from ..parameters import P


@kernel
def prepare_table(parameters, derived):  # type: ignore[no-untyped-def]
    """Put the slopes at the points of the table into `derived`, and the friction without sliding.

    That is no number if the table is none: fewer than 2 points, an abscissa that does not rise, or friction that is
    not above 0; then no force is one.
    """
    n = int(parameters[P.friction_points])
    if not _is_table(parameters, n):
        derived[FRICTION] = math.nan
        return
    _spline_slopes(parameters, derived, n)
    for i in range(n):
        derived[FRICTION_SLOPES + i] = _limited(parameters, derived[FRICTION_SLOPES + i], i, n)
    derived[FRICTION], _ = table(parameters, derived, 0.0)


@kernel
def table(parameters, derived, place):  # type: ignore[no-untyped-def]
    """Return friction coefficient and slope at an abscissa >= 0 of a table that `prepare_table` has prepared."""
    x, y, m = P.friction_abscissa_001, P.friction_ordinate_001, FRICTION_SLOPES
    last = int(parameters[P.friction_points]) - 1
    if last < 1:
        return math.nan, math.nan
    if place <= parameters[x]:
        beyond = parameters[x] - place
        value, slope = _onwards(parameters, parameters[y], -derived[m], beyond)
        return value, -slope
    if place >= parameters[x + last]:
        return _onwards(parameters, parameters[y + last], derived[m + last], place - parameters[x + last])
    low, high = 0, last
    while high - low > 1:
        middle = (low + high) // 2
        if parameters[x + middle] <= place:
            low = middle
        else:
            high = middle
    width = parameters[x + high] - parameters[x + low]
    t = (place - parameters[x + low]) / width
    rise = parameters[y + high] - parameters[y + low]
    # y + width t m0 + (3 rise - width (2 m0 + m1)) t^2 + (width (m0 + m1) - 2 rise) t^3
    first = width * derived[m + low]
    second = 3.0 * rise - 2.0 * first - width * derived[m + high]
    third = first + width * derived[m + high] - 2.0 * rise
    value = parameters[y + low] + t * (first + t * (second + t * third))
    return value, (first + t * (2.0 * second + 3.0 * t * third)) / width


@kernel
def _is_table(parameters, n):  # type: ignore[no-untyped-def]
    """Return whether the points make a table."""
    if n < 2:
        return False
    x, y = P.friction_abscissa_001, P.friction_ordinate_001
    for i in range(n):
        if parameters[y + i] <= 0.0:
            return False
        if i > 0 and parameters[x + i] <= parameters[x + i - 1]:
            return False
    return True


@kernel
def _secant(parameters, i):  # type: ignore[no-untyped-def]
    """Return the slope of the straight line from point i to the next."""
    x, y = P.friction_abscissa_001 + i, P.friction_ordinate_001 + i
    return (parameters[y + 1] - parameters[y]) / (parameters[x + 1] - parameters[x])


@kernel
def _width(parameters, i):  # type: ignore[no-untyped-def]
    """Return the distance of point i from the next."""
    return parameters[P.friction_abscissa_001 + i + 1] - parameters[P.friction_abscissa_001 + i]


@kernel
def _end_slope(parameters, i, j):  # type: ignore[no-untyped-def]
    """Return the slope at the outer end of interval i, of the parabola that goes on through interval j."""
    a, b = _width(parameters, i), _width(parameters, j)
    return ((2.0 * a + b) * _secant(parameters, i) - a * _secant(parameters, j)) / (a + b)


@kernel
def _spline_slopes(parameters, derived, n):  # type: ignore[no-untyped-def]
    """Put the slopes of the cubic spline between given end slopes into `derived`: a tridiagonal system."""
    m, work = FRICTION_SLOPES, FRICTION_WORK
    if n == 2:
        derived[m] = derived[m + 1] = _secant(parameters, 0)
        return
    derived[m] = _end_slope(parameters, 0, 1)
    derived[m + n - 1] = _end_slope(parameters, n - 2, n - 3)
    derived[work] = 0.0
    for i in range(1, n - 1):
        a, b = 1.0 / _width(parameters, i - 1), 1.0 / _width(parameters, i)
        right = 3.0 * (a * _secant(parameters, i - 1) + b * _secant(parameters, i))
        pivot = 2.0 * (a + b) - a * derived[work + i - 1]
        derived[work + i] = b / pivot if i < n - 2 else 0.0
        if i == n - 2:
            right -= b * derived[m + n - 1]
        derived[m + i] = (right - a * derived[m + i - 1]) / pivot
    for i in range(n - 3, 0, -1):
        derived[m + i] -= derived[work + i] * derived[m + i + 1]


@kernel
def _limited(parameters, slope, i, n):  # type: ignore[no-untyped-def]
    """Return a slope at point i with which the curve is monotone wherever the points are."""
    before = _secant(parameters, max(i - 1, 0))
    after = _secant(parameters, min(i, n - 2))
    if before * after <= 0.0 or slope * after <= 0.0:
        return 0.0
    most = 3.0 * min(abs(before), abs(after))
    return min(most, max(-most, slope))


@kernel
def _onwards(parameters, value, slope, beyond):  # type: ignore[no-untyped-def]
    """Return friction and slope some way beyond an end, where the curve leaves with `slope` outwards."""
    last = int(parameters[P.friction_points]) - 1
    reach = parameters[P.friction_abscissa_001 + last] - parameters[P.friction_abscissa_001]
    if -slope * reach > 0.5 * value:
        reach = -0.5 * value / slope
    rest = math.exp(-beyond / reach)
    return value + slope * reach * (1.0 - rest), slope * rest
