"""Contact amplitudes of the Class 158 wheelset, identified from Table 4 of the paper with the finite elements as prior.

Comes in: the generic wheelset's modes (frequencies of Table 4 imposed), the analytical track, the printed crossings,
and limits of the growth of low modes (`identification_growth.py`). Goes out: the lateral and vertical amplitudes of
fifteen modes and the vertical one of the rigid body, with standard deviations. Frequencies, damping, all other modes
and the sine families stay as they are.

`identification_data.py` writes the outcome as the data of `fmus.wheel`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution, least_squares

from fmus.modal.modes import Modes

from ..published.table4 import CASES, CELL_MODES, PaperTable
from ..stability.loop import linear_contact
from .growth import LIMITS, FittedRail, GrowthLimits, growth_limits
from .lateral_model import Crossings, LateralModel, lateral_model

Real = NDArray[np.float64]

GROUPS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    (("axle", "(1,0)", "(0,0)", "(0,x)", "(1,1) symmetric #2"), ("(1,0)", "(0,0)", "(0,x)")),
    (("(2,0)",), ("(2,0)",)),
    (("(3,0)",), ("(3,0)",)),
    (("(2,r)", "(4,0)"), ("(4,0)",)),
    (("(5,0)",), ("(5,0)",)),
    (("(4,1)", "(6,0)"), ("(6,0)",)),
)
"""Modes that act on each other through their cells of Table 4 (first search), and those cells."""

RIGID = ("rigid n=1 symmetric", "rigid n=1 antisymmetric")
"""Rigid-body modes whose normal amplitudes share one factor: the wheelset's mass at the contact is not known either."""

AXLE = ("axle n=1 antisymmetric #2", "axle n=1 antisymmetric #3", "axle n=1 symmetric #3")
"""Bending of the axle at 513, 1061 and 746 Hz, which is part of the normal mobility under the modes of Table 4."""

FREE_MODES = (*(mode for modes, _ in GROUPS for mode in modes), *AXLE)

GAIN_SCATTER = 0.02
SEARCH_SCATTER = 0.1
"""Standard deviations of ln(gain) that the fit and the search before it allow [-]: Table 4 is printed to two or three
digits; five times that in the search, so that one cell that is far off does not hide the others."""

LATERAL_PRIOR = 0.7
NORMAL_PRIOR = 0.015
MASS_PRIOR = 0.5
"""Standard deviations of the prior: ln of a lateral amplitude [-], normal amplitude [kg^-1/2], ln of the factor [-].
Of the finite elements of a generic wheel a factor of two is believed laterally (ln 2 = 0.7); normal amplitudes are
small differences of large ones, so that their width is absolute."""

CLEAR = 0.05
"""Margin in ln(gain) by which a cell must be stable or unstable: more than the scatter of a fit."""

_PENALTY = 0.01
"""Scale in ln(gain) on which a cell or crossing on the wrong side is penalised: half the scatter, so that it costs more
than any cell that is only not met well."""

_FREQUENCY_SHARE = 0.85
"""Share of the frequency tolerance that is free of penalty; the rest is room for what the lateral model leaves out."""


@dataclass(frozen=True)
class Amplitudes:
    """The free amplitudes, in contact axes, each mode with positive lateral amplitude.

    Attributes
    ----------
    lateral, normal : (15,) of `FREE_MODES` [kg^-1/2]
    mass_factor : on the normal amplitudes of the rigid-body modes [-]
    """

    lateral: Real
    normal: Real
    mass_factor: float

    def vector(self, prior: Amplitudes) -> Real:
        """Return the amplitudes as distances from the prior in its standard deviations, (31,)."""
        return np.concatenate([
            np.log(self.lateral / prior.lateral) / LATERAL_PRIOR,
            (self.normal - prior.normal) / NORMAL_PRIOR,
            [np.log(self.mass_factor / prior.mass_factor) / MASS_PRIOR],
        ])  # fmt: skip

    @classmethod
    def of(cls, vector: Real, prior: Amplitudes) -> Amplitudes:
        """Return the amplitudes that `vector` made a vector of."""
        n = prior.lateral.size
        return cls(
            prior.lateral * np.exp(LATERAL_PRIOR * vector[:n]),
            prior.normal + NORMAL_PRIOR * vector[n : 2 * n],
            prior.mass_factor * float(np.exp(MASS_PRIOR * vector[2 * n])),
        )


