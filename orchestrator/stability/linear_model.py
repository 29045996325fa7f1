"""A wheel on a rail, linear: an assembled system or a results file in, structures, contact and poles out.

Structures that show their modes are taken at their word. One that does not is identified from its response, driven by
hand; it is never taken for rigid.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from fmus.contact.linearised import STEP, LinearContact
from fmus.contact.parameters import PARAMETERS, with_changes
from fmus.errors import DataError
from fmus.interface import DIRECTIONS, DISPLACEMENT_DIRECTIONS, STRUCTURES, connections
from fmus.modal.modes import Modes, mobility
from fmus.modal.parameters import as_declared, modes_of

from ..coupling.assembly import Assembly
from ..coupling.contact_mobility import bonds_of, power_pairs
from ..errors import InputError
from .eigenloci import Crossing, Eigenloci, crossings, eigenloci, frequency_grid
from .identified import identify
from .loop import Loop, linear_contact, of_modes, remembered
from .poles import Identified, Poles, Structure, exact_poles

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr


@dataclass(frozen=True)
class LinearModel:
    """A wheel on a rail with everything known that its linear behaviour needs.

    Attributes
    ----------
    wheel, rail : modes that move, or what was identified
    contact : linearised at its steady state
    integrated : wheel, rail or both: whose velocities the contact integrates, for want of their displacements
    identified : names of the components that show no modes
    law : all parameters of the running contact
    """

    wheel: Structure
    rail: Structure
    contact: LinearContact
    integrated: tuple[str, ...] = ()
    identified: tuple[str, ...] = ()
    law: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def poles(self) -> Poles:
        """Poles of the coupled system without any step."""
        return exact_poles(self.wheel, self.rail, self.contact)

    def open_loop(self, below_hz: float = np.inf) -> tuple[Eigenloci, tuple[Crossing, ...]]:
        """Return the eigenloci of the open loop, and where they cross the positive real axis beyond +1."""
        wheel, rail = self.modal()
        loop = Loop(remembered(of_modes(wheel)), remembered(of_modes(rail)), self.contact)
        loci = eigenloci(loop.open_loop, frequency_grid(wheel.omega / (2 * np.pi), wheel.zeta))
        return loci, tuple(c for c in crossings(loop.open_loop, loci) if c.frequency_hz < below_hz)

    def loop_gains(self, below_hz: float) -> dict[float, float]:
        """Return the loop gains of the instabilities by frequency [Hz], below a frequency."""
        return {c.frequency_hz: c.gain for c in self.open_loop(below_hz)[1]}

    def normal_ratio(self, frequency_hz: float) -> float:
        """Return the velocity of the rail over that of the wheel along the contact normal, |Y33r|/|Y33r + j omega/K|.

        Both feel the same normal force, and their approach is that force over the contact stiffness; what the creep
        forces add through the rail's cross mobility is left out.
        """
        omega = np.array([2 * np.pi * frequency_hz])
        rail = self.contact.turn @ mobility(omega, self.modal()[1])[0] @ self.contact.turn.T
        return float(abs(rail[2, 2]) / abs(rail[2, 2] + 1j * omega[0] / self.contact.stiffness))

    def modal(self) -> tuple[Modes, Modes]:
        """Return the modes of wheel and rail.

        Raises
        ------
        InputError
            If one of them shows none.
        """
        if isinstance(self.wheel, Identified) or isinstance(self.rail, Identified):
            raise InputError(f"{' and '.join(self.identified)}: shows no modes, so its eigenloci are not drawn")
        return self.wheel, self.rail


Remember = Callable[[str, Callable[[], Structure]], Structure]
"""Name of a component and how to find what it is in, that or what was found before for the same FMU and values out."""


def model_of_assembly(assembly: Assembly, step: float, remember: Remember = lambda _name, find: find()) -> LinearModel:
    """Return the linear model of a wheel on a rail, with the values that are set.

    Parameters
    ----------
    step : communication step, at which a structure that shows no modes is identified [s]
    remember : saves time where many models share their structures

    Raises
    ------
    InputError
        If the system is another one, or the contact has no slope at its steady state; the sentence says which.
    """
    names, plain = _places(assembly)
    known = {p.name for p in PARAMETERS}
    law = _with_changes(as_declared(_numbers(assembly, names["contact"], ("parameter", "input"))))
    law = {name: value for name, value in law.items() if name in known}
    missing = sorted(known - law.keys())
    if missing:
        raise InputError(f"{names['contact']} has no parameter {missing[0]}, so its law is not known")
    contact = _without_rounding(linear_contact(law), law)
    wheel, rail = (remember(names[s], partial(_structure, assembly, names[s], step, s in plain)) for s in STRUCTURES)
    hidden = tuple(names[s] for s, found in (("wheel", wheel), ("rail", rail)) if isinstance(found, Identified))
    law |= {name: float(bool(value)) for name, value in assembly.integration().items()}
    return LinearModel(wheel, rail, contact, _integrated(law), hidden, law)


def _structure(assembly: Assembly, name: str, step: float, plain: bool) -> Structure:
    """Return the modes that a component shows, if they are to be believed, else what its response tells."""
    modes = _shown(name, _numbers(assembly, name)) if plain else None
    return _identified(assembly, name, step) if modes is None else modes


def _shown(name: str, values: Mapping[str, Any]) -> Modes | None:
    """Return the modes that a component shows; None if it shows none."""
    try:
        return modes_of(values)
    except DataError as error:
        raise InputError(f"{name}: {error}, so its linear behaviour is not known") from None


def _identified(assembly: Assembly, name: str, step: float) -> Identified:
    """Return what the response of a structure's FMU tells of it."""
    fmu = assembly.fmus[name]
    pairs = power_pairs(bonds_of(assembly, name))
    return identify(fmu, assembly.parameters[name], step * assembly.periods(step)[name], pairs)


