"""Pictures of a run, of the friction law and of a competition: data in, PNG files out."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from fmus.interface import DIRECTIONS

from ..signals.spectra import a_weighting, regular
from ..signals.summary import sample_interval, spectrum
from ..visible import visible
from .style import COLOURS, LINES, STYLE, WORDS, plain_ticks

if TYPE_CHECKING:
    from ..sound.levels import Sound


SHOWN_HZ = 6000.0
DECADES = 1e-6
POINTS = 2000


def draw_run(data: xr.Dataset, path: Path) -> None:
    """Draw velocity histories, their last periods and spectra of wheel and rail, as in Figs 8 to 11 of the paper."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 6.5))
        axes = figure.subplots(
            2, 3, gridspec_kw={"left": 0.07, "right": 0.98, "bottom": 0.08, "top": 0.88, "wspace": 0.27, "hspace": 0.32}
        )
        figure.suptitle(f"{visible(data.attrs.get('title', ''))}: velocity at the contact point")
        for row, direction in zip(axes, ("lat", "ver"), strict=True):
            for component in ("wheel", "rail"):
                name = f"{component}.v_{direction}"
                if name in data:
                    _draw_signal(row, data, name, component)
            row[0].set(ylabel=f"{WORDS[direction]} velocity [m/s]", xlabel="Time [s]")
            row[1].set(xlabel="Time [s]", title="last 10 ms")
            row[2].set(
                xlabel="Frequency [Hz]", ylabel="Velocity amplitude [m/s]", title="second half", yscale="log",
                xlim=(0, SHOWN_HZ),
            )  # fmt: skip
        handles = [Line2D([], [], color=COLOURS[c], linestyle=LINES[c], label=c) for c in COLOURS]
        figure.legend(handles=handles, loc="upper right", ncols=2)
        plain_ticks(figure).savefig(path, dpi=150)


def _draw_signal(row: list[Axes], data: xr.Dataset, name: str, component: str) -> None:
    """Draw one velocity into the three axes of a row."""
    data = regular(data)
    time = data["time"].to_numpy()
    signal = data[name].to_numpy().astype(float)
    look: Any = {"color": COLOURS[component], "label": component}
    row[0].fill_between(*_envelope(time, signal), linewidth=0.3, alpha=0.8, **look)
    last = time > time[-1] - 0.01
    row[1].plot(time[last], signal[last], linestyle=LINES[component], **look)
    frequency, amplitude = spectrum(signal[signal.size // 2 :], sample_interval(data))
    shown = frequency <= SHOWN_HZ
    row[2].plot(frequency[shown], amplitude[shown], linewidth=0.6, alpha=0.8, **look)
    top = max(row[2].get_ylim()[1], amplitude.max(initial=DECADES) * 2)
    row[2].set_ylim(top * DECADES, top)


def _envelope(time: np.ndarray, signal: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times, smallest and largest values in at most `POINTS` pieces, so that no peak is lost."""
    length = max(1, signal.size // POINTS)
    count = signal.size // length
    pieces = signal[: count * length].reshape(count, length)
    return time[: count * length : length], pieces.min(axis=1), pieces.max(axis=1)


def draw_directions(data: xr.Dataset, path: Path) -> None:
    """Draw velocity histories and narrow-band spectra of wheel and rail in all four directions, as Figs 8 to 11."""
    data = regular(data)
    names = [d for d in DIRECTIONS if f"wheel.v_{d}" in data]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 2.3 * len(names) + 0.6), layout="constrained")
        axes = figure.subplots(len(names), 2, width_ratios=(1.2, 1), squeeze=False)
        for row, direction in zip(axes, names, strict=True):
            unit = data[f"wheel.v_{direction}"].attrs.get("units", "")
            for component in ("wheel", "rail"):
                name = f"{component}.v_{direction}"
                if name not in data:
                    continue
                signal = data[name].to_numpy().astype(float)
                look: Any = {"color": COLOURS[component], "label": component}
                row[0].fill_between(*_envelope(data["time"].to_numpy(), signal), linewidth=0.3, alpha=0.8, **look)
                frequency, amplitude = spectrum(signal[signal.size // 2 :], sample_interval(data))
                shown = frequency <= SHOWN_HZ
                row[1].plot(frequency[shown], np.maximum(amplitude[shown], 1e-12), linewidth=0.6, **look)
            row[0].set(ylabel=f"{direction} [{unit}]")
            top = row[1].get_ylim()[1]
            row[1].set(yscale="log", xlim=(0, SHOWN_HZ), ylim=(top * DECADES, top * 2))
        axes[-1][0].set(xlabel="Time [s]")
        axes[-1][1].set(xlabel="Frequency [Hz]")
        axes[0][0].set(title=f"{visible(data.attrs.get('title', ''))}: velocity at the contact point")
        axes[0][1].set(title="amplitude, second half")
        axes[0][1].legend(loc="upper right")
        plain_ticks(figure).savefig(path, dpi=110)


def draw_sound(sounds: dict[str, Sound], path: Path) -> None:
    """Draw the A-weighted one-third-octave levels of runs, and totals with bands: wheel, as Fig. 12, rail, both."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 4), layout="constrained")
        bands, totals = figure.subplots(1, 2, width_ratios=(2.2, 1))
        for k, (name, sound) in enumerate(sounds.items()):
            level = sound.bands.to_numpy() + a_weighting(sound.bands["band"])
            bands.plot(sound.bands["band"], level, marker="os^D"[k % 4], markersize=4, label=visible(name))
            reach = [[sound.level_dba - sound.low_dba], [sound.high_dba - sound.level_dba]]
            totals.bar(k - 0.25, sound.level_dba, 0.25, color=f"C{k}", alpha=0.75)
            totals.errorbar(k - 0.25, sound.level_dba, yerr=reach, color="black", capsize=4, linewidth=1)
            if sound.rail_dba is not None and sound.total_dba is not None:
                totals.bar(k, sound.rail_dba, 0.25, color=f"C{k}", alpha=0.4, hatch="//", edgecolor="black")
                totals.bar(k + 0.25, sound.total_dba, 0.25, color=f"C{k}", alpha=0.75, hatch="..", edgecolor="black")
        known = [level for s in sounds.values() for level in (s.low_dba, s.rail_dba) if level is not None]
        low = min((level for level in known if np.isfinite(level)), default=60.0)
        bands.set(xscale="log", xlabel="Frequency [Hz]", ylabel="Level in one-third octaves [dB(A)]", ylim=(20, None))
        bands.legend()
        totals.legend(
            handles=[
                Patch(facecolor="0.6", label="wheel"),
                Patch(facecolor="0.8", hatch="//", edgecolor="black", label="rail"),
                Patch(facecolor="0.6", hatch="..", edgecolor="black", label="both"),
            ],
            ncols=3, fontsize=7, loc="upper center",
        )  # fmt: skip
        totals.set(ylabel="Total level [dB(A)]", ylim=(10 * np.floor(low / 10 - 1), None))
        totals.set_xticks(range(len(sounds)), [visible(name) for name in sounds])
        plain_ticks(figure).savefig(path, dpi=110)
