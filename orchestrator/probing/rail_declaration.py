"""What an FMU declares against the contract of a rail: names, units, causality. Nothing runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fmus.interface import DIRECTIONS

from ..errors import InputError
from ..fmi.instance import Fmu
from ..units import conversion
from .rail import DISPLACEMENTS, OPTIONAL, PORTS, Signal

PASS, FAIL, NOT_OFFERED, NOT_RUN = "pass", "fail", "not offered", "not run"


@dataclass(frozen=True)
class Check:
    """One row: a demand, how it ended and the numbers behind it."""

    name: str
    status: str
    detail: str


def check_declaration(fmu: Fmu, mapping: Mapping[str, Signal]) -> tuple[list[Check], dict[str, float]]:
    """Return the rows on names, units and causality, and the factors to SI units."""
    present = {name: signal for name, signal in mapping.items() if signal.variable in fmu.variables}
    names = _check_names(fmu, mapping, present)
    if not present:
        return [names, Check("units", NOT_RUN, ""), Check("causality", NOT_RUN, "")], {}
    units, factors = _check_units(fmu, present)
    faults = []
    for name, signal in present.items():
        variable, wanted = fmu.variables[signal.variable], "input" if name.startswith("f_") else "output"
        if (variable.causality, variable.type) != (wanted, "Real"):
            faults.append(f"{signal.variable} is {variable.causality} of type {variable.type}; must be {wanted}, Real")
    forces = [name for name in present if name.startswith("f_")]
    if forces and _is_impedance(fmu, present):
        faults = ["it takes velocities and gives forces; a rail must take forces and give velocities"]
    return [names, units, _row("causality", faults, f"{len(forces)} force inputs, the rest outputs")], factors


def _is_impedance(fmu: Fmu, present: Mapping[str, Signal]) -> bool:
    """Return whether all forces are outputs and all velocities inputs."""
    wanted = {"f": "output", "v": "input"}
    found = [fmu.variables[s.variable].causality == wanted[name[0]] for name, s in present.items() if name[0] in wanted]
    return all(found)


def rigid_directions(mapping: Mapping[str, Signal]) -> tuple[str, ...]:
    """Return the directions in which nothing of the contract is there, though there are others: rigid ones."""
    missing = tuple(d for d in DIRECTIONS if not any(f"{kind}_{d}" in mapping for kind in "fvu"))
    return missing if len(missing) < len(DIRECTIONS) else ()


def _check_names(fmu: Fmu, mapping: Mapping[str, Signal], present: Mapping[str, Signal]) -> Check:
    """Return the row on names: all that the contact needs is there, and every input is fed."""
    faults = [f"{name}: the FMU has no variable {mapping[name].variable!r}" for name in mapping if name not in present]
    rigid = rigid_directions(mapping)
    needless = {*OPTIONAL, *(f"{kind}_{d}" for kind in "fvu" for d in rigid)}
    velocities_alone = not any(name in mapping for name in DISPLACEMENTS)
    needless |= set(DISPLACEMENTS) if velocities_alone else set()
    missing = [name for name in PORTS if name not in mapping and name not in needless]
    if missing:
        faults.append(f"missing: {', '.join(missing)}{_other_case(fmu, missing)}")
    fed = {signal.variable for name, signal in present.items() if name.startswith("f_")}
    unfed = [name for name in fmu.names("input") if name not in fed]
    without = [name for name in OPTIONAL if name not in mapping and name[2:] not in rigid]
    said = [f"without {', '.join(without)}, which the contact does not need"] if without else []
    said += ["velocities alone, which the contact integrates"] if velocities_alone else []
    said += [f"rigid in {', '.join(rigid)}"] if rigid else []
    said += [f"{', '.join(unfed)} at the start value"] if unfed else []
    return _row("names", faults, "; ".join(said) or f"all {len(PORTS)}")


def _other_case(fmu: Fmu, missing: Sequence[str]) -> str:
    """Return the mapping that makes up for names that differ in capitals only, to be given by the user."""
    names = {name.lower(): name for name in fmu.variables}
    found = [f"{name}={names[name]}" for name in missing if name in names]
    return f"; names differ in capitals only: map {', '.join(found)}" if found else ""


def _check_units(fmu: Fmu, mapping: Mapping[str, Signal]) -> tuple[Check, dict[str, float]]:
    """Return the row on units and what turns each variable into the contract's unit."""
    factors, faults, silent = {}, [], []
    for name, signal in mapping.items():
        unit = fmu.unit(signal.variable) or signal.unit
        factors[name] = 1.0
        if unit is None:
            silent.append(signal.variable)
            continue
        try:
            factors[name], _ = conversion(unit, PORTS[name].unit, signal.variable)
        except InputError as error:
            faults.append(str(error))
    if silent and not faults:
        return Check("units", NOT_OFFERED, f"{len(silent)} variables without a unit are taken as SI"), factors
    converted = sum(factor != 1.0 for factor in factors.values())
    return _row("units", faults, f"{converted} converted" if converted else "SI"), factors


def _row(name: str, faults: Sequence[str], said: str) -> Check:
    """Return a failed row with its faults, or a passed one."""
    return Check(name, FAIL, "; ".join(faults)) if faults else Check(name, PASS, said)
