"""Figures of wheels: cross-sections and mode shapes in, matplotlib figures out.

`python -m orchestrator.report_wheel FOLDER` writes them for the wheelsets in `fmus/wheel/data`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from numpy.typing import NDArray

from fmus.wheel.finite_elements.harmonics import AXIAL, RADIAL, Body
from fmus.wheel.finite_elements.modes import SHIPPED, WheelMode, wheelset_shapes
from fmus.wheel.finite_elements.section import Section, read_section
from fmus.wheel.wheelset import DATA

from ..visible import visible
from .style import PLAIN

Real = NDArray[np.float64]

WHEELSET_MODES = ((1, "symmetric", 1), (1, "antisymmetric", 1), (0, "symmetric", 1), (0, "antisymmetric", 2))
WHEEL_MODES = tuple((n, "symmetric", order) for n, order in ((2, 1), (3, 1), (2, 2), (4, 1), (5, 1), (4, 3), (6, 1)))
"""What is drawn: n, symmetry and number among the elastic modes; those of Table 4 in the generic wheelset."""

_COLOURS = "Blues"
_FONT = 8
_DRAWN_MM = 25.0
"""Length that the largest displacement of a section is drawn with."""


def plot_sections(sections: Sequence[Section]) -> Figure:
    """Return a figure of cross-sections, half a wheelset each."""
    figure = Figure(figsize=(7.2, 3.2 * len(sections)), layout="constrained")
    for axes, section in zip(figure.subplots(len(sections), 1, squeeze=False)[:, 0], sections, strict=True):
        for outline, colour in zip(section.outline(), ("0.75", "0.9"), strict=True):
            axes.fill(*(1e3 * outline.T), facecolor=colour, edgecolor="black", linewidth=0.8)
        point = (1e3 * section.contact_position, 1e3 * section.contact_radius)
        axes.annotate(
            "nominal contact point", point, (point[0] + 90, point[1] + 25), color="tab:red", fontsize=_FONT,
            arrowprops={"arrowstyle": "-|>", "color": "tab:red", "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip
        axes.text(20, 25, "axle, from mid-axle", fontsize=_FONT)
        axes.set_title(visible(section.title), fontsize=_FONT + 1, **PLAIN)
        _frame(axes, (-20, 1120), (0, 480))
    return figure


def plot_modes(section: Section, refinement: int = 1) -> Figure:
    """Return a figure of mode shapes: the deformed section of each, coloured by its displacement."""
    body, shapes = wheelset_shapes(section, refinement, range(7), below_hz=4500.0)
    found = _numbered(shapes)
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    rows = figure.add_gridspec(3, 1, height_ratios=(0.75, 1.5, 0.05))
    for row, keys, z in ((0, WHEELSET_MODES, (-20, 1120)), (1, WHEEL_MODES, (640, 860))):
        columns = rows[row].subgridspec(1, len(keys), wspace=0.05)
        present = sorted((found[key] for key in keys if key in found), key=lambda pair: pair[0].frequency_hz)
        for column, (mode, shape) in enumerate(present):
            axes = figure.add_subplot(columns[column])
            _draw_shape(axes, body, shape, section)
            _frame(axes, z, (0, 490))
            about = f", {mode.symmetry}" if row == 0 else ""
            axes.set_title(f"{visible(mode.label)}{about}\n{mode.frequency_hz:.0f} Hz", fontsize=_FONT, **PLAIN)
            if column:
                axes.set_ylabel("")
                axes.set_yticklabels([])
    colours = ScalarMappable(Normalize(0, 1), _COLOURS)
    bar = figure.colorbar(colours, cax=figure.add_subplot(rows[2]), orientation="horizontal")
    bar.set_label("displacement in the section, relative to its largest", fontsize=_FONT)
    bar.ax.tick_params(labelsize=_FONT - 1)
    title = f"{visible(section.title)}: cosine amplitudes of u_r and u_z"
    figure.suptitle(title, fontsize=_FONT + 1, **PLAIN)
    return figure


def write_figures(folder: Path, names: Sequence[str] = SHIPPED) -> list[Path]:
    """Write the figures of the named wheelsets as PNG files and return their paths."""
    sections = {name: read_section(DATA / f"{name}-section.toml") for name in names}
    figures = {"wheel-sections": plot_sections([*sections.values()])}
    figures |= {f"wheel-modes-{name}": plot_modes(section) for name, section in sections.items()}
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, figure in figures.items():
        paths.append(folder / f"{name}.png")
        figure.savefig(paths[-1], dpi=200)
    return paths


def _numbered(shapes: Sequence[tuple[WheelMode, Real]]) -> dict[tuple[int, str, int], tuple[WheelMode, Real]]:
    """Return the elastic modes by n, symmetry and their number in order of frequency."""
    numbered: dict[tuple[int, str, int], tuple[WheelMode, Real]] = {}
    count: dict[tuple[int, str], int] = {}
    for mode, shape in shapes:
        if mode.frequency_hz > 0:
            key = (mode.n, mode.symmetry)
            count[key] = count.get(key, 0) + 1
            numbered[(*key, count[key])] = (mode, shape)
    return numbered


def _draw_shape(axes: Axes, body: Body, shape: Real, section: Section) -> None:
    """Draw the deformed elements over the outline of the section at rest."""
    basis = body.basis
    mesh = basis.mesh
    around = [
        dofs
        for k in range(4)
        for dofs in (basis.nodal_dofs[:, mesh.t[k]], basis.facet_dofs[:, mesh.t2f[k]])
    ]  # fmt: skip
    z, r = 1e3 * np.array([basis.doflocs[:, dofs[0]] for dofs in around]).transpose(1, 2, 0)
    u_z = np.array([shape[dofs[AXIAL]] for dofs in around]).T
    u_r = np.array([shape[dofs[RADIAL]] for dofs in around]).T
    size = np.hypot(u_z, u_r)
    size_max = size.max()
    sign = np.sign(u_z.flat[size.argmax()] or 1.0)
    scale = sign * _DRAWN_MM / size_max
    deformed = np.stack([z + scale * u_z, r + scale * u_r], axis=-1)
    elements = PolyCollection([*deformed], array=size.mean(axis=1) / size_max, cmap=_COLOURS, edgecolor="face", lw=0.3)
    elements.set_clim(0, 1)
    axes.add_collection(elements)
    for outline in section.outline():
        axes.plot(*(1e3 * outline.T), color="black", linewidth=0.5, linestyle=(0, (4, 2)))


def _frame(axes: Axes, z: tuple[float, float], r: tuple[float, float]) -> None:
    """Give axes equal scales, limits and units."""
    axes.set_aspect("equal")
    axes.set_xlim(*z)
    axes.set_ylim(*r)
    axes.set_xlabel("$z$ [mm]", fontsize=_FONT)
    axes.set_ylabel("$r$ [mm]", fontsize=_FONT)
    axes.tick_params(labelsize=_FONT - 1)
