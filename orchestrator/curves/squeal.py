"""What each wheel of a bogie in a curve does to wheel and rail: operating points in, unstable tones out.

The wheel is read where the curve puts the contact, the rail with its offset from the crown. Loop gains are those of
the analytical track; growth rates those of its modal equivalent, which knows the crown only.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import LinearContact
from fmus.contact.parameters import PARAMETERS
from fmus.curving.bogie import PLACES, Bogie, BogieState, Curve, WheelState
from fmus.errors import DataError
from fmus.modal.data import read_modal_data
from fmus.modal.modes import Modes
from fmus.rail.component import DATA as RAIL_DATA
from fmus.rail.track_data import TRACKS, Track, read_track
from fmus.wheel.wheelset import TREAD

from ..errors import InputError
from ..stability.eigenloci import Crossing, crossings, eigenloci, frequency_grid
from ..stability.loop import Loop, Mobility, linear_contact, of_modes, of_track, remembered, rigid
from ..stability.poles import closed_loop_matrix
from .inputs import TreadWheel

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]

FROM_HZ = 20.0
BELOW_HZ = 4500.0
"""Tones that are looked for: audible, and as far as the paper's table goes [Hz]."""

SQUEAL_FROM_HZ = 150.0
"""Below this a tone is the axle's bending, not squeal [Hz]."""

_SAME = 0.02
"""Relative distance of a pole and a crossing that are one tone."""

_LARGEST_OFFSET = 0.05
"""On the rail's head [m]."""

_MANY = 2000
"""Frequencies from which on mobilities are remembered, as `remembered` does."""


@dataclass(frozen=True)
class Rail:
    """The rail under the wheel.

    Attributes
    ----------
    name : analytic, modal or rigid
    track : None unless analytic
    modes : of the modal equivalent, read at the crown
    """

    name: str
    track: Track | None
    modes: Modes

    def mobility(self, position: float) -> Mobility:
        """Return the mobility at a distance from the crown to the field side [m]; a modal rail knows the crown only."""
        if self.track is not None:
            return of_track(replace(self.track, contact_offset=-position))
        return of_modes(self.modes) if len(self.modes) else rigid


def by_position(at: Callable[[float], Mobility], degree: int, reach: float) -> Callable[[float], Mobility]:
    """Return the same mobilities by position, computed once where many frequencies are asked for again.

    Parameters
    ----------
    at : mobility at a position, a polynomial in it
    degree : of the polynomial
    reach : positions it is interpolated between, to either side [m]
    """
    nodes = reach * np.cos(np.pi * (np.arange(degree + 1) + 0.5) / (degree + 1))
    kept = [remembered(at(float(x))) for x in nodes]

    def mobility(position: float) -> Mobility:
        weights = [np.prod([(position - y) / (x - y) for y in nodes if y != x]) for x in nodes]

        def evaluate(omega: Real) -> Complex:
            if omega.size < _MANY:
                return at(position)(omega)
            return np.asarray(sum(w * f(omega) for w, f in zip(weights, kept, strict=True)))

        return evaluate

    return mobility


@dataclass(frozen=True)
class Tone:
    """An unstable tone of a wheel.

    Attributes
    ----------
    frequency_hz : where the eigenlocus crosses the positive real axis
    loop_gain : modulus there, > 1
    growth_rate : of the closed loop's pole there [1/s]; negative where the locus goes back beyond +1 and nothing grows
    mode : wheel mode that moves most in it
    """

    frequency_hz: float
    loop_gain: float
    growth_rate: float
    mode: str


@dataclass(frozen=True)
class SingingWheel:
    """A wheel in a curve.

    Attributes
    ----------
    state : its operating point
    tones : unstable ones, in the order of frequency
    on_tread : whether the wheel's modes are known there; beyond they are extrapolated
    velocity_guess : amplitude of the lateral velocity of a limit cycle, 1.1 V |gamma2| as a first guess [m/s]
    """

    state: WheelState
    tones: tuple[Tone, ...]
    on_tread: bool
    velocity_guess: float

    @property
    def squeal(self) -> Tone | None:
        """The tone that grows fastest, of those that are squeal."""
        high = [t for t in self.tones if t.frequency_hz >= SQUEAL_FROM_HZ and t.growth_rate > 0]
        return max(high, key=lambda t: t.growth_rate, default=None)


def find_rail(text: str) -> Rail:
    """Return the rail of 'analytic', 'modal' or 'rigid'."""
    if text == "rigid":
        return Rail(text, None, Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4))))
    if text not in ("analytic", "modal"):
        raise InputError(f"track {text}: must be analytic, modal or rigid")
    modes = read_modal_data(RAIL_DATA / "rail.toml").modes
    return Rail(text, read_track(TRACKS / "default.toml") if text == "analytic" else None, modes)


