"""Treatments named on a run: damping of modes by label, and wheels by name; texts in, parameter values and FMUs out."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from pathlib import Path

from fmus.errors import DataError
from fmus.modal.layout import DAMPING_RATIO
from fmus.modal.parameters import names_of
from fmus.packaging.target import default_target
from fmus.wheel.component import wheel
from fmus.wheel.treatment import matching, read_rule

from ..coupling.assembly import open_fmus
from ..errors import InputError
from ..fmi.instance import Value
from ..stability.cases import find_wheel
from ..system.cases import find_system
from ..system.kept import kept_fmu, structure_key
from ..system.settable import labels_of
from ..system.values import component_values

DEFAULT_COMPONENT = "wheel"
"""Whose labels are meant where a rule names no component."""


def damping_values(
    system: str, sources: Mapping[str, Path], values: Mapping[str, Mapping[str, Value]], rules: Sequence[str]
) -> dict[str, dict[str, Value]]:
    """Return parameter values that damp modes, in addition to others.

    Parameters
    ----------
    system : a case, an .ssp or an .ssd file
    sources : FMUs that take a component's place
    values : parameter values by component and name, of which the result is a copy with damping ratios added
    rules : '(3,0)=1e-3' and '(*,0)=+1e-4' of the wheel's labels, 'rail:lat 1=0.2' of another component's, 'wheel=x2'

    Raises
    ------
    InputError
        For a rule that is none, or means no mode of the system.
    """
    found = find_system(system).with_sources(dict(sources))
    fmus = open_fmus(found)
    result = {name: dict(own) for name, own in values.items()}
    for text in rules:
        try:
            rule = read_rule(text)
            component, _, pattern = rule.target.rpartition(":")
            component = component or (rule.target if rule.target in fmus else DEFAULT_COMPONENT)
            if component not in fmus:
                raise DataError(f"damping {text!r}: there is no component {component}; has {', '.join(sorted(fmus))}")
            names = names_of(DAMPING_RATIO, fmus[component].variables)
            if not names:
                raise DataError(f"damping {text!r}: {component} shows no modes")
            places = range(len(names)) if rule.target == component else matching(labels_of(fmus[component]), pattern)
        except DataError as error:
            raise InputError(str(error)) from None
        own = result.setdefault(component, {})
        before = {**component_values(found.elements[component], fmus[component]).values, **own}
        for place in places:
            name = names[sorted(names)[place]]
            own[name] = rule.of(float(before.get(name, fmus[component].variables[name].start or 0.0)))
    return result


def wheel_named(text: str) -> tuple[Path, Mapping[str, float]]:
    """Return the FMU of a wheel, and the parameters of the contact that go with it.

    Parameters
    ----------
    text : an .fmu file, a shipped wheel such as generic840, or a file of modal data (.toml)

    Raises
    ------
    InputError
        If it is none of them.
    """
    path = Path(text)
    if path.suffix == ".fmu":
        return path, {}
    found = find_wheel(text)
    if found.modes is None:
        raise InputError(f"wheel {text}: has no modes, so no FMU can be made of it")
    component = wheel(found.modes)
    starts = "\n".join(f"{v.name}={v.start!r} {v.description}" for v in component.of("parameter"))
    key = hashlib.sha256(f"{default_target()}\n{structure_key()}\n{starts}".encode()).hexdigest()[:16]
    return kept_fmu("wheels", f"{path.stem}-{key}", lambda: component), found.contact
