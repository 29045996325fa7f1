"""Eigenloci of an open loop under positive feedback: loop matrices at frequencies in, crossings and encirclements out.

The critical point is +1. An eigenlocus that crosses the positive real axis beyond +1 is what the paper calls an
unstable frequency, and its modulus there the loop gain.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import permutations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
OpenLoop = Callable[[Real], Complex]
"""(m,) angular frequencies [rad/s] in, (m, k, k) loop matrices out."""

_LARGEST_TURN = 0.35
"""Largest angle about +1 that a locus may turn between two frequencies [rad]. Far below half a turn, at which
it would not be known any more on which side of +1 the locus passed."""

_LARGEST_STRETCH = 0.35
"""Largest change of a locus between two frequencies, relative to its modulus or 0.5: below that a locus is too far
from +1 to matter."""

_PASSES = 14
"""Halvings of a gap, at most: 1 Hz becomes 0.06 mHz, far less than the half-width of any resonance here."""

_NEAREST = 1e-6
"""Distance from +1 below which a locus is on it: the angle about it is not defined there."""

_ROUNDING = 1e-9
"""Relative size of what rounding leaves in eigenvalues and in differences of frequencies, with room."""

_BRACKETS = 4
"""Rounds of interpolation at a crossing, where 1 / lambda is nearly linear: each about squares the error."""

_EVEN_FROM_HZ = 5.0
"""Lowest frequency of the even grid: between a suspended wheelset's rigid motion and its first bending mode [Hz]."""


@dataclass(frozen=True)
class Eigenloci:
    """Tracked eigenvalues of the loop.

    Attributes
    ----------
    omega : (m,) angular frequencies, increasing [rad/s]
    values : (m, k) eigenvalues; each column is one continuous locus
    """

    omega: Real
    values: Complex

    @property
    def frequency_hz(self) -> Real:
        """Frequencies [Hz]."""
        return self.omega / (2 * np.pi)

    @property
    def dominant(self) -> NDArray[np.int64]:
        """(m,) number of the locus with the largest modulus: the one that the paper looks at."""
        return np.asarray(np.abs(self.values).argmax(axis=1))


@dataclass(frozen=True)
class Crossing:
    """A place where an eigenlocus crosses the positive real axis beyond +1.

    Attributes
    ----------
    frequency_hz : [Hz]
    gain : modulus there, > 1
    dominant : whether no other eigenvalue is larger there, so that the paper's rule sees it
    clockwise : whether the locus goes about +1 as an instability does; otherwise it goes back
    """

    frequency_hz: float
    gain: float
    dominant: bool
    clockwise: bool


def eigenloci(open_loop: OpenLoop, omega: Real) -> Eigenloci:
    """Return the tracked eigenloci, with frequencies added until no locus jumps.

    Parameters
    ----------
    open_loop : the loop
    omega : (m,) first frequencies, increasing, such that no resonance lies between two of them unseen [rad/s]

    Notes
    -----
    Between neighbours a locus may turn about +1 by at most 0.35 rad and change by at most 0.35 of its modulus, so that
    encirclements can be counted by adding up angles.
    """
    values: Complex = np.linalg.eigvals(open_loop(omega)).astype(complex)
    for _ in range(_PASSES):
        values = _tracked(values)
        gap = np.flatnonzero(_jumps(values) & (np.diff(omega) > _ROUNDING * omega[1:]))
        if not gap.size:
            break
        middle = 0.5 * (omega[gap] + omega[gap + 1])
        omega = np.insert(omega, gap + 1, middle)
        values = np.insert(values, gap + 1, np.linalg.eigvals(open_loop(middle)), axis=0)
    return Eigenloci(omega, _tracked(values))


def _jumps(values: Complex) -> NDArray[np.bool_]:
    """Return where a locus changes too much to the next frequency, (m - 1,)."""
    before, after = values[:-1], values[1:]
    stretch = np.abs(after - before) / np.maximum(np.maximum(np.abs(before), np.abs(after)), 0.5)
    near = np.minimum(np.abs(before - 1), np.abs(after - 1))
    turn = np.abs(after - before) / np.maximum(near, _NEAREST)
    return np.asarray(((stretch > _LARGEST_STRETCH) | (turn > _LARGEST_TURN)).any(axis=1))


def _tracked(values: Complex) -> Complex:
    """Return the eigenvalues with columns exchanged so that each changes least from frequency to frequency."""
    m, k = values.shape
    orders = np.array(list(permutations(range(k))))
    moved = np.abs(values[1:, None, :][:, :, orders] - values[:-1, None, None, :]).sum(axis=-1)[:, 0]
    best = orders[moved.argmin(axis=1)]
    place = np.empty((m, k), dtype=int)
    current = np.arange(k)
    start = 0
    for change in np.flatnonzero((best != np.arange(k)).any(axis=1)).tolist():
        place[start : change + 1] = current
        current = best[change][current]
        start = change + 1
    place[start:] = current
    return np.take_along_axis(values, place, axis=1)


