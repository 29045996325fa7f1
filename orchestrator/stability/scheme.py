"""What each master algorithm does to the growth rates of a wheel on a rail: an assembled system in, figures out.

The system is linearised about its steady state from the parameters that its FMUs have: modes of wheel and rail, law of
the contact. Other FMUs do not show their equations; for them it is said why there is no figure.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.contact.linearised import STEP, LinearContact
from fmus.contact.parameters import PARAMETERS
from fmus.interface import DIRECTIONS, DISPLACEMENT_DIRECTIONS, STRUCTURES, connections
from fmus.modal.modes import Modes

from ..coupling.algorithms import ALGORITHMS
from ..coupling.assembly import Assembly
from ..coupling.master import Settings
from ..errors import InputError
from .loop import linear_contact
from .poles import Poles, exact_poles
from .step_map import BELOW_HZ, SchemeError, compare_growth, discrete_poles, step_map

SMALLEST_STEP = 1e-7
LARGEST_STEP = 1e-3
"""Steps between which the largest safe one is looked for [s]."""

TOLERATED = 0.5
"""Error of the growth rate of a weakly damped mode that a safe step may have [1/s]."""

_BISECTIONS = 5


@dataclass(frozen=True)
class ModalSystem:
    """A wheel on a rail with everything known that its linear behaviour needs.

    Attributes
    ----------
    wheel, rail : modes
    contact : the contact linearised at its steady state
    displacements : whether the contact takes displacements; else it integrates velocities
    """

    wheel: Modes
    rail: Modes
    contact: LinearContact
    displacements: bool

    @cached_property
    def poles(self) -> Poles:
        """Poles of the coupled system without any step."""
        return exact_poles(self.wheel, self.rail, self.contact)

    def at(self, step: float, algorithm: str) -> Growth:
        """Return what an algorithm makes of the growth rates at a communication step [s]."""
        matrix = step_map(self.wheel, self.rail, self.contact, step, algorithm, displacements=self.displacements)
        found = discrete_poles(matrix, step)
        modes = compare_growth(self.poles.below(BELOW_HZ), found)
        return Growth(modes, float(found.growth_rate.max(initial=0) - self.poles.growth_rate.max(initial=0)))

    def largest_safe_step(self, algorithm: str) -> float | None:
        """Return the largest step that is safe, and all octaves of which below it are; None if none is.

        Safe is what `Growth.safe` says. Given to two digits, rounded down.
        """
        good, bad = None, SMALLEST_STEP
        while bad <= LARGEST_STEP and self.at(bad, algorithm).safe:
            good, bad = bad, 2 * bad
        if good is None:
            return None
        for _ in range(_BISECTIONS if bad <= LARGEST_STEP else 0):
            middle = float(np.sqrt(good * bad))
            good, bad = (middle, bad) if self.at(middle, algorithm).safe else (good, middle)
        digits = 10.0 ** (np.floor(np.log10(good)) - 1)
        return float(f"{np.floor(good / digits + 1e-9) * digits:.1e}")


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


def as_json(system: ModalSystem, step: float) -> dict[str, Any]:
    """Return exact and discrete growth rates of every algorithm at a step, as `coupling --json` prints them."""
    result = {}
    for algorithm in ALGORITHMS:
        growth = system.at(step, algorithm)
        m = growth.modes
        result[algorithm] = {
            "max_growth_rate_error": m.largest,
            "max_growth_rate_error_weakly_damped": m.largest_weak,
            "stable_modes_made_unstable": m.invented,
            "largest_safe_step_s": system.largest_safe_step(algorithm),
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
    """

    largest: float | None
    sentence: str


def spurious_growth(assembly: Assembly, settings: Settings) -> Spurious:
    """Return what the algorithm does to the growth rates of the linearised system, or why that is not known."""
    pass

    try:
        growth = modal_system(assembly).at(settings.step, settings.algorithm)
    except InputError as reason:
        return Spurious(None, f"not known: {reason}")
    return Spurious(growth.modes.largest, growth.sentence(settings.algorithm, settings.step))


def modal_system(assembly: Assembly, modes: Callable[[Assembly, str], Modes] | None = None) -> ModalSystem:
    """Return the linear model of a system of this project's components, with the values that are set.

    Parameters
    ----------
    assembly : the system
    modes : gives the modes of a component of it; one that remembers them saves time

    Raises
    ------
    InputError
        If the system is another one, its FMUs show no modes, or the contact has no slope at its steady state; the
        sentence says which.
    """
    names = _places(assembly)
    wheel, rail = ((modes or modes_of)(assembly, names[s]) for s in STRUCTURES)
    known = {p.name for p in PARAMETERS}
    law = {name: value for name, value in _numbers(assembly, names["contact"]).items() if name in known}
    missing = sorted(known - law.keys())
    if missing:
        raise InputError(f"{names['contact']} has no parameter {missing[0]}, so its law is not known")
    return ModalSystem(wheel, rail, _without_rounding(linear_contact(law), law), bool(law["use_displacements"]))