@dataclass(frozen=True)
class Identification:
    """The outcome of a fit.

    Attributes
    ----------
    hertz_stiffness : of the contact spring that the fit was made with [N/m]
    cases : cases of the paper that were fitted
    amplitudes : the best ones
    deviation : (31,) standard deviations of ln(lateral) [-], normal [kg^-1/2] and ln(mass_factor) [-]
    frequency_hz, gain : (4, 8) crossings by the scalar formula; 0 where there is none
    """

    hertz_stiffness: float
    cases: tuple[int, ...]
    amplitudes: Amplitudes
    deviation: Real
    frequency_hz: Real
    gain: Real


@dataclass(frozen=True)
class Problem:
    """A fit to be made.

    Attributes
    ----------
    model : the loci, free modes first `FREE_MODES`, then `RIGID`
    prior : amplitudes of the finite elements
    rigid : (2, 2) lateral and normal amplitudes of the rigid-body modes before the factor
    paper : what is fitted
    cases : cases of Table 4 that are fitted; the others are predictions
    growth : limits of the growth of low modes
    """

    model: LateralModel
    prior: Amplitudes
    rigid: Real
    paper: PaperTable
    cases: tuple[int, ...]
    growth: GrowthLimits

    def amplitudes(self, vector: Real) -> tuple[Real, Real]:
        """Return lateral and normal amplitudes of all free columns of the model."""
        a = Amplitudes.of(vector, self.prior)
        lateral = np.concatenate([a.lateral, self.rigid[0]])
        return lateral, np.concatenate([a.normal, self.rigid[1] * a.mass_factor])

    def residuals(self, vector: Real) -> Real:
        """Return the residuals over all cells, beyond the limits of growth, and the distance from the prior."""
        lateral, normal = self.amplitudes(vector)
        found = self.model.crossings(lateral, normal)
        cells = cell_residuals(found, self.paper, self.model.cells, self.cases, GAIN_SCATTER)
        return np.concatenate([cells, self.growth.residuals(lateral, normal), vector])


def cell_residuals(
    found: Crossings, paper: PaperTable, cells: tuple[str, ...], cases: tuple[int, ...], scatter: float
) -> Real:
    """Return what is wrong with some cells of Table 4, in standard deviations.

    Notes
    -----
    ln(gain/paper gain); beyond the free share, the crossing frequency; and by how much a cell is unstable that should
    be stable, the reverse, or has a second crossing. Where the crossing is not there yet, a tenth of the largest real
    part stands in for its gain.
    """
    rows, columns = [case - 1 for case in cases], [CELL_MODES.index(cell) for cell in cells]
    pick = np.ix_(rows, columns)
    unstable, gain = paper.unstable[pick], found.gain[rows]
    there = np.where(gain > 0.05, gain, 0.1 * np.maximum(found.top[rows], 0.1))
    log_gain = np.log(there)
    wanted = np.where(unstable, paper.gain[pick], 1.0)
    target = np.where(unstable, paper.frequency_hz[pick], 1.0)
    off = np.where(gain > 0.05, np.abs(found.frequency_hz[rows] / target - 1) / paper.tolerance[pick], 2.0)
    parts = [
        np.where(unstable, (log_gain - np.log(wanted)) / scatter, 0.0),
        np.where(unstable, 10 * np.maximum(off - _FREQUENCY_SHARE, 0), 0.0),
        np.maximum(np.where(unstable, CLEAR - log_gain, log_gain * (gain > 0.05) + CLEAR), 0) / _PENALTY,
        np.maximum(np.log(np.maximum(found.further[rows], 0.1)) + CLEAR, 0) / _PENALTY,
    ]
    stable_absent = ~unstable & (gain <= 0.05)
    parts[2] = np.where(stable_absent, 0.0, parts[2])
    return np.concatenate([part.ravel() for part in parts])


def identify(
    modes: Modes,
    rail: FittedRail,
    paper: PaperTable,
    hertz_stiffness: float,
    cases: tuple[int, ...] = CASES,
    start: Amplitudes | None = None,
) -> Identification:
    """Return the amplitudes that come nearest to Table 4 and to the prior.

    Parameters
    ----------
    modes : modes of the prior wheelset, track axes
    rail : the rail of Cases 1 and 3
    cases : cases of Table 4 that are fitted; the others are predictions
    start : where to begin, such as the outcome at a spring nearly as stiff; None: search

    Notes
    -----
    A seeded global search over each group of modes, one after the other, then least squares over all of them together.
    The standard deviations are those of least squares, with the scatter of the residuals of the fit itself.
    """
    problem = make_problem(modes, rail, paper, hertz_stiffness, cases)
    if start is None:
        vector = np.zeros(2 * len(FREE_MODES) + 1)
        for group in range(len(GROUPS)):
            vector = _search_group(problem, vector, group)
        free = replace(problem, growth=replace(problem.growth, limits=()))
        start = _polished(free, vector, hertz_stiffness).amplitudes
    return _polished(problem, start.vector(problem.prior), hertz_stiffness)


