"""Figures of limit cycles: growth rate against amplitude, force against velocity, spectra. Cycles in, figures out."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullFormatter

from ..limit_cycles.bifurcations.diagram import Branch
from ..limit_cycles.catalogue import Catalogue, Cycle
from ..visible import visible
from .style import COLOURS, STYLE, plain_ticks

SHOWN_DB = 100.0
"""Lines that are weaker than the strongest by more are not drawn [dB]."""


def draw_cycles(found: Catalogue, title: str) -> Figure:
    """Return the figure of all tones: growth rate against amplitude, and their levels."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 4.8), layout="constrained")
        growth, levels = figure.subplots(1, 2)
        _draw_growth(growth, found)
        _draw_levels(levels, found)
        figure.suptitle(f"{visible(title)}: limit cycles", fontsize="large")
        return plain_ticks(figure)


def _draw_growth(axes: Axes, found: Catalogue) -> None:
    """Draw the growth rate at an amplitude, with the cycles at its zeros."""
    curves = [t for t in found.traces if t.crossings]
    colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.9, max(len(curves), 1)))
    for colour, trace in zip(colours, sorted(curves, key=lambda t: t.pole.frequency_hz), strict=False):
        axes.plot(trace.amplitude, trace.sigma, color=colour, label=f"{trace.pole.frequency_hz:.0f} Hz")
        for c in (c for c in found.cycles if c.pole is trace.pole):
            axes.plot(
                c.amplitude, 0.0, "o", color=colour, markerfacecolor=colour if c.stable else "white", markersize=5
            )
    axes.axhline(0.0, color="black", linewidth=0.6)
    top = max([10.0, *(float(t.sigma.max()) for t in curves)])
    axes.set(xlabel="Amplitude of the first harmonic [m/s]", ylabel="Growth rate at that amplitude [1/s]")
    axes.set(ylim=(-0.6 * top, 1.1 * top), xlim=(0, 1.4 * max(c.amplitude for c in found.cycles)))
    asked = all(c.stability is not None for c in found.cycles)
    axes.set_title(f"zeros are cycles{': filled, stable; open, unstable' if asked else ''}", fontsize="medium")
    axes.legend(title="pole", fontsize=7, title_fontsize=8, loc="upper right")