def _without_rounding(contact: LinearContact, law: Mapping[str, float]) -> LinearContact:
    """Return the contact with the slopes that are only rounding of the finite difference set to zero."""
    arm = np.sqrt(law["semi_axis_lon"] * law["semi_axis_lat"])
    size = np.array([1.0, 1.0, arm])
    rounding = 10 * np.finfo(float).eps * law["mu0"] / (2 * STEP)  # of a force, relative to the load
    per_velocity = rounding * law["normal_load"] / law["rolling_velocity"] * np.outer(size, size)
    H1 = np.where(np.abs(contact.H1) > per_velocity, contact.H1, 0.0)
    return replace(contact, H1=H1, h2=np.where(np.abs(contact.h2) > rounding * size, contact.h2, 0.0))


def _places(assembly: Assembly) -> dict[str, str]:
    """Return which component is wheel, rail and contact, if they are connected just as the contract says."""
    if assembly.contact is None:
        raise InputError(
            "the system has no contact that takes interface mobilities, so its linear behaviour is not known"
        )
    found = {"contact": assembly.contact}
    by_input = {(link.wire.end_element, link.wire.end_connector): link for link in assembly.links}
    for s in STRUCTURES:
        link = by_input.get((assembly.contact, f"{s}_v_{DIRECTIONS[0]}"))
        if link is None:
            raise InputError(f"the contact has no input {s}_v_{DIRECTIONS[0]}, so its linear behaviour is not known")
        found[s] = link.wire.start_element
    further = sorted(set(assembly.fmus) - set(found.values()))
    if further or len(set(found.values())) != 3:
        what = f"a further component, {further[0]}" if further else "one component for wheel and rail"
        raise InputError(f"the system has {what}, so it is more than a wheel on a rail")
    used = {f"{s}_u_{d}" for s in STRUCTURES for d in DISPLACEMENT_DIRECTIONS}
    for wire in connections():
        key = (found[wire.end_element], wire.end_connector)
        link = by_input.get(key)
        start = (found[wire.start_element], wire.start_connector)
        if link is None and wire.end_connector in used:
            continue
        if link is None or (link.wire.start_element, link.wire.start_connector) != start:
            raise InputError(f"the system has no connection {'.'.join(start)} -> {'.'.join(key)} as the contract wants")
        if (link.gain, link.offset) != (1.0, 0.0):
            raise InputError(f"connection {link.wire} changes its value, so the structure is not the one its modes say")
    return found


def _numbers(assembly: Assembly, name: str) -> dict[str, float]:
    """Return the numeric parameters of a component: what is set, else the start values."""
    fmu = assembly.fmus[name]
    values: dict[str, float] = {}
    for parameter in fmu.names("parameter"):
        variable = fmu.variables[parameter]
        if variable.type == "String":
            continue
        value = assembly.parameters[name].get(parameter, variable.start)
        if isinstance(value, str):
            value = {"true": 1.0, "false": 0.0}.get(value.lower(), value)
        if value is not None:
            values[parameter] = float(value)
    return values


def modes_of(assembly: Assembly, name: str) -> Modes:
    """Return the modes of a component with the values that are set.

    Raises
    ------
    InputError
        If it shows none.
    """
    return modes_from_parameters(name, _numbers(assembly, name))


def modes_from_parameters(name: str, values: Mapping[str, float]) -> Modes:
    """Return the modes that a structure of this project has as parameters.

    Parameters
    ----------
    name : of the component, for messages
    values : all parameter values

    Raises
    ------
    InputError
        If there are no modal parameters, or not all of them.
    """
    numbers = sorted(m.group(1) for m in map(re.compile(r"frequency_(\d+)").fullmatch, values) if m)
    if not numbers and "step_size" not in values:
        raise InputError(f"{name} has no modes as parameters, so its linear behaviour is not known")
    columns = ["frequency", "damping_ratio", *(f"shape_{d}" for d in DIRECTIONS)]
    table: NDArray[np.float64] = np.zeros((len(numbers), len(columns)))
    for i, number in enumerate(numbers):
        for j, column in enumerate(columns):
            if f"{column}_{number}" not in values:
                raise InputError(f"{name} has a mode {number} without {column}, so its linear behaviour is not known")
            table[i, j] = values[f"{column}_{number}"]
    moving = table[:, 2:].any(axis=1)
    table = table[moving]
    return Modes(2 * np.pi * table[:, 0], table[:, 1], table[:, 2:])
