"""What the stability commands are given, in words, and the structures and contacts that it means."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from fmus.cases import Case, read_cases
from fmus.contact.linearised import LinearContact
from fmus.contact.parameters import PARAMETERS
from fmus.interface import DEFAULT_STEP
from fmus.modal.data import read_modal_data
from fmus.modal.modes import Modes
from fmus.modal.parameters import modes_of
from fmus.rail.component import DATA as RAIL_DATA
from fmus.rail.track_data import TRACKS, read_track
from fmus.wheel.class158 import class158, identified_stiffness
from fmus.wheel.wheelset import DATA as WHEEL_DATA
from fmus.wheel.wheelset import read_wheelset

from ..coupling.assembly import open_fmus
from ..errors import InputError
from ..fmi.instance import Value, open_fmu
from ..probing.response import measure
from ..system.cases import SYSTEM_FILES, find_system
from ..system.kept import rail_named, track_file, track_names
from ..system.model import Element, System
from ..system.settable import labels_of, spread
from ..system.values import component_values
from .analysis import Stability, Structures, analyse
from .loop import Mobility, linear_contact, of_modes, of_track, remembered, rigid

CLASS158 = "class158"
WHEELS = {"wheel": CLASS158, "wheel-inferred": "inferred"}
"""Wheel of a case's FMU, by its file name without suffix."""

RIGID_RAIL = "rail-rigid"
ROUND_BODIES = 1.2e9
"""By Hertz for a wheel of 0.42 m radius on a rail head of 0.30 m; for wheels that no gain was fitted to [N/m]."""
NONE = Modes(np.zeros(0), np.zeros(0), np.zeros((0, 4)))
"""A structure without modes: it does not move."""


@dataclass(frozen=True)
class Wheel:
    """A wheel as the stability commands use it.

    Attributes
    ----------
    contact : parameters of the contact that go with the wheel, before those of a case
    """

    mobility: Mobility
    modes: Modes | None
    resonances: tuple[np.ndarray, np.ndarray] | None
    contact: Mapping[str, float]


@dataclass(frozen=True)
class Rail:
    """A rail as the stability commands use it."""

    mobility: Mobility
    modes: Modes | None


def find_wheel(text: str) -> Wheel:
    """Return the wheel of a name (class158, generic840, ...), a modal data file (.toml) or an FMU."""
    if text == CLASS158:
        modes = class158().modes
        return Wheel(remembered(of_modes(modes)), modes, None, {"hertz_stiffness": identified_stiffness()})
    path = Path(text)
    if path.suffix == ".fmu":
        response = measure(open_fmu(path), {}, DEFAULT_STEP)
        return Wheel(remembered(response.mobility), None, response.resonances(), {})
    own = WHEEL_DATA / f"{text}.toml"
    if not own.is_file() and not path.is_file():
        raise InputError(f"wheel {text}: neither {', '.join(wheel_names())} nor a .toml or .fmu file")
    try:
        modes = _wheel_modes(own if own.is_file() else path)
    except (ValueError, KeyError, OSError) as error:
        raise InputError(f"wheel {text}: {error}") from None
    contact = {"hertz_stiffness": ROUND_BODIES} if own.is_file() else {}
    return Wheel(remembered(of_modes(modes)), modes, None, contact)


def wheel_names() -> list[str]:
    """Return the names of the wheels that are shipped."""
    tables = (path for path in WHEEL_DATA.glob("*.toml") if "-" not in path.stem)
    return sorted({CLASS158, *(path.stem for path in tables)})


def _wheel_modes(path: Path) -> Modes:
    """Return the modes of a wheelset file or a modal data file."""
    if "modes" in tomllib.loads(path.read_text(encoding="utf-8")):
        return read_wheelset(path).modes
    return read_modal_data(path).modes


def find_rail(text: str) -> Rail:
    """Return the rail of 'analytic', 'modal', 'rigid', a track by name or file, or an FMU."""
    modal = read_modal_data(RAIL_DATA / "rail.toml").modes
    if text == "analytic":
        return Rail(remembered(of_track(read_track(TRACKS / "default.toml"))), modal)
    if text == "modal":
        return Rail(remembered(of_modes(modal)), modal)
    if text == "rigid":
        return Rail(rigid, NONE)
    track = track_file(text)
    if track is not None:
        fitted = {name: v.start for name, v in open_fmu(rail_named(text)).variables.items()}
        return Rail(remembered(of_track(read_track(track))), modes_of(fitted))
    if Path(text).suffix != ".fmu":
        names = ", ".join(track_names())
        raise InputError(f"rail {text}: must be analytic, modal, one of {names}, a track file or an .fmu file")
    return Rail(remembered(measure(open_fmu(Path(text)), {}, DEFAULT_STEP).mobility), None)


def find_case(text: str) -> Case | None:
    """Return the paper's case of that name, None for a file.

    Raises
    ------
    InputError
        If it is neither.
    """
    cases = {case.name: case for case in read_cases()}
    if text not in cases and Path(text).suffix not in SYSTEM_FILES:
        raise InputError(f"{text}: neither a case ({', '.join(cases)}) nor an .ssp, .ssd or .fmu file")
    return cases.get(text)


def case_inputs(case: Case, wheel: Wheel, rail: Rail) -> tuple[Structures, LinearContact]:
    """Return structures and contact of a case; its rigid rail stays rigid whatever rail is asked for."""
    if case.rail == RIGID_RAIL:
        rail = Rail(rigid, NONE)
    return structures_of(wheel, rail), linear_contact({**case.contact, **wheel.contact})