def _draw_levels(axes: Axes, found: Catalogue) -> None:
    """Draw level, or else lateral velocity, of each tone by frequency."""
    known = all(c.level_dba is not None for c in found.cycles)
    heights = [float((c.level_dba if known else c.wheel_velocity_rms["lat"]) or 0.0) for c in found.cycles]
    bottom = min(heights) - 5 if known else 0.0
    for c, height in zip(found.cycles, heights, strict=True):
        colour = COLOURS["wheel"] if c.stable else COLOURS["rail"]
        axes.vlines(c.frequency_hz, bottom, height, color=colour, linestyle="-" if c.stable else "--")
        axes.plot(c.frequency_hz, height, "o", color=colour, markerfacecolor=colour if c.stable else "white")
        axes.annotate(
            f"{c.frequency_hz:.0f}", (c.frequency_hz, height), (0, 5), textcoords="offset points", ha="center",
            fontsize=7,
        )  # fmt: skip
    axes.set(xscale="log", xlabel="Frequency [Hz]", ylim=(bottom, None), xlim=(100, 7000))
    axes.xaxis.set_major_locator(FixedLocator([100, 200, 500, 1000, 2000, 5000]))
    axes.xaxis.set_major_formatter("{x:.0f}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel("Level at 7.5 m [dB(A)]" if known else "Lateral velocity of the wheel, rms [m/s]")
    asked = all(c.stability is not None for c in found.cycles)
    words = "solid, stable; dashed, breaks up" if asked else "whether they last was not looked at"
    axes.set_title(words, fontsize="medium")


def draw_cycle(cycle: Cycle, title: str) -> Figure:
    """Return the figure of one tone: creep force against creepage, histories, spectrum."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 4.2), layout="constrained")
        loop, history, lines = figure.subplots(1, 3)
        _draw_loop(loop, cycle)
        _draw_history(history, cycle)
        _draw_lines(lines, cycle)
        rms = cycle.wheel_velocity_rms["lat"]
        level = "" if cycle.level_dba is None else f", {cycle.level_dba:.1f} dB(A)"
        figure.suptitle(f"{visible(title)}: {cycle.frequency_hz:.2f} Hz, {rms:.4f} m/s rms{level}; {cycle.fate}")
        return plain_ticks(figure)


def _draw_loop(axes: Axes, cycle: Cycle) -> None:
    """Draw the lateral creep force against the lateral creepage over a period, with the friction limit."""
    contact = cycle.contact
    creepage, force = contact.of("creepage_lat"), contact.of("tangential_force_lat")
    limit = contact.of("friction_coefficient") * contact.of("normal_force")
    closed = np.r_[: creepage.size, 0]
    sign = np.where(force < 0, -1.0, 1.0)
    axes.plot(100 * creepage[closed], (sign * limit)[closed] / 1e3, color="0.75", linewidth=3, label="friction limit")
    axes.plot(100 * creepage[closed], force[closed] / 1e3, color=COLOURS["wheel"], label="creep force on the wheel")
    axes.set(xlabel="Lateral creepage [%]", ylabel="Lateral force [kN]")
    axes.legend(fontsize=8)


def _draw_history(axes: Axes, cycle: Cycle) -> None:
    """Draw lateral velocities and the normal force over a period."""
    time = 1e3 * cycle.contact.time
    samples = time.size
    for name, lines in (("wheel", cycle.motion.wheel), ("rail", cycle.motion.rail)):
        velocity = np.fft.irfft(lines[:, 1], samples) * samples
        axes.plot(time, velocity, color=COLOURS[name], linestyle="-" if name == "wheel" else "--", label=name)
    axes.set(xlabel="Time [ms]", ylabel="Lateral velocity [m/s]")
    axes.legend(fontsize=8, loc="upper left")
    force = axes.twinx()
    force.plot(time, cycle.contact.of("normal_force") / 1e3, color="0.4", linestyle=":", label="normal force")
    force.set_ylabel("Normal force [kN]")
    force.grid(visible=False)
    force.legend(fontsize=8, loc="upper right")


def _draw_lines(axes: Axes, cycle: Cycle) -> None:
    """Draw the lateral lines of wheel and rail."""
    k = np.arange(1, len(cycle.motion.wheel))
    top = float(2 * np.abs(cycle.motion.wheel[1:, 1]).max())
    floor = top * 10 ** (-SHOWN_DB / 20)
    for name, lines, mark in (("wheel", cycle.motion.wheel, "o"), ("rail", cycle.motion.rail, "s")):
        amplitude = 2 * np.abs(lines[1:, 1])
        seen = amplitude > floor
        axes.vlines(k[seen] * cycle.frequency_hz / 1e3, floor, amplitude[seen], color=COLOURS[name], linewidth=0.6)
        axes.plot(
            k[seen] * cycle.frequency_hz / 1e3, amplitude[seen], mark, color=COLOURS[name], markersize=3, label=name
        )
    axes.set(yscale="log", xlabel="Frequency [kHz]", ylabel="Lateral velocity amplitude [m/s]", ylim=(floor, None))
    axes.legend(fontsize=8)


MARKS = {"Hopf": "o", "fold": "D", "Neimark-Sacker": "s", "period doubling": "^"}


def draw_branches(branches: list[Branch], title: str) -> Figure:
    """Return the bifurcation diagram: amplitude against a parameter, solid where the tone lasts."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 4.8), layout="constrained")
        axes = figure.subplots()
        colours = mpl.colormaps["viridis"](np.linspace(0.0, 0.85, max(len(branches), 1)))
        shown: set[str] = set()
        for colour, branch in zip(colours, branches, strict=True):
            asked = not np.isnan(branch.exponent).any()
            lasts = branch.stable if asked else np.ones(branch.value.size, bool)
            middle = branch.frequency_hz[branch.frequency_hz.size // 2]
            axes.plot(branch.value, branch.amplitude, "--", color=colour, linewidth=0.8)
            solid = np.where(lasts, branch.amplitude, np.nan)
            axes.plot(branch.value, solid, color=colour, linewidth=1.6, label=f"{middle:.0f} Hz")
            for mark in branch.marks:
                label = mark.kind if mark.kind not in shown else None
                shown.add(mark.kind)
                axes.plot(
                    mark.value, mark.amplitude, MARKS[mark.kind], color="black", markerfacecolor="white", markersize=6,
                    label=label, clip_on=False,
                )  # fmt: skip
        unit = "-" if branches[0].unit == "1" else branches[0].unit
        axes.set(
            xlabel=f"{branches[0].parameter} [{unit}]", ylabel="Amplitude of the first harmonic [m/s]", ylim=(0, None)
        )
        asked = not np.isnan(np.concatenate([b.exponent for b in branches])).any()
        how = "solid, lasts; dashed, does not" if asked else "whether it lasts was not looked at"
        axes.set_title(f"{visible(title)}: {how}", fontsize="medium")
        axes.legend(fontsize=8)
        return plain_ticks(figure)
