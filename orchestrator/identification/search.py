"""The search for the inferred wheel: seeded starts and continuation of the residuals, in two stages; the best by cost.

Table 4 has many minima, and from a random start plain least squares ends in a bad one: a cell with the wrong sign
weighs so much that nothing else moves. So the residuals of the table begin at three hundredths of their weight, where
the prior holds the wheel near the finite elements, and then those of the aims in the same way.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from .free import FreeWheel
from .misfit import Misfit

Real = NDArray[np.float64]

CELL_WEIGHTS = (0.03, 0.15, 1.0)
AIM_WEIGHTS = (0.03, 0.1, 0.3, 1.0)
"""Factors on the residuals of Table 4, then of the aims, one after the other: at full weight at
once, half the starts end with cells of the wrong sign."""

START_WIDTH = 0.3
"""Standard deviation of a start about the prior's middle, in those of the prior [-]: wide enough to end in different
minima."""

START_SLOPES = (0.15, 0.8)
"""Between these the slope factor starts, evenly: the whole of what might be."""

HOPELESS = 3000.0
"""Cost before the last weight's end beyond which a start is given up: a cell has the wrong sign,
which costs thousands and is not mended any more; the best ends cost some tens."""

_EVALUATIONS = 100
_ROUGH, _FINE = 1e-3, 1e-6
"""Relative tolerances: on the way, where the next weight moves the minimum anyway, and at the last weight."""


@dataclass(frozen=True)
class Found:
    """Where a start ended.

    Attributes
    ----------
    seed : of the start
    vector : the wheel, in standard deviations of the prior
    cost : half the sum of the squared residuals, those of the prior among them
    finished : whether both stages were gone through
    """

    seed: int
    vector: Real
    cost: float
    finished: bool


@dataclass(frozen=True)
class Search:
    """What is searched.

    Attributes
    ----------
    misfit : residuals, without aims
    held : free numbers that keep a value, by name of `free.SCALARS`
    with_aims : whether the second stage is wanted
    """

    misfit: Misfit
    held: Mapping[str, float] = field(default_factory=dict)
    with_aims: bool = True

    def start(self, seed: int) -> Real:
        """Return where a seed starts: about the finite elements, with any slope."""
        random = np.random.default_rng(seed)
        prior = self.misfit.prior
        vector = START_WIDTH * random.standard_normal(prior.width.size)
        place = prior.place("slope_factor")
        vector[place] = np.log(random.uniform(*START_SLOPES)) / prior.width[place]
        return self.held_in(vector)

    def run(self, seed: int) -> Found:
        """Return where a seed ends."""
        vector, cost = self.start(seed), np.inf
        for weight in CELL_WEIGHTS:
            fine = weight == CELL_WEIGHTS[-1] and not self.with_aims
            vector, cost = self.descend(replace(self.misfit, cells=weight), vector, fine)
            if cost > HOPELESS:
                return Found(seed, vector, cost, False)
        for weight in AIM_WEIGHTS if self.with_aims else ():
            vector, cost = self.descend(replace(self.misfit, aims=weight), vector, weight == AIM_WEIGHTS[-1])
        return Found(seed, vector, cost, True)

    def descend(self, misfit: Misfit, vector: Real, fine: bool = True) -> tuple[Real, float]:
        """Return the minimum below a vector and its cost."""
        tolerance = _FINE if fine else _ROUGH
        moving = np.ones(vector.size, dtype=bool)
        moving[[misfit.prior.place(name) for name in self.held]] = False

        def whole(part: Real) -> Real:
            out = vector.copy()
            out[moving] = part
            return out

        end = least_squares(
            lambda part: misfit.residuals(whole(part)),
            vector[moving],
            jac=lambda part: misfit.jacobian(whole(part))[:, moving],
            max_nfev=_EVALUATIONS, ftol=tolerance, xtol=tolerance, gtol=tolerance,
        )  # fmt: skip
        return whole(end.x), float(end.cost)

    def final(self) -> Misfit:
        """Return the residuals at the end of the search."""
        return replace(self.misfit, aims=1.0) if self.with_aims else self.misfit

    def held_in(self, vector: Real) -> Real:
        """Return a vector with the held numbers in place."""
        out, prior = vector.copy(), self.misfit.prior
        for name, value in self.held.items():
            place = prior.place(name)
            out[place] = np.log(value / getattr(prior.middle, name)) / prior.width[place]
        return out


def starts(search: Search, seeds: Sequence[int], report: Callable[[Found], None] = lambda _: None) -> Iterator[Found]:
    """Yield where each seed ends."""
    for seed in seeds:
        found = search.run(seed)
        report(found)
        yield found


def best(found: Sequence[Found]) -> Found:
    """Return the start that ended lowest, one that went through both stages if there is one."""
    return min(found, key=lambda one: (not one.finished, one.cost))


@dataclass(frozen=True)
class Quality:
    """How near a wheel is to Table 4.

    Attributes
    ----------
    frequency_hz, gain : (4, 8) crossings; 0 where there is none
    further : largest gain of any crossing that belongs to no cell
    right : (4, 8) whether a cell is stable or unstable as published
    log_gain : (4, 8) ln(gain/paper gain); NaN where one of both is stable
    """

    frequency_hz: Real
    gain: Real
    further: float
    right: NDArray[np.bool_]
    log_gain: Real

    def rms(self, cases: Sequence[int] = (1, 2, 3, 4)) -> float:
        """Return the rms of ln(gain/paper gain) over some cases."""
        return float(np.sqrt(np.nanmean(self.log_gain[[case - 1 for case in cases]] ** 2)))

    @property
    def worst(self) -> float:
        """Largest deviation of a gain, relative to the paper's."""
        return float(np.nanmax(np.abs(np.expm1(self.log_gain))))


def quality(misfit: Misfit, free: FreeWheel) -> Quality:
    """Return how near a wheel is to Table 4, all four cases whatever was fitted."""
    found, paper = misfit.crossings(free), misfit.paper
    right = (found.gain > 1) == paper.unstable
    with np.errstate(divide="ignore", invalid="ignore"):
        log_gain = np.where(paper.unstable & (found.gain > 1), np.log(found.gain / paper.gain), np.nan)
    return Quality(found.frequency_hz, found.gain, float(found.further.max()), right, log_gain)


def deviations(misfit: Misfit, vector: Real, held: Sequence[str] = ()) -> Real:
    """Return the standard deviations of a minimum in those of the prior, (2 n + 5,), with the scatter that was found.

    Notes
    -----
    Least squares with the rms of ln(gain) that the fit leaves in the place of what the search allows. A number that is
    held has none.
    """
    free = misfit.prior.wheel(vector)
    J = replace(misfit, scatter=quality(misfit, free).rms(misfit.cases)).jacobian(vector)
    moving = np.ones(vector.size, dtype=bool)
    moving[[misfit.prior.place(name) for name in held]] = False
    out = np.zeros(vector.size)
    out[moving] = np.sqrt(np.diag(np.linalg.inv(J[:, moving].T @ J[:, moving])))
    return out
