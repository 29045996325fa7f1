"""The documentation that goes into an FMU, made from its declaration."""

from __future__ import annotations

import math
from html import escape
from importlib.metadata import distribution

from ...component import Component, Variable

_PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><title>{name}</title>
<style>body{{font-family:sans-serif;max-width:70em;margin:2em auto;padding:0 1em}}
td,th{{text-align:left;padding:.1em .6em;border-bottom:1px solid #ccc}}</style></head>
<body><h1>{name}</h1><p>{description}. Part of curvesqueal {version}.</p>
<p>Forces are held over a communication step; outputs are those at its end. SI units. Axes: lon along the track, lat to
the gauge side, ver upwards, spin about the vertical axis.</p>
{tables}</body></html>
"""

_DEPENDENCIES = """This FMU runs Python code. The host needs Python 3.11 or later with its shared library in the
process (see PythonFMU's documentation), and the package numpy. With the package numba the code is compiled.
"""


def documentation_files(component: Component, version: str, python: bool) -> dict[str, bytes]:
    """Return the files of the folder `documentation` by their names in the FMU.

    Parameters
    ----------
    python : whether the FMU runs Python code
    """
    files = {"documentation/index.html": _page(component, version)}
    if python:
        files["documentation/externalDependencies.txt"] = _DEPENDENCIES
    files["documentation/licenses/license.txt"] = _license()
    return {name: text.encode() for name, text in files.items()}


def _license() -> str:
    """Return this project's licence as its installed metadata has it: no path that another project's could lie on."""
    text = distribution("curvesqueal").read_text("licenses/LICENSE")
    if text is None:
        raise FileNotFoundError("the installed metadata of curvesqueal has no licenses/LICENSE")
    return text


def _page(component: Component, version: str) -> str:
    tables = "".join(
        f"<h2>{title}</h2><table><tr><th>name<th>unit<th>start<th>range<th>meaning</tr>"
        + "".join(_row(v) for v in component.of(causality))
        + "</table>\n"
        for title, causality in (
            ("Inputs", "input"),
            ("Outputs", "output"),
            ("Local variables", "local"),
            ("Calculated parameters", "calculatedParameter"),
            ("Parameters", "parameter"),
        )
        if component.of(causality)
    )
    return _PAGE.format(name=component.name, description=escape(component.description), version=version, tables=tables)


def _row(variable: Variable) -> str:
    limits = ""
    if math.isfinite(variable.minimum):
        limits = f"{variable.minimum:g} to {variable.maximum:g}"
    start = "" if variable.start is None else f"{variable.start:g}"
    cells = (variable.name, variable.unit, start, limits, variable.description)
    return "<tr>" + "".join(f"<td>{escape(cell)}" for cell in cells) + "</tr>"
