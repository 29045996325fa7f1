"""How far a wheel and a law are from Table 4 and from the prior: a vector in, residuals and their derivatives out.

A crossing lies between two points of the frequency grid, and a pole where the locus is 1. So only those few points are
differentiated, which makes the derivatives quick and free of the noise that looking for crossings anew would bring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..published.table4 import CASES, CELL_MODES, PaperTable
from ..stability.eigenloci import clockwise_intervals, crossing_between
from .fit import CLEAR, FREE_MODES, cell_residuals
from .free import FreeWheel, Prior
from .growth import SCATTER as GROWTH_SCATTER
from .growth import Limit
from .lateral_model import Crossings
from .loci import InferredModel, Points

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Whole = NDArray[np.int64]

GAIN_SCATTER = 0.02
"""Standard deviation of ln(gain) that the search allows [-]: Table 4 is printed to two or three digits."""

LOW_HZ, LOW_SCATTER_HZ = 263.1, 0.8
"""The crossing of Case 4 that the contact resonance makes, and how well it is wanted [Hz]: 0.3 %."""

COUPLED = ("(6,0)", "(4,1)")
"""A column of Table 4 and the mode that the paper finds coupled to it in Case 3: without it the column is stable."""

AIMS = (
    Limit(2, 150.0, 300.0, 0.0, 5.0),
    Limit(4, 150.0, 300.0, 0.0, 5.0),
    Limit(2, 1950.0, 2010.0, 8.0, 17.0),
    Limit(4, 1950.0, 2010.0, 8.0, np.inf),
)
"""On the rigid rail Table 4 leaves the growth of the contact resonance free; Figs 9 and 11 say that (4,0) wins, with
1978 Hz. Beyond 20 1/s in Case 2 the limit cycle goes over to one of (4,0) with (2,r) at 1985 Hz, 6 dB louder. Nothing
is asked of Cases 1 and 3, so their tone is a prediction."""

_COUPLED_CASE = 3
_OTHER = FREE_MODES.index(COUPLED[1])
_STEP = 1e-7
_POLE_STEP = 1e-4
"""Steps of the differences: a free number in its prior's standard deviations, a pole [rad/s]; between
what rounding and what curvature would spoil."""


@dataclass(frozen=True)
class Picks:
    """Where the crossings of a trial lie, cases by cells, as numbers of points.

    Attributes
    ----------
    best, further : (4, 8) the point before the largest and the next crossing; -1 where there is none
    top : (4, 8) the point with the largest real part
    """

    best: Whole
    further: Whole
    top: Whole

    @property
    def index(self) -> Whole:
        """All points that matter, sorted."""
        ends = [part[part >= 0] + shift for part in (self.best, self.further) for shift in (0, 1)]
        return np.unique(np.concatenate([*ends, self.top.ravel()]))

    def crossings(self, index: Whole, loci: Complex, frequency_hz: Real) -> Crossings:
        """Return the crossings, given the loci (4, k) at the k points of `index`."""
        case = np.arange(len(CASES))[:, None]

        def between(before: Whole) -> tuple[Real, Real]:
            there = before >= 0
            i = np.searchsorted(index, np.where(there, before, index[0]))
            j = np.searchsorted(index, np.where(there, before + 1, index[-1]))
            found = crossing_between(frequency_hz[index[i]], frequency_hz[index[j]], loci[case, i], loci[case, j])
            return np.where(there, found[0], 0.0), np.where(there, found[1], 0.0)

        frequency, gain = between(self.best)
        top = loci[case, np.searchsorted(index, self.top)].real
        return Crossings(frequency, gain, top, between(self.further)[1])


@dataclass(frozen=True)
class Seen:
    """What a trial does.

    Attributes
    ----------
    crossings : of the four cases
    growth : fastest growth rate of each aim [1/s]
    uncoupled : gain of the cell of `COUPLED` without its other mode; 0 where it is stable
    """

    crossings: Crossings
    growth: Real
    uncoupled: float


@dataclass(frozen=True)
class Misfit:
    """What is wrong with a trial.

    Attributes
    ----------
    model, prior : the cases, and what is known before
    paper : Table 4
    cases : those that are fitted; the others are held out
    scatter : standard deviation of ln(gain) [-]
    cells : factor on the residuals of Table 4, below 1 at the beginning of a search
    aims : factor on those of `AIMS`, of the crossing at 263.1 Hz and of `COUPLED`; 0: they are not asked for
    """

    model: InferredModel
    prior: Prior
    paper: PaperTable
    cases: tuple[int, ...] = CASES
    scatter: float = GAIN_SCATTER
    cells: float = 1.0
    aims: float = 0.0

    def residuals(self, vector: Real) -> Real:
        """Return everything that is wrong in standard deviations: cells, aims, distance from the prior."""
        free = self.prior.wheel(vector)
        uncoupled = self._uncoupled(free, self._uncoupled_ends(free))
        return self._together(Seen(self.crossings(free), -self.fastest(free).imag, uncoupled), vector)

    def jacobian(self, vector: Real) -> Real:
        """Return the derivatives of the residuals, one column for each free number."""
        free = self.prior.wheel(vector)
        picks = self._picks(self.model.loci(free, self.model.points))
        index, fastest = picks.index, self.fastest(free)
        near, poles = self.model.points.at(index), self.model.without_rail(fastest)
        ends = self._uncoupled_ends(free)
        movement = self._movement(free, fastest)

        def moved(change: Real) -> Real:
            trial = self.prior.wheel(vector + change)
            found = picks.crossings(index, self.model.loci(trial, near), self._frequency_hz)
            now = fastest - (self._at_poles(trial, poles) - 1) / movement if fastest.size else fastest
            return self._together(Seen(found, -now.imag, self._uncoupled(trial, ends)), vector + change)

        here = moved(np.zeros(vector.size))
        return np.stack([(moved(change) - here) / _STEP for change in _STEP * np.eye(vector.size)], axis=1)

    def crossings(self, free: FreeWheel) -> Crossings:
        """Return the crossings of all four cases."""
        loci = self.model.loci(free, self.model.points)
        picks = self._picks(loci)
        return picks.crossings(picks.index, loci[:, picks.index], self._frequency_hz)

    @property
    def _frequency_hz(self) -> Real:
        return self.model.points.omega.real / (2 * np.pi)

    def _picks(self, loci: Complex) -> Picks:
        """Return where the crossings are."""
        shape = (len(CASES), len(CELL_MODES))
        best, further, top = np.full(shape, -1), np.full(shape, -1), np.zeros(shape, dtype=int)
        for c, locus in enumerate(loci):
            for j, window in enumerate(self.model.window):
                value = locus[window]
                top[c, j] = window.start + value.real.argmax()
                i = clockwise_intervals(value)
                gain = crossing_between(i, i + 1, value[i], value[i + 1])[1]
                order = window.start + i[np.argsort(-gain)]
                best[c, j], further[c, j] = [*order, -1, -1][:2]
        return Picks(best, further, top)

    def fastest(self, free: FreeWheel) -> Complex:
        """Return the angular frequency of the fastest pole of each aim, refined on the whole locus."""
        if not self.aims:
            return np.zeros(0, dtype=complex)
        found = {case: self.model.poles(free, case) for case in {aim.case for aim in AIMS}}
        first = []
        for aim in AIMS:
            poles = found[aim.case]
            inside = np.flatnonzero((poles.frequency_hz > aim.low_hz) & (poles.frequency_hz < aim.high_hz))
            k = inside[poles.growth_rate[inside].argmax()] if inside.size else 0
            first.append(2 * np.pi * poles.frequency_hz[k] - 1j * poles.growth_rate[k])
        omega = np.array(first)
        for _ in range(4):
            omega = omega - (self._at_poles(free, self.model.without_rail(omega)) - 1) / self._movement(free, omega)
        return omega

    def _at_poles(self, free: FreeWheel, points: Points) -> Complex:
        """Return the locus of each aim's case at its own pole."""
        return _each_case(self.model.loci(free, points))

    def _movement(self, free: FreeWheel, omega: Complex) -> Complex:
        """Return the derivative of the locus by the frequency at each pole."""
        ends = [self._at_poles(free, self.model.without_rail(omega + d)) for d in (_POLE_STEP, -_POLE_STEP)]
        return np.asarray((ends[0] - ends[1]) / (2 * _POLE_STEP))

    def _uncoupled_ends(self, free: FreeWheel) -> Whole:
        """Return the two points between which the cell of `COUPLED` crosses without its other mode; none if stable."""
        if not self.aims:
            return np.zeros(0, dtype=np.int64)
        window = self.model.window[CELL_MODES.index(COUPLED[0])]
        inside = np.arange(window.start, window.stop)
        locus = self.model.loci(free.without(_OTHER), self.model.points.at(inside))[_COUPLED_CASE - 1]
        i = clockwise_intervals(locus)
        gain = crossing_between(i, i + 1, locus[i], locus[i + 1])[1]
        return inside[i[gain.argmax()] + np.arange(2)] if i.size else inside[:0]

    def _uncoupled(self, free: FreeWheel, ends: Whole) -> float:
        """Return the gain of that crossing, 0 where there is none."""
        if not ends.size:
            return 0.0
        before, after = self.model.loci(free.without(_OTHER), self.model.points.at(ends))[_COUPLED_CASE - 1]
        return float(crossing_between(0.0, 1.0, before, after)[1])

    def _together(self, seen: Seen, vector: Real) -> Real:
        """Return the residuals of what was seen."""
        found = seen.crossings
        cells = self.cells * cell_residuals(found, self.paper, CELL_MODES, self.cases, self.scatter)
        if not self.aims:
            return np.concatenate([cells, vector])
        low = found.frequency_hz[3, CELL_MODES.index("(0,0)")]
        off = (low - LOW_HZ) / LOW_SCATTER_HZ if low > 0 else 0.0  # without it the cell itself is wrong
        much = max(float(np.log(max(seen.uncoupled, 0.1))) + CLEAR, 0.0) / self.scatter
        aims = [*(_excess(aim, rate) for aim, rate in zip(AIMS, seen.growth, strict=True)), off, much]
        return np.concatenate([cells, self.aims * np.array(aims), vector])


def _each_case(loci: Complex) -> Complex:
    """Return from loci (4, k) at the poles of k aims the entry of each aim's own case, (k,)."""
    rows: Sequence[int] = [aim.case - 1 for aim in AIMS[: loci.shape[1]]]
    return np.asarray(loci[rows, np.arange(loci.shape[1])])


def _excess(aim: Limit, rate: float) -> float:
    """Return by how much a growth rate is outside its limits, in standard deviations."""
    bound = min(max(rate, aim.least, 0.0), aim.most)
    return float((max(rate, 0.0) - bound) / (GROWTH_SCATTER * bound)) if bound > 0 else 0.0