CONTACT_NAMES = (
    "normal_load", "steady_creepage_lon", "steady_creepage_lat", "steady_creepage_spin", "contact_angle",
    "semi_axis_lon", "semi_axis_lat", "hertz_stiffness",
)  # fmt: skip
"""What the contact takes from the vehicle by the same name."""


def contact_parameters(state: WheelState, curve: Curve, friction: Mapping[str, float]) -> dict[str, float]:
    """Return the parameters of the contact component at an operating point."""
    point = {name: getattr(state, name) for name in CONTACT_NAMES}
    return {**point, "mu0": curve.friction, "rolling_velocity": curve.speed, **friction}


def sing(
    bogie: Bogie,
    curve: Curve,
    wheel: TreadWheel,
    rail: Rail,
    friction: Mapping[str, float],
    report: Callable[[str], None] = lambda _: None,
) -> dict[str, SingingWheel]:
    """Return what each wheel does in a curve, by `PLACES`.

    Parameters
    ----------
    friction : parameters of the contact's friction law
    report : called with each wheel's name before it is looked at
    """
    state = solve(bogie, curve)
    wheel_at = by_position(lambda position: of_modes(wheel.at(position)), 4, TREAD) if wheel.wheelset else None
    rail_at = by_position(rail.mobility, 2, _LARGEST_OFFSET)
    result = {}
    for place in PLACES:
        report(place)
        point = state.place(curve.curvature, place)
        parameters = contact_parameters(point, curve, friction) | dict(wheel.contact)
        contact = linear_contact(_within(parameters, place))
        modes = wheel.at(point.wheel_position)
        offset = float(np.clip(point.rail_position, -_LARGEST_OFFSET, _LARGEST_OFFSET))
        result[place] = SingingWheel(
            point,
            unstable_tones(
                wheel_at(point.wheel_position) if wheel_at else of_modes(modes),
                rail_at(offset),
                modes,
                rail.modes,
                contact,
            ),
            abs(point.wheel_position) <= TREAD,
            1.1 * curve.speed * abs(point.steady_creepage_lat),
        )
    return result


def solve(bogie: Bogie, curve: Curve) -> BogieState:
    """Return the bogie's state, a missing one as a mistake of the user's."""
    try:
        return bogie.solve(curve)
    except DataError as error:
        raise InputError(str(error)) from None


def _within(parameters: Mapping[str, float], place: str) -> Mapping[str, float]:
    """Return the parameters if the contact component takes them."""
    limits = {p.name: p for p in PARAMETERS}
    for name, value in parameters.items():
        try:
            limits[name].check(value)
        except DataError as error:
            raise InputError(f"{place.replace('_', ' ')} wheel: {error}") from None
    return parameters


def unstable_tones(
    wheel: Mobility, rail: Mobility, modes: Modes, rail_modes: Modes, contact: LinearContact
) -> tuple[Tone, ...]:
    """Return the unstable tones of a wheel on a rail: clockwise crossings of the eigenloci beyond +1.

    Parameters
    ----------
    wheel, rail : mobilities at the contact
    modes, rail_modes : for growth rates and names
    """
    loop = Loop(wheel, rail, contact)
    grid = frequency_grid(modes.omega / (2 * np.pi), modes.zeta, highest_hz=1.05 * BELOW_HZ, closed=False)
    loci = eigenloci(loop.open_loop, grid)
    found = [c for c in crossings(loop.open_loop, loci) if c.clockwise and FROM_HZ < c.frequency_hz < BELOW_HZ]
    poles = _poles(modes, rail_modes, contact) if found else []
    return tuple(_tone(crossing, poles, modes) for crossing in found)


def _poles(modes: Modes, rail: Modes, contact: LinearContact) -> list[tuple[float, float, int]]:
    """Return frequency, growth rate and number of the wheel mode that moves most, of each pole."""
    values, vectors = np.linalg.eig(closed_loop_matrix(modes, rail, contact))
    n = len(modes)
    return [
        (float(v.imag / (2 * np.pi)), float(v.real), int(np.abs(x[:n]).argmax()))
        for v, x in zip(values, vectors.T, strict=True)
        if v.imag > 0
    ]


def _tone(crossing: Crossing, poles: list[tuple[float, float, int]], modes: Modes) -> Tone:
    """Return the tone of a crossing, with the pole that grows fastest of those near it."""
    f = crossing.frequency_hz
    near = [p for p in poles if abs(p[0] / f - 1) < _SAME] or [min(poles, key=lambda p: abs(p[0] - f))]
    _, rate, number = max(near, key=lambda p: p[1])
    return Tone(f, crossing.gain, rate, modes.labels[number].rpartition(" ")[0] if modes.labels else "")