def model_of(data: xr.Dataset) -> LinearModel:
    """Return the linear model of a run from its results alone.

    Raises
    ------
    InputError
        If its components do not tell modes and contact as ours do; the sentence says which.
    """
    values: Mapping[str, Mapping[str, Any]] = json.loads(data.attrs.get("all_parameters", "{}"))
    structures = []
    for name in STRUCTURES:
        modes = _shown(name, values.get(name) or {})
        if modes is None:
            raise InputError(f"the results tell no modes of the {name}, so the poles of the system are not known")
        structures.append(modes)
    law = _with_changes(as_declared(values.get("contact") or {}))
    law = {k: v for k, v in law.items() if not k.startswith("mobility_")}
    if not law or any(not isinstance(value, float) for value in law.values()):
        raise InputError("the results tell no parameters of the contact, so the poles of the system are not known")
    return LinearModel(structures[0], structures[1], linear_contact(law), _integrated(law))


def _with_changes(law: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parameters of the contact with what its inputs add to them."""
    try:
        return with_changes(law)
    except DataError as error:
        raise InputError(f"contact: {error}, so its linear behaviour is not known") from None


def _integrated(law: Mapping[str, float]) -> tuple[str, ...]:
    """Return the sides whose velocities the contact integrates."""
    if not law["use_displacements"]:
        return STRUCTURES
    return tuple(s for s in STRUCTURES if law[f"integrate_{s}"])


def _without_rounding(contact: LinearContact, law: Mapping[str, float]) -> LinearContact:
    """Return the contact with the slopes that are only rounding of the finite difference set to zero."""
    arm = np.sqrt(law["semi_axis_lon"] * law["semi_axis_lat"])
    size = np.array([1.0, 1.0, arm])
    rounding = 10 * np.finfo(float).eps * law["mu0"] / (2 * STEP)  # of a force, relative to the load
    per_velocity = rounding * law["normal_load"] / law["rolling_velocity"] * np.outer(size, size)
    H1 = np.where(np.abs(contact.H1) > per_velocity, contact.H1, 0.0)
    return replace(contact, H1=H1, h2=np.where(np.abs(contact.h2) > rounding * size, contact.h2, 0.0))


def component_names(assembly: Assembly) -> dict[str, str]:
    """Return which component is wheel, rail and contact; errors as of `model_of_assembly`."""
    return _places(assembly)[0]


def _places(assembly: Assembly) -> tuple[dict[str, str], set[str]]:
    """Return which component is wheel, rail and contact, and which structures are connected just as the contract says.

    A structure that is connected otherwise, with other names or units, is not the one that its modes say.
    """
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
    plain = set(STRUCTURES)
    used = {f"{s}_u_{d}" for s in STRUCTURES for d in DISPLACEMENT_DIRECTIONS}
    for wire in connections():
        link = by_input.get((found[wire.end_element], wire.end_connector))
        start = (found[wire.start_element], wire.start_connector)
        if link is None and wire.end_connector in used:
            continue
        structure = wire.start_element if wire.start_element in STRUCTURES else wire.end_element
        as_is = link is not None and (link.gain, link.offset) == (1.0, 0.0)
        if link is None or (link.wire.start_element, link.wire.start_connector) != start or not as_is:
            plain.discard(structure)
    for s in STRUCTURES:
        missing = set(DIRECTIONS) - bonds_of(assembly, found[s]).keys()
        if s not in plain and missing == set(DIRECTIONS):
            raise InputError(f"{found[s]} exchanges no force and velocity with the contact")
    return found, plain


def _numbers(assembly: Assembly, name: str, causalities: Sequence[str] = ("parameter",)) -> dict[str, float]:
    """Return the numeric parameters of a component: what is set, else the start values."""
    fmu = assembly.fmus[name]
    values: dict[str, float] = {}
    for parameter in (n for c in causalities for n in fmu.names(c)):
        variable = fmu.variables[parameter]
        if variable.type == "String":
            continue
        value = assembly.parameters[name].get(parameter, variable.start)
        if isinstance(value, str):
            value = {"true": 1.0, "false": 0.0}.get(value.lower(), value)
        if value is not None:
            values[parameter] = float(value)
    return values