def assess(
    modes: Modes, rail: FittedRail, paper: PaperTable, hertz_stiffness: float, amplitudes: Amplitudes
) -> Identification:
    """Return given amplitudes with their crossings and standard deviations, without changing them."""
    problem = make_problem(modes, rail, paper, hertz_stiffness, CASES)
    return _polished(problem, amplitudes.vector(problem.prior), hertz_stiffness, evaluations=1)


def _polished(problem: Problem, vector: Real, hertz_stiffness: float, evaluations: int = 30) -> Identification:
    """Return the outcome of least squares over all amplitudes."""
    best = least_squares(problem.residuals, vector, max_nfev=evaluations, diff_step=1e-5)
    found = problem.model.crossings(*problem.amplitudes(best.x))
    covariance = np.linalg.inv(best.jac.T @ best.jac)
    n = len(FREE_MODES)
    scale = np.concatenate([np.full(n, LATERAL_PRIOR), np.full(n, NORMAL_PRIOR), [MASS_PRIOR]])
    return Identification(
        hertz_stiffness, problem.cases, Amplitudes.of(best.x, problem.prior),
        scale * np.sqrt(np.diag(covariance)), found.frequency_hz, found.gain,
    )  # fmt: skip


def make_problem(
    modes: Modes, rail: FittedRail, paper: PaperTable, hertz_stiffness: float, cases: tuple[int, ...]
) -> Problem:
    """Return the fit of some cases."""
    falling, constant = (
        linear_contact({"hertz_stiffness": hertz_stiffness, **more}) for more in ({}, {"falling_ratio": 0.0})
    )
    free = [modes.labels.index(f"{name} cosine") for name in (*FREE_MODES, *RIGID)]
    contacts = (falling, falling, constant, constant)
    model = lateral_model(modes, free, rail.mobility, contacts)
    lateral, normal = (modes.shape[free] @ falling.turn.T)[:, 1:3].T
    sign = np.where(lateral < 0, -1.0, 1.0)
    limits = growth_limits(modes, free, rail.modes, contacts, [limit for limit in LIMITS if limit.case in cases])
    n = len(FREE_MODES)
    prior = Amplitudes((sign * lateral)[:n], (sign * normal)[:n], 1.0)
    return Problem(model, prior, np.stack([sign * lateral, sign * normal])[:, n:], paper, cases, limits)


def _search_group(problem: Problem, vector: Real, group: int) -> Real:
    """Return the vector with the amplitudes of one group replaced by the best of a global search.

    The first group, whose cells lie near the contact resonance, has the mass factor, too.
    """
    names, cells = GROUPS[group]
    n = len(FREE_MODES)
    columns = [FREE_MODES.index(name) for name in names]
    own = columns + [n + c for c in columns] + ([2 * n] if group == 0 else [])
    seen = columns + ([n, n + 1] if group == 0 else [])
    part = problem.model.part(seen, cells, *problem.amplitudes(vector))

    def cost(trial: Real) -> float:
        whole = vector.copy()
        whole[own] = trial
        lateral, normal = problem.amplitudes(whole)
        found = part.crossings(lateral[seen], normal[seen])
        wrong = cell_residuals(found, problem.paper, cells, problem.cases, SEARCH_SCATTER)
        return float(wrong @ wrong + trial @ trial)

    size = len(own)
    search = differential_evolution(
        cost, [(-1.6, 1.6)] * size, maxiter=60 if size < 5 else 200, popsize=12 if size < 5 else 8, rng=2,
        polish=False, tol=1e-8,
    )  # fmt: skip
    out = vector.copy()
    out[own] = search.x
    return out


def with_amplitudes(modes: Modes, amplitudes: Amplitudes, turn: Real) -> Modes:
    """Return the modes with identified amplitudes; `turn` is the rotation from track to contact axes."""
    shape = modes.shape @ turn.T
    for name, lateral, normal in zip(FREE_MODES, amplitudes.lateral, amplitudes.normal, strict=True):
        i = modes.labels.index(f"{name} cosine")
        sign = -1.0 if shape[i, 1] < 0 else 1.0
        shape[i, 1:3] = sign * lateral, sign * normal
    for name in RIGID:
        shape[modes.labels.index(f"{name} cosine"), 2] *= amplitudes.mass_factor
    return replace(modes, shape=shape @ turn)
