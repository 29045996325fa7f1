"""What an FMU declares against the contract of a rail: names, units, causality. Nothing runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..errors import InputError
from ..fmi.instance import Fmu
from ..units import conversion
from .rail import OPTIONAL, PORTS, Signal

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
    return [names, units, _row("causality", faults, "4 force inputs, the rest outputs")], factors


def _check_names(fmu: Fmu, mapping: Mapping[str, Signal], present: Mapping[str, Signal]) -> Check:
    """Return the row on names: all that the contact needs is there, and every input is fed."""
    faults = [f"{name}: the FMU has no variable {mapping[name].variable!r}" for name in mapping if name not in present]
    missing = [name for name in PORTS if name not in mapping and name not in OPTIONAL]
    if missing:
        faults.append(f"missing: {', '.join(missing)}")
    fed = {signal.variable for name, signal in present.items() if name.startswith("f_")}
    unfed = [name for name in fmu.names("input") if name not in fed]
    if unfed:
        faults.append(f"inputs that nothing feeds: {', '.join(unfed)}")
    without = [name for name in OPTIONAL if name not in mapping]
    said = f"without {', '.join(without)}, which the contact does not need" if without else f"all {len(PORTS)}"
    return _row("names", faults, said)


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