def crossings(open_loop: OpenLoop, loci: Eigenloci) -> tuple[Crossing, ...]:
    """Return all crossings of the positive real axis beyond +1, in the order of frequency.

    Notes
    -----
    Near a resonance 1 / lambda is linear in frequency, so the crossing is interpolated there; the loop is evaluated at
    the interpolated frequency and the bracket narrowed, until the imaginary part vanishes.
    """
    found = []
    for value in loci.values.T:
        for i in np.flatnonzero((value.imag[:-1] > 0) != (value.imag[1:] > 0)):
            omega, at = _refined(open_loop, loci.omega[i : i + 2], value[i : i + 2])
            if at.real > 1:
                others = np.linalg.eigvals(open_loop(np.array([omega]))[0])
                dominant = bool(np.abs(others).max() <= abs(at) * (1 + _ROUNDING))
                clockwise = bool(value.imag[i] > 0)
                found.append(Crossing(float(omega / (2 * np.pi)), float(at.real), dominant, clockwise))
    return tuple(sorted(found, key=lambda c: c.frequency_hz))


def _refined(open_loop: OpenLoop, omega: Real, value: Complex) -> tuple[float, complex]:
    """Return where the imaginary part of a locus vanishes between two frequencies, and its value there."""
    a, b = float(omega[0]), float(omega[1])
    at_a, at_b = complex(value[0]), complex(value[1])
    for _ in range(_BRACKETS):
        inverse_a, inverse_b = 1 / at_a, 1 / at_b
        share = inverse_a.imag / (inverse_a.imag - inverse_b.imag)
        guess = 1 / (inverse_a + share * (inverse_b - inverse_a))
        middle = a + share * (b - a)
        if abs(guess) < 0.5 or not a < middle < b:
            return middle, guess
        eigenvalues = np.linalg.eigvals(open_loop(np.array([middle]))[0])
        there = complex(eigenvalues[np.abs(eigenvalues - guess).argmin()])
        if abs(there.imag) < _ROUNDING * abs(there):
            return middle, there
        if (there.imag > 0) == (at_a.imag > 0):
            a, at_a = middle, there
        else:
            b, at_b = middle, there
    return middle, there


def encirclements(loci: Eigenloci) -> Real:
    """Return how often each locus goes clockwise about +1 over these frequencies, (k,).

    Notes
    -----
    Generalised Nyquist criterion for positive feedback: wheel, rail and contact spring are passive, so the open loop
    has no poles in the right half plane, and the sum over the loci is the number of unstable pairs of poles. It is a
    whole number where the loci begin and end on the real axis.
    """
    turns = np.angle((loci.values[1:] - 1) / (loci.values[:-1] - 1)).sum(axis=0)
    return np.asarray(-turns / (2 * np.pi))


def frequency_grid(
    frequency_hz: Real, zeta: Real, highest_hz: float = 6500.0, step_hz: float = 0.5, closed: bool = True
) -> Real:
    """Return angular frequencies fine enough for lightly damped modes, increasing [rad/s].

    Parameters
    ----------
    frequency_hz, zeta : (n,) natural frequencies [Hz] and damping ratios [-] of the modes
    step_hz : spacing away from the modes [Hz]
    closed : whether to go on far above, where sampled mobilities mean nothing

    Notes
    -----
    Even spacing, and within 2 % of every mode a fifth of half its half-power bandwidth, zeta f / 5: the contact spring
    moves a resonance by up to that much. Below and above, a few wide-spaced frequencies close the loci on the real
    axis, so that encirclements come out whole.
    """
    parts = [np.arange(_EVEN_FROM_HZ, highest_hz, step_hz)]
    # families of a doublet have one frequency, found twice by measurement
    for f, z in {(float(f"{f:.5g}"), float(f"{z:.2g}")) for f, z in zip(frequency_hz, zeta, strict=True)}:
        if _EVEN_FROM_HZ < f < highest_hz and 0 < z * f / 5 < step_hz:
            parts.append(np.arange(0.98 * f, min(1.02 * f, highest_hz), z * f / 5))
    parts += [np.geomspace(1e-3 * _EVEN_FROM_HZ, _EVEN_FROM_HZ, 100)]
    if closed:
        parts += [np.geomspace(highest_hz, 100 * highest_hz, 100)]
    return np.asarray(2 * np.pi * np.unique(np.concatenate(parts)))


def clockwise_crossings(frequency_hz: Real, value: Complex) -> tuple[Real, Real]:
    """Return frequencies and gains where a locus crosses the positive real axis from above."""
    i = clockwise_intervals(value)
    return crossing_between(frequency_hz[i], frequency_hz[i + 1], value[i], value[i + 1])


def clockwise_intervals(value: Complex) -> NDArray[np.int64]:
    """Return the numbers of the points after which a locus crosses the positive real axis from above."""
    i = np.flatnonzero((value.imag[:-1] > 0) & (value.imag[1:] <= 0))
    _, gain = crossing_between(i, i + 1, value[i], value[i + 1])
    return np.asarray(i[gain > 0])


def crossing_between(before_hz: ArrayLike, after_hz: ArrayLike, before: Complex, after: Complex) -> tuple[Real, Real]:
    """Return frequencies and gains of crossings of the real axis between two points each.

    Interpolates 1 / lambda, which is linear near a resonance.
    """
    a, b, first = 1 / before, 1 / after, np.asarray(before_hz, dtype=float)
    share = a.imag / (a.imag - b.imag)
    return first + share * (np.asarray(after_hz) - first), 1 / (a.real + share * (b.real - a.real))
