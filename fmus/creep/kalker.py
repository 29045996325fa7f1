"""Kalker's creepage coefficients, interpolated. Kernels.

The table is E.3 of J. J. Kalker, Three-Dimensional Elastic Bodies in Rolling Contact (1990).
"""

import math

import numpy as np

from ..compile import kernel

# [shape of the ellipse: a <= b, a >= b][ratio 0.1 ... 1.0][c11, c22, c23, c33, each for nu 0, 0.25, 0.5]
TABLE = np.array(
    (
        (
            (2.51, 3.31, 4.85, 2.51, 2.52, 2.53, 0.334, 0.473, 0.731, 6.42, 8.28, 11.7),
            (2.59, 3.37, 4.81, 2.59, 2.63, 2.66, 0.483, 0.603, 0.809, 3.46, 4.27, 5.66),
            (2.68, 3.44, 4.8, 2.68, 2.75, 2.81, 0.607, 0.715, 0.889, 2.49, 2.96, 3.72),
            (2.78, 3.53, 4.82, 2.78, 2.88, 2.98, 0.72, 0.823, 0.977, 2.02, 2.32, 2.77),
            (2.88, 3.62, 4.83, 2.88, 3.01, 3.14, 0.827, 0.929, 1.07, 1.74, 1.93, 2.22),
            (2.98, 3.72, 4.91, 2.98, 3.14, 3.31, 0.93, 1.03, 1.18, 1.56, 1.68, 1.86),
            (3.09, 3.81, 4.97, 3.09, 3.28, 3.48, 1.03, 1.14, 1.29, 1.43, 1.5, 1.6),
            (3.19, 3.91, 5.05, 3.19, 3.41, 3.65, 1.13, 1.25, 1.4, 1.34, 1.37, 1.42),
            (3.29, 4.01, 5.12, 3.29, 3.54, 3.82, 1.23, 1.36, 1.51, 1.27, 1.27, 1.27),
            (3.4, 4.12, 5.2, 3.4, 3.67, 3.98, 1.33, 1.47, 1.63, 1.21, 1.19, 1.16),
        ),
        (
            (10.7, 11.7, 12.9, 10.7, 12.8, 16.0, 12.2, 14.6, 18.0, 0.795, 0.526, 0.228),
            (6.96, 7.78, 8.82, 6.96, 8.14, 9.79, 5.72, 6.63, 7.89, 0.828, 0.601, 0.341),
            (5.57, 6.34, 7.34, 5.57, 6.4, 7.51, 3.79, 4.32, 5.01, 0.868, 0.674, 0.446),
            (4.84, 5.57, 6.57, 4.84, 5.48, 6.31, 2.88, 3.24, 3.7, 0.912, 0.747, 0.549),
            (4.37, 5.1, 6.11, 4.37, 4.9, 5.56, 2.35, 2.62, 2.96, 0.958, 0.819, 0.65),
            (4.06, 4.78, 5.8, 4.06, 4.5, 5.04, 2.01, 2.23, 2.5, 1.01, 0.892, 0.751),
            (3.82, 4.54, 5.58, 3.82, 4.21, 4.67, 1.76, 1.95, 2.18, 1.05, 0.965, 0.852),
            (3.65, 4.36, 5.42, 3.65, 3.99, 4.39, 1.58, 1.75, 1.94, 1.1, 1.04, 0.954),
            (3.51, 4.22, 5.3, 3.51, 3.81, 4.16, 1.44, 1.59, 1.77, 1.16, 1.11, 1.06),
            (3.4, 4.12, 5.2, 3.4, 3.67, 3.98, 1.33, 1.47, 1.63, 1.21, 1.19, 1.16),
        ),
    )
)


@kernel
def creepage_coefficients(
    semi_axis_lon: float, semi_axis_lat: float, poisson: float
) -> tuple[float, float, float, float]:
    """Return Kalker's coefficients c11, c22, c23, c33 [-] of a contact ellipse.

    Parameters
    ----------
    semi_axis_lon, semi_axis_lat : float
        Semi-axes a (rolling direction) and b [m], > 0; the ratio is limited to the table's 0.1 to 10.
    poisson : float
        Poisson's ratio [-], 0 to 0.5.

    Notes
    -----
    Linear in a/b for a <= b, in its logarithm and that of the coefficient for a > b, where the coefficients grow like
    a power of a/b on narrow ellipses; quadratic in nu through the reciprocals. Within 1.2 % of CONTACT up to a/b = 6.7.

    >>> [round(c, 3) for c in creepage_coefficients(2.0, 1.0, 0.28)]
    [5.204, 4.971, 2.657, 0.799]
    """
    side = 1 if semi_axis_lon > semi_axis_lat else 0
    g = min(semi_axis_lon / semi_axis_lat, semi_axis_lat / semi_axis_lon)
    position = min(max(g, 0.1), 1.0) * 10.0 - 1.0
    row = min(int(position), 8)
    part = (
        position - row if side == 0 else math.log((position + 1.0) / (row + 1.0)) / math.log((row + 2.0) / (row + 1.0))
    )
    w0 = 8.0 * (poisson - 0.25) * (poisson - 0.5)
    w1 = -16.0 * poisson * (poisson - 0.5)
    w2 = 8.0 * poisson * (poisson - 0.25)
    c11 = _at(side, row, part, 0, w0, w1, w2)
    c22 = _at(side, row, part, 3, w0, w1, w2)
    c23 = _at(side, row, part, 6, w0, w1, w2)
    c33 = _at(side, row, part, 9, w0, w1, w2)
    return c11, c22, c23, c33


@kernel
def _at(side, row, part, column, w0, w1, w2):  # type: ignore[no-untyped-def]
    """Interpolate one coefficient: between two rows, and through reciprocals between three Poisson's ratios."""
    c0 = _between(side, row, part, column)
    c1 = _between(side, row, part, column + 1)
    c2 = _between(side, row, part, column + 2)
    return 1.0 / (w0 / c0 + w1 / c1 + w2 / c2)


@kernel
def _between(side, row, part, column):  # type: ignore[no-untyped-def]
    """Interpolate a column of the table between two rows: linearly, or in the logarithm where a > b."""
    low = TABLE[side, row, column]
    high = TABLE[side, row + 1, column]
    if side == 0:
        return low + part * (high - low)
    return low * (high / low) ** part
