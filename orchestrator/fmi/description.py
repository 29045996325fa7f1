"""A model description in, FMPy's reading of it and its faults out.

Some faults change no number: they are mended where FMPy would stumble over them, and told. All others are errors.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import fmpy
from fmpy import read_model_description
from fmpy.model_description import DisplayUnit, ModelDescription, Unit
from fmpy.validation import validate_model_description
from lxml import etree

from ..errors import Fault, InputError

NAME = "modelDescription.xml"

_SCHEMAS = {"2": "fmi2/fmi2ModelDescription.xsd", "3": "fmi3/fmi3ModelDescription.xsd"}
"""Schemas that FMPy brings, by major version of FMI."""

_HARMLESS = re.compile(
    r"has no start value|but provides a start value|is not defined|Exactly one independent variable"
    r"|The combination causality="
)
"""What FMPy finds that changes no number: start values stay those inside the FMU, units keep their names."""


def read_description(folder: Path, path: Path) -> tuple[ModelDescription, list[Fault]]:
    """Return the model description of an unpacked FMU, and what is wrong with it though it changes no number.

    Parameters
    ----------
    folder : where the FMU is unpacked
    path : the FMU as the user knows it, for messages

    Raises
    ------
    InputError
        For any other fault; the message names the line.
    """
    shown = f"{path}: {NAME}"
    root = _parse(folder / NAME, shown)
    if root.get("fmiVersion", "").partition(".")[0] in _SCHEMAS:
        _check_schema(root, shown)
    faults = [Fault(f"{shown}, {text}") for text in _mend(root)]
    try:
        description = _read(folder, root if faults else None)
        faults += [Fault(f"{shown}, {text}") for text in _define_units(description)]
        problems = validate_model_description(description)
    except Exception as error:  # FMPy raises bare exceptions
        raise InputError(f"{shown} is not valid: {first_line(error)}") from None
    for problem in problems:
        if not _HARMLESS.search(problem):
            raise InputError(f"{shown} is not valid: {problem}")
        faults.append(Fault(f"{shown}: {problem}"))
    return description, faults


def _parse(file: Path, shown: str) -> etree._Element:
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        return etree.parse(file, parser).getroot()
    except (etree.XMLSyntaxError, OSError) as error:
        raise InputError(f"{shown} is not valid: {first_line(error)}") from None


@cache
def _schema(version: str) -> etree.XMLSchema:
    return etree.XMLSchema(file=str(Path(fmpy.__file__).parent / "schema" / _SCHEMAS[version]))


def _check_schema(root: etree._Element, shown: str) -> None:
    """Raise InputError unless a model description is valid against the schema of its version."""
    schema = _schema(root.get("fmiVersion").partition(".")[0])
    if not schema.validate(root):
        first = schema.error_log[0]
        raise InputError(f"{shown} is not valid: line {first.line}: {first.message}")


def _mend(root: etree._Element) -> Iterator[str]:
    """Give variables that are no real numbers a variability that they can have; yield what was wrong."""
    for variable in root.iterfind("ModelVariables/*"):
        two = variable.tag == "ScalarVariable"
        kind = next((child.tag for child in variable if child.tag != "Annotations"), "") if two else str(variable.tag)
        if kind in ("Real", "Float64", "Float32") or not isinstance(variable.tag, str):
            continue
        told = variable.get("variability")
        if told == "continuous" or (told is None and two):
            fixed = variable.get("causality") in ("parameter", "calculatedParameter", "structuralParameter")
            variable.set("variability", "fixed" if fixed else "discrete")
            yield (
                f"line {variable.sourceline}, variable {variable.get('name')!r}: is of type {kind} and has "
                f"{told or 'no'} variability; read as {variable.get('variability')}"
            )


def _read(folder: Path, mended: etree._Element | None) -> ModelDescription:
    """Return FMPy's reading of a model description, or of one that was mended."""
    if mended is None:
        return read_model_description(str(folder), validate=False)
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / NAME
        etree.ElementTree(mended).write(file, xml_declaration=True, encoding="UTF-8")
        return read_model_description(str(file), validate=False)


def _define_units(description: ModelDescription) -> Iterator[str]:
    """Add the units that variables have and nobody defines, without a definition; yield which."""
    known = {unit.name: unit for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        name = variable.unit or getattr(variable.declaredType, "unit", None)
        if name is not None and name not in known:
            known[name] = Unit(name=name)
            description.unitDefinitions.append(known[name])
            yield f"line {variable.sourceline}, variable {variable.name!r}: the unit {name!r} is not defined"
        shown = variable.displayUnit
        if shown is None or (name is not None and shown in [d.name for d in known[name].displayUnits]):
            continue
        if name is None:
            variable.displayUnit = None
            yield f"line {variable.sourceline}, variable {variable.name!r}: has a display unit and no unit"
        else:
            known[name].displayUnits.append(DisplayUnit(name=shown))
            yield f"line {variable.sourceline}, variable {variable.name!r}: the display unit {shown!r} is not defined"


def first_line(error: Exception) -> str:
    """Return the first line of what an exception says, the second too if the first announces it, or its name."""
    lines = str(error).strip().splitlines() or [type(error).__name__]
    return f"{lines[0]} {lines[1].lstrip('- ')}" if lines[0].endswith(":") and len(lines) > 1 else lines[0]