def structures_of(wheel: Wheel, rail: Rail) -> Structures:
    """Return a wheel and a rail as the analysis wants them."""
    return Structures(wheel.mobility, rail.mobility, wheel.modes, rail.modes, wheel.resonances)


def system_inputs(
    text: str, wheel: str | None = None, rail: str | None = None, changed: Changed | None = None
) -> tuple[Structures, LinearContact]:
    """Return structures and contact of a system file, measured on its FMUs unless others are asked for.

    Raises
    ------
    InputError
        If the system has not the components wheel, rail and contact.
    """
    system = find_system(text) if changed is None else changed.system
    missing = [name for name in ("wheel", "rail", "contact") if name not in system.elements]
    if missing:
        raise InputError(f"{text}: has no component {missing[0]!r}, so it is not a wheel on a rail")
    step = system.step_size or DEFAULT_STEP
    if wheel is None:
        response = measure(open_fmu(system.elements["wheel"].source), _values(system.elements["wheel"]), step)
        the_wheel = Wheel(response.mobility, None, response.resonances(), {})
    else:
        the_wheel = find_wheel(wheel)
    if rail is None:
        rail_fmu = open_fmu(system.elements["rail"].source)
        the_rail = Rail(measure(rail_fmu, _values(system.elements["rail"]), step).mobility, None)
    else:
        the_rail = find_rail(rail)
    contact = linear_contact({**the_wheel.contact, **_contact_values(system)})
    return structures_of(the_wheel, the_rail), contact


@dataclass(frozen=True)
class Changed:
    """A system with other values and FMUs.

    Attributes
    ----------
    system : with the changes
    values : that were set, by component and name
    replaced : names of the components that are other FMUs
    """

    system: System
    values: Mapping[str, Mapping[str, Value]]
    replaced: frozenset[str]

    @classmethod
    def of(cls, text: str, values: Mapping[str, Mapping[str, Value]], sources: Mapping[str, Path]) -> Changed:
        """Return a case or a system file with parameter values and FMU files by component."""
        system = find_system(text).with_sources(dict(sources))
        given = spread(values, open_fmus(system))
        return cls(system.with_parameters(given), given, frozenset(sources))

    def touches(self, name: str) -> bool:
        """Return whether a component is not as the system has it."""
        return name in self.values or name in self.replaced

    def modes(self, name: str) -> Modes | None:
        """Return the modes that a structure shows, with their labels; None if it shows none."""
        element = self.system.elements[name]
        fmu = open_fmu(element.source)
        starts = {name: v.start for name, v in fmu.variables.items() if v.causality == "parameter"}
        modes = modes_of({**starts, **_values(element)})
        return None if modes is None else replace(modes, labels=tuple(labels_of(fmu)))

    def wheel(self) -> Wheel:
        """Return the wheel, at its word where it shows its modes, else measured."""
        modes = self.modes("wheel")
        if modes is not None:
            return Wheel(remembered(of_modes(modes)), modes, None, {})
        element = self.system.elements["wheel"]
        response = measure(open_fmu(element.source), _values(element), DEFAULT_STEP)
        return Wheel(remembered(response.mobility), None, response.resonances(), {})

    def rail(self) -> Rail:
        """Return the rail, at its word where it shows its modes, else measured."""
        modes = self.modes("rail")
        if modes is not None:
            return Rail(remembered(of_modes(modes)), modes)
        element = self.system.elements["rail"]
        return Rail(remembered(measure(open_fmu(element.source), _values(element), DEFAULT_STEP).mobility), None)

    def contact(self) -> dict[str, float]:
        """Return the parameters of the contact that are not those of the case."""
        own = _contact_values(self.system)
        given = own if "contact" in self.replaced else self.values.get("contact", {})
        return {name: own[name] for name in own if name in given}


def _values(element: Element) -> dict[str, float]:
    """Return the parameter values of a component, as numbers in the FMU's own units."""
    values = component_values(element, open_fmu(element.source)).values
    return {name: float(value) for name, value in values.items() if not isinstance(value, str)}


def _contact_values(system: System) -> dict[str, float]:
    """Return the parameters of the contact that the linearised law has, too."""
    known = {variable.name for variable in PARAMETERS}
    return {k: v for k, v in _values(system.elements["contact"]).items() if k in known}


def find_stability(
    case: str, rail: str | None = None, wheel: str | None = None, changed: Changed | None = None
) -> Stability:
    """Return the stability of a case or a system file; `rail` and `wheel` by name, else as they are or are changed.

    Raises
    ------
    InputError
        For names and files that mean nothing, or another rail for a case whose rail is rigid.
    """
    known = find_case(case)
    if known is None:
        return analyse(*system_inputs(case, wheel, rail, changed))
    other = rail not in {None, "analytic", "modal"} or (changed is not None and "rail" in changed.replaced)
    if known.rail == RIGID_RAIL and other:
        raise InputError(f"rail {rail or 'replaced'}: {case} has a rigid rail; take {known.family}1 or {known.family}3")
    if changed is None:
        return analyse(*case_inputs(known, find_wheel(wheel or WHEELS[known.wheel]), find_rail(rail or "analytic")))
    by_name = wheel is not None or not changed.touches("wheel")
    the_wheel = find_wheel(wheel or WHEELS[known.wheel]) if by_name else changed.wheel()
    by_name = rail is not None or not changed.touches("rail")
    the_rail = find_rail("rigid" if known.rail == RIGID_RAIL else rail or "analytic") if by_name else changed.rail()
    contact = linear_contact({**known.contact, **the_wheel.contact, **changed.contact()})
    return analyse(structures_of(the_wheel, the_rail), contact)
