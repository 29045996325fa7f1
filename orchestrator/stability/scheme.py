"""What each master algorithm does to the growth rates of a wheel on a rail: an assembled system in, figures out.

The system is linearised about its steady state: modes of wheel and rail as parameters of their FMUs, or their response
where they show none; the law of the contact. For other systems it is said why there is no figure.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..coupling.algorithms import ALGORITHMS
from ..coupling.assembly import Assembly
from ..coupling.settings import Settings
from ..errors import InputError
from .linear_model import LinearModel, model_of_assembly
from .step_map import BELOW_HZ, SchemeError, compare_growth, discrete_poles, step_map

SMALLEST_STEP = 1e-7
LARGEST_STEP = 1e-3
"""Steps between which the largest safe one is looked for [s]."""

TOLERATED = 0.5
"""Error of the growth rate of a weakly damped mode that a safe step may have [1/s]."""

_BISECTIONS = 5


@dataclass(frozen=True)
class Growth:
    """Growth rates of a scheme against the exact ones.

    Attributes
    ----------
    modes : exact and discrete growth rates below 5 kHz
    fastest_added : growth rate of the fastest of all discrete poles beyond the fastest exact one [1/s]
    """

    modes: SchemeError
    fastest_added: float

    @property
    def safe(self) -> bool:
        """Whether no stable mode grows, weakly damped modes are right to 0.5 1/s, and nothing else grows."""
        return self.modes.invented == 0 and self.modes.largest_weak <= TOLERATED and self.fastest_added <= TOLERATED

    def sentence(self, algorithm: str, step: float) -> str:
        """Return the figures as a run states them."""
        m = self.modes
        if not m.exact.size:
            return f"none: no mode below {BELOW_HZ / 1e3:g} kHz vibrates"
        k = int(np.abs(m.error).argmax())
        made = "no stable mode" if m.invented == 0 else f"{m.invented} stable mode{'s' if m.invented > 1 else ''}"
        return (
            f"at most {m.largest:.2g} 1/s below {BELOW_HZ / 1e3:g} kHz ({m.frequency_hz[k]:.0f} Hz, exact "
            f"{m.exact[k]:.4g} 1/s), {m.largest_weak:.2g} 1/s for weakly damped modes; {algorithm} at {step:g} s "
            f"makes {made} unstable"
        )


def growth_of_scheme(model: LinearModel, step: float, algorithm: str, below_hz: float = BELOW_HZ) -> Growth:
    """Return what an algorithm makes of the growth rates at a communication step [s]."""
    matrix = step_map(model.wheel, model.rail, model.contact, step, algorithm, model.integrated)
    found = discrete_poles(matrix, step)
    modes = compare_growth(model.poles.below(below_hz), found)
    return Growth(modes, float(found.growth_rate.max(initial=0) - model.poles.growth_rate.max(initial=0)))


def largest_safe_step(model: LinearModel, algorithm: str) -> float | None:
    """Return the largest step that is safe, and all octaves of which below it are; None if none is.

    Safe is what `Growth.safe` says. Given to two digits, rounded down.
    """
    good, bad = None, SMALLEST_STEP
    while bad <= LARGEST_STEP and growth_of_scheme(model, bad, algorithm).safe:
        good, bad = bad, 2 * bad
    if good is None:
        return None
    for _ in range(_BISECTIONS if bad <= LARGEST_STEP else 0):
        middle = float(np.sqrt(good * bad))
        good, bad = (middle, bad) if growth_of_scheme(model, middle, algorithm).safe else (good, middle)
    digits = 10.0 ** (np.floor(np.log10(good)) - 1)
    return float(f"{np.floor(good / digits + 1e-9) * digits:.1e}")


def as_json(model: LinearModel, step: float) -> dict[str, Any]:
    """Return exact and discrete growth rates of every algorithm at a step, as data."""
    result = {}
    for algorithm in ALGORITHMS:
        growth = growth_of_scheme(model, step, algorithm)
        m = growth.modes
        result[algorithm] = {
            "max_growth_rate_error": m.largest,
            "max_growth_rate_error_weakly_damped": m.largest_weak,
            "stable_modes_made_unstable": m.invented,
            "largest_safe_step_s": largest_safe_step(model, algorithm),
            "modes": [
                {"frequency_hz": float(f), "exact": float(e), "discrete": float(d)}
                for f, e, d in zip(m.frequency_hz, m.exact, m.discrete, strict=True)
            ],
        }
    return result


@dataclass(frozen=True)
class Spurious:
    """Growth that the coupling adds.

    Attributes
    ----------
    largest : largest error of a growth rate below 5 kHz [1/s]; None if it is not known
    sentence : the figures, or why there are none
    invented : number of stable modes that it makes unstable
    fastest : frequency [Hz] and exact growth rate [1/s] of what grows fastest; None if nothing does, or it is not known
    """

    largest: float | None
    sentence: str
    invented: int = 0
    fastest: tuple[float, float] | None = None


def spurious_growth(assembly: Assembly, settings: Settings) -> Spurious:
    """Return what the algorithm does to the growth rates of the linearised system, or why that is not known."""
    try:
        model = model_of_assembly(assembly, settings.step)
        growth = growth_of_scheme(model, settings.step, settings.algorithm)
    except InputError as reason:
        return Spurious(None, f"not known: {reason}")
    m = growth.modes
    k = int(m.exact.argmax()) if m.exact.size else None
    fastest = None if k is None or m.exact[k] <= 0 else (float(m.frequency_hz[k]), float(m.exact[k]))
    return Spurious(m.largest, growth.sentence(settings.algorithm, settings.step), m.invented, fastest)
