"""Half a ring of rectangular section as a deck of CalculiX: C3D20 elements swept over 180 degrees."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fmus.wheel.finite_elements.section import Material

Real = NDArray[np.float64]

_CORNERS = ((0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2))
_EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
"""The nodes of an element by half steps in radius, angle and axial direction, in the order of C3D20."""


def write_ring(path: Path, r: Real, z: Real, segments: int, material: Material, modes: int) -> int:
    """Write the deck of the cosine family, free otherwise; return the node at the largest radius, middle z, angle 0."""
    lines = [_halved(r), _halved(np.linspace(0, np.pi, segments + 1)), _halved(z)]
    places = [p for p in itertools.product(*(range(x.size) for x in lines)) if sum(i % 2 for i in p) <= 1]
    number = {place: i for i, place in enumerate(places, start=1)}
    text = ["*NODE, NSET=ALL"]
    for (a, b, c), node in number.items():
        radius, angle = lines[0][a], lines[1][b]
        text.append(f"{node},{radius * np.cos(angle):.12g},{radius * np.sin(angle):.12g},{lines[2][c]:.12g}")
    text.append("*ELEMENT, TYPE=C3D20, ELSET=EALL")
    cells = itertools.product(*(range(0, x.size - 2, 2) for x in lines))
    for element, cell in enumerate(cells, start=1):
        corners = np.array(cell) + np.array(_CORNERS)
        points = [*corners, *((corners[i] + corners[j]) // 2 for i, j in _EDGES)]
        nodes = [str(number[int(p[0]), int(p[1]), int(p[2])]) for p in points]
        text += [f"{element}," + ",".join(nodes[:15]) + ",", ",".join(nodes[15:])]
    text.append("*NSET, NSET=PLANE")
    text += [f"{node}," for (_, b, _), node in number.items() if b in (0, lines[1].size - 1)]
    text += [
        "*MATERIAL, NAME=STEEL", "*ELASTIC", f"{material.young_modulus:g},{material.poisson_ratio:g}",
        "*DENSITY", f"{material.density:g}", "*SOLID SECTION, ELSET=EALL, MATERIAL=STEEL",
        "*BOUNDARY", "PLANE,2,2", "*STEP", "*FREQUENCY, SOLVER=SPOOLES", str(modes), "*NODE FILE", "U", "*END STEP",
    ]  # fmt: skip
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
    return number[lines[0].size - 1, 0, lines[2].size // 2]


def _halved(line: Real) -> Real:
    """Return a line with the middle of each of its steps."""
    return np.interp(np.arange(2 * line.size - 1) / 2, np.arange(line.size), line)
