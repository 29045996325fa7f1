"""Stability of one system: wheel, rail and contact in; crossings, the wheel modes behind them and poles out."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import LinearContact
from fmus.modal.modes import Modes

from .eigenloci import Crossing, Eigenloci, clockwise_crossings, crossings, eigenloci, encirclements, frequency_grid
from .loop import Loop, Mobility, of_modes
from .poles import Poles, exact_poles

Real = NDArray[np.float64]

REPORTED_BELOW_HZ = 4500.0
"""Table 4 of the paper ends near 4 kHz; a (7,0) mode at 5 kHz is not part of it."""

_LARGEST_GROUP = 3
_CANDIDATES = 6
_SAME_FREQUENCY = 0.02
"""Relative distance within which a crossing with few modes counts as the one with all of them."""


@dataclass(frozen=True)
class Structures:
    """Wheel and rail, as mobilities and, where they are known, as modes.

    Attributes
    ----------
    wheel, rail : mobilities in track axes
    wheel_modes, rail_modes : None for black boxes; beside an analytical track, its modal equivalent
    resonances : frequencies [Hz] and damping ratios of the wheel; None: those of its modes
    """

    wheel: Mobility
    rail: Mobility
    wheel_modes: Modes | None = None
    rail_modes: Modes | None = None
    resonances: tuple[Real, Real] | None = None

    def frequencies(self) -> Real:
        """Return first angular frequencies, fine enough for the wheel [rad/s]."""
        if self.resonances is not None:
            return frequency_grid(*self.resonances, closed=False)
        if self.wheel_modes is not None:
            return frequency_grid(self.wheel_modes.omega / (2 * np.pi), self.wheel_modes.zeta)
        return frequency_grid(np.zeros(0), np.zeros(0), step_hz=0.1)


@dataclass(frozen=True)
class Instability:
    """A crossing beyond +1 and the wheel modes without which it would not be.

    Attributes
    ----------
    crossing : frequency, loop gain, direction
    modes : labels without family; empty where the wheel's modes are not known
    """

    crossing: Crossing
    modes: tuple[str, ...]


@dataclass(frozen=True)
class Stability:
    """What is known about the stability of a system.

    Attributes
    ----------
    loci : tracked eigenloci of the open loop
    instabilities : every crossing of the positive real axis beyond +1 below `REPORTED_BELOW_HZ`
    turns : (3,) clockwise encirclements of +1 by each locus, over all frequencies
    poles : of the closed loop, None where wheel or rail have no modes
    """

    loci: Eigenloci
    instabilities: tuple[Instability, ...]
    turns: Real
    poles: Poles | None

    @property
    def unstable_pairs(self) -> int:
        """Number of unstable pairs of poles by the generalised Nyquist criterion."""
        return round(float(self.turns.sum()))


def analyse(structures: Structures, contact: LinearContact) -> Stability:
    """Return the stability of a system."""
    loop = Loop(structures.wheel, structures.rail, contact)
    loci = eigenloci(loop.open_loop, structures.frequencies())
    found = [c for c in crossings(loop.open_loop, loci) if c.frequency_hz < REPORTED_BELOW_HZ]
    modes = structures.wheel_modes
    poles = None
    if modes is not None and structures.rail_modes is not None:
        poles = exact_poles(modes, structures.rail_modes, contact)
    instabilities = tuple(
        Instability(c, () if modes is None else involved(modes, structures.rail, contact, c)) for c in found
    )
    return Stability(loci, instabilities, encirclements(loci), poles)


def involved(modes: Modes, rail: Mobility, contact: LinearContact, crossing: Crossing) -> tuple[str, ...]:
    """Return the wheel modes that make a crossing: the fewest with which alone it remains.

    Notes
    -----
    The paper's check. Candidates are the elastic modes whose removal changes the loop most at the crossing; of several
    groups of one size that do, the one whose gain is nearest to that of the whole wheel. If no group of up to three
    modes does, because the crossing needs the normal compliance of the whole wheel, those modes of the candidates
    without which it would not be.
    """
    f = crossing.frequency_hz
    omega = 2 * np.pi * _near(f, modes)
    rail_there = rail(omega)
    candidates = _candidates(modes, rail, contact, f)
    for size in range(1, _LARGEST_GROUP + 1):
        kept = [
            (abs(np.log(gain / crossing.gain)), group)
            for group in combinations(candidates, size)
            for gain in _gains(modes.keep(list(group)), rail_there, contact, omega, f)
        ]
        if kept:
            return _names(modes, min(kept)[1])
    everything = set(range(len(modes)))
    return _names(
        modes,
        [i for i in candidates if not any(_gains(modes.keep(sorted(everything - {i})), rail_there, contact, omega, f))],
    )


def _names(modes: Modes, group: Sequence[int]) -> tuple[str, ...]:
    """Return the labels of some modes without their family, in the order of frequency."""
    return tuple(modes.labels[i].rpartition(" ")[0] for i in sorted(group, key=lambda i: modes.omega[i]))


def _candidates(modes: Modes, rail: Mobility, contact: LinearContact, frequency_hz: float) -> list[int]:
    """Return the elastic modes that matter most at a frequency."""
    omega = np.array([2 * np.pi * frequency_hz])
    there = rail(omega)

    def locus(kept: Sequence[int]) -> complex:
        return complex(Loop(of_modes(modes.keep(list(kept))), lambda _: there, contact).lateral(omega)[0])

    everything = list(range(len(modes)))
    whole = locus(everything)
    elastic = [i for i in everything if not modes.labels[i].startswith("rigid")]
    change = {i: abs(locus([k for k in everything if k != i]) - whole) for i in elastic}
    return sorted(elastic, key=lambda i: -change[i])[:_CANDIDATES]


def _near(frequency_hz: float, modes: Modes) -> Real:
    """Return frequencies about a crossing, fine enough for the least damped mode nearby [Hz]."""
    own = modes.omega / (2 * np.pi)
    close = np.abs(own / frequency_hz - 1) < 2 * _SAME_FREQUENCY
    width = float((modes.zeta * own)[close].min(initial=0.01 * frequency_hz))
    half = _SAME_FREQUENCY * frequency_hz
    return np.arange(frequency_hz - half, frequency_hz + half, max(width / 4, half / 3000))


def _gains(
    kept: Modes, rail_there: NDArray[np.complex128], contact: LinearContact, omega: Real, frequency_hz: float
) -> Iterator[float]:
    """Yield the gains beyond 1 with which the lateral locus of a few modes crosses the axis near a frequency."""
    locus = Loop(of_modes(kept), lambda _: rail_there, contact).lateral(omega)
    frequencies, gains = clockwise_crossings(omega / (2 * np.pi), locus)
    close = np.abs(frequencies / frequency_hz - 1) < _SAME_FREQUENCY
    yield from (float(g) for g in gains[close] if g > 1)


def without_normal_motion(modes: Modes, label: str, contact: LinearContact) -> Modes:
    """Return the modes with the normal displacement of one mode set to zero, as the paper does to its Case 3."""
    i = modes.labels.index(f"{label} cosine")
    shape = modes.shape @ contact.turn.T
    shape[i, 2] = 0.0
    return Modes(modes.omega, modes.zeta, shape @ contact.turn, modes.labels)
