"""Interactive figures of a run: results and models in, plain descriptions that plotly.js draws out. No files, no HTML.

Long signals are given as the smallest and largest value of short pieces, so that no peak is lost.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fmus.modal.modes import Modes, receptance

from ..signals.spectra import a_weighting
from ..signals.summary import sample_interval, spectrum
from ..stability.eigenloci import Crossing, Eigenloci

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

    from ..sound.levels import Sound

Real = NDArray[np.float64]
Trace = dict[str, Any]

PIECES = 1500
DIGITS = 5
HIGHEST_HZ = 6000.0
LAST_S = 0.01
WORDS = {"lat": "lateral", "ver": "vertical"}
_DECADES = 6


@dataclass(frozen=True)
class Plot:
    """A figure of the report.

    Attributes
    ----------
    title : what it shows
    text : what is to be seen in it, for those who do not see it
    traces : plotly traces; colours are put in by the page, by their `role`: wheel, rail, sound or limit
    layout : plotly layout without colours
    """

    title: str
    text: str
    traces: list[Trace]
    layout: dict[str, Any]


def plain(values: ArrayLike) -> list[float]:
    """Return numbers in five significant digits, as a page needs them."""
    array = np.asarray(values, dtype=float)
    with np.errstate(divide="ignore", invalid="ignore"):
        scale = 10.0 ** (DIGITS - 1 - np.floor(np.log10(np.abs(array))))
        rounded = np.where((array == 0) | ~np.isfinite(scale), array, np.round(array * scale) / scale)
    return [float(f"{value:.{DIGITS}g}") for value in rounded]


def envelope(x: Real, y: Real, pieces: int = PIECES) -> tuple[Real, Real]:
    """Return a line that goes through the smallest and the largest value of every piece of a signal.

    >>> envelope(np.arange(6.0), np.array([0.0, 5.0, 1.0, -2.0, 0.0, 0.0]), 2)
    (array([0., 0., 3., 3.]), array([ 0.,  5., -2.,  0.]))
    """
    length = -(-y.size // pieces)
    if length <= 2:
        return x, y
    whole = np.concatenate([y, np.full(-y.size % length, y[-1])]).reshape(-1, length)
    ends = np.stack([whole.min(axis=1), whole.max(axis=1)], axis=1)
    return np.repeat(x[::length], 2), ends.ravel()


def _axes(x: str, y: str, **more: Any) -> dict[str, Any]:
    layout: dict[str, Any] = {"xaxis": {"title": {"text": x}}, "yaxis": {"title": {"text": y}}}
    for key, value in more.items():
        axis, _, name = key.partition("_")
        layout[axis][name] = value
    return layout


def _line(x: ArrayLike, y: ArrayLike, name: str, role: str, hover: str) -> Trace:
    return {"x": plain(x), "y": plain(y), "name": name, "role": role, "mode": "lines", "type": "scatter",
            "hovertemplate": hover + f"<extra>{name}</extra>"}  # fmt: skip


def history(data: xr.Dataset, direction: str) -> Plot:
    """Return the velocity history of wheel and rail in one direction."""
    traces, peaks = [], []
    for part in ("wheel", "rail"):
        name = f"{part}.v_{direction}"
        if name in data:
            values = data[name].to_numpy().astype(float)
            x, y = envelope(data["time"].to_numpy().astype(float), values)
            traces.append(_line(x, y, part, part, "%{x:.4f} s: %{y:.3g} m/s"))
            peaks.append(f"{part} up to {np.abs(values).max():.3g} m/s")
    word = WORDS[direction]
    title = f"{word.capitalize()} velocity over the run"
    return Plot(title, f"Largest values: {', '.join(peaks)}.", traces, _axes("Time [s]", f"{word} velocity [m/s]"))


def waveform(data: xr.Dataset) -> Plot:
    """Return the last 10 ms of lateral velocity, every sample."""
    time = data["time"].to_numpy().astype(float)
    last = time > time[-1] - LAST_S
    traces = [
        _line(
            1e3 * (time[last] - time[last][0]), data[f"{p}.v_lat"].to_numpy()[last], p, p, "%{x:.3f} ms: %{y:.3g} m/s"
        )
        for p in ("wheel", "rail")
        if f"{p}.v_lat" in data
    ]
    text = "The wave form of the lateral velocity at the end of the run."
    return Plot("Last 10 ms", text, traces, _axes("Time [ms]", "lateral velocity [m/s]"))


def spectra(data: xr.Dataset, direction: str) -> Plot:
    """Return the narrow-band spectra of wheel and rail in one direction, second half of the run."""
    half = data.isel(time=slice(data.sizes["time"] // 2, None))
    traces, largest, text = [], 0.0, []
    for part in ("wheel", "rail"):
        name = f"{part}.v_{direction}"
        if name not in half:
            continue
        f, amplitude = spectrum(half[name].to_numpy(), sample_interval(data))
        shown = (f > 0) & (f <= HIGHEST_HZ)
        if not amplitude[shown].any():
            continue
        largest = max(largest, float(amplitude[shown].max()))
        text.append(f"{part}: largest line at {f[shown][amplitude[shown].argmax()]:.0f} Hz")
        x, y = envelope(f[shown], amplitude[shown])
        traces.append(_line(x, np.maximum(y, 1e-12), part, part, "%{x:.1f} Hz: %{y:.3g} m/s"))
    layout = _axes("Frequency [Hz]", f"{WORDS[direction]} velocity amplitude [m/s]", yaxis_type="log")
    if largest:
        top = float(np.log10(largest))
        layout["yaxis"]["range"] = [top - _DECADES, top + 0.3]
    title = f"Spectrum of the {WORDS[direction]} velocity, second half"
    return Plot(title, f"{'; '.join(text)}." if text else "Nothing moves.", traces, layout)


def sound_bands(sound: Sound) -> Plot:
    """Return the one-third-octave levels at the receiver."""
    bands = [f"{band:g}" for band in sound.bands["band"].to_numpy()]
    weighted = np.maximum(sound.bands.to_numpy() + a_weighting(sound.bands["band"]), 0.0)
    hover = "%{x} Hz: %{y:.1f} dB(A)<extra>one-third octave</extra>"
    trace: Trace = {
        "x": bands,
        "y": plain(weighted),
        "type": "bar",
        "name": "level",
        "role": "sound",
        "hovertemplate": hover,
    }
    layout = _axes("Band [Hz]", "Level [dB(A)]", xaxis_type="category")
    layout["yaxis"]["range"] = [0.0, max(20.0, float(weighted.max()) + 5)]
    text = f"Total {sound.level_dba:.1f} dB(A); loudest band {bands[int(weighted.argmax())]} Hz.{with_rail(sound)}"
    return Plot("Sound pressure of the wheel at the receiver, one-third octaves", text, [trace], layout)


def with_rail(sound: Sound) -> str:
    """Return the sentence on the rail's level and that of both, or the reason why they are not known."""
    if sound.rail_dba is not None:
        return f" Rail {sound.rail_dba:.1f} dB(A), wheel and rail together {sound.total_dba:.1f} dB(A)."
    return f" The rail's sound is not known: {sound.rail}." if isinstance(sound.rail, str) else ""


def levels(rows: list[tuple[str, Sound]]) -> Plot:
    """Return the total levels of several runs with their bands."""
    values = np.array([sound.level_dba for _, sound in rows])
    trace: Trace = {
        "x": [escape(name, quote=False) for name, _ in rows],  # Plotly reads a little HTML
        "y": plain(values),
        "type": "scatter",
        "mode": "markers",
        "marker": {"size": 12},
        "name": "wheel",
        "role": "sound",
        "error_y": {
            "type": "data",
            "symmetric": False,
            "array": plain([sound.high_dba - sound.level_dba for _, sound in rows]),
            "arrayminus": plain([sound.level_dba - sound.low_dba for _, sound in rows]),
        },
        "hovertemplate": "%{x}: %{y:.1f} dB(A)<extra></extra>",
    }
    known = [(name, s.rail_dba, s.total_dba) for name, s in rows if s.rail_dba is not None and s.total_dba is not None]
    others: list[Trace] = [
        {
            "x": [row[0] for row in known],
            "y": plain([row[k] for row in known]),
            "type": "scatter",
            "mode": "markers",
            "marker": {"size": 10, "symbol": symbol},
            "name": name,
            "role": role,
            "hovertemplate": f"%{{x}}, {name}: %{{y:.1f}} dB(A)<extra></extra>",
        }
        for k, name, role, symbol in ((1, "rail", "rail", "diamond"), (2, "wheel and rail", "limit", "square-open"))
        if known
    ]
    layout = _axes("", "A-weighted level [dB(A)]", xaxis_type="category")
    every = [*values, *(level for row in known for level in row[1:])]
    layout["yaxis"]["range"] = [float(min(every)) - 15, float(max(every)) + 15]
    text = "; ".join(f"{name} {sound.level_dba:.1f} dB(A)" for name, sound in rows)
    return Plot("Total sound pressure level", f"{text}.", [trace, *others], layout)


def nyquist(loci: Eigenloci, crossings: tuple[Crossing, ...]) -> Plot:
    """Return the eigenlocus of largest modulus in the complex plane, with the critical point +1."""
    f, value = _dominant(loci)
    reach = 1.3 * max([2.0, *(c.gain for c in crossings)])
    keep = _sparse(value, np.maximum(reach / 300, 0.02 * np.abs(value[1:])))
    locus = _line(value.real[keep], value.imag[keep], "eigenlocus", "wheel", "")
    locus["customdata"] = plain(f[keep])
    locus["hovertemplate"] = "%{customdata:.1f} Hz: %{x:.3g} + %{y:.3g} j<extra></extra>"
    layout = _axes("Real part [1]", "Imaginary part [1]", yaxis_scaleanchor="x")
    layout["xaxis"]["range"], layout["yaxis"]["range"] = [-reach, reach], [-reach / 2, reach / 2]
    return Plot(
        "Nyquist: eigenlocus of largest modulus", _unstable(crossings), [locus, _critical(), _stars(crossings)], layout
    )


def _critical() -> Trace:
    return {"x": [1.0], "y": [0.0], "mode": "markers", "type": "scatter", "name": "critical point +1", "role": "limit",
            "marker": {"symbol": "cross", "size": 11}, "hovertemplate": "+1<extra>critical point</extra>"}  # fmt: skip


def _stars(crossings: tuple[Crossing, ...], against_frequency: bool = False) -> Trace:
    """Return marks at the unstable frequencies."""
    gains, f = plain([c.gain for c in crossings]), plain([c.frequency_hz for c in crossings])
    return {"x": f if against_frequency else gains, "y": gains if against_frequency else [0.0] * len(gains),
            "customdata": f, "mode": "markers", "type": "scatter", "name": "unstable", "role": "rail",
            "marker": {"symbol": "star", "size": 10},
            "text": plain([c.gain for c in crossings]),
            "hovertemplate": "%{customdata:.1f} Hz: gain %{text:.3g}<extra>unstable</extra>"}  # fmt: skip


def _unstable(crossings: tuple[Crossing, ...]) -> str:
    found = ", ".join(f"{c.frequency_hz:.0f} Hz (gain {c.gain:.2f})" for c in crossings)
    return f"Unstable frequencies: {found}." if found else "No crossing beyond +1: stable."


def bode(loci: Eigenloci, crossings: tuple[Crossing, ...]) -> Plot:
    """Return the modulus of the dominant eigenlocus against frequency."""
    f, value = _dominant(loci)
    modulus = np.abs(value)
    keep = _sparse(np.log10(f) / 2 + 1j * np.log10(modulus), np.full(f.size - 1, 4 / PIECES))
    x, y = f[keep], modulus[keep]
    ends = [float(x[0]), float(x[-1])]
    limit: Trace = {"x": ends, "y": [1.0, 1.0], "mode": "lines", "type": "scatter", "name": "1", "role": "limit"}
    traces = [
        _line(x, y, "modulus", "wheel", "%{x:.1f} Hz: %{y:.3g}"),
        limit,
        _stars(crossings, against_frequency=True),
    ]
    layout = _axes("Frequency [Hz]", "Modulus [1]", xaxis_type="log", yaxis_type="log")
    return Plot("Bode: modulus of the dominant eigenlocus", _unstable(crossings), traces, layout)


def _dominant(loci: Eigenloci) -> tuple[Real, NDArray[np.complex128]]:
    """Return frequencies and the eigenvalue of largest modulus, from 20 Hz to 6 kHz."""
    shown = (loci.frequency_hz >= 20) & (loci.frequency_hz <= HIGHEST_HZ)
    rows = np.flatnonzero(shown)
    return loci.frequency_hz[shown], loci.values[rows, loci.dominant[rows]]


def _sparse(path: NDArray[np.complex128], step: Real) -> NDArray[np.int64]:
    """Return points of a path in the plane between which it moves by no more than a step, or that lie next to another.

    Parameters
    ----------
    step : (path.size - 1,) how far two points may be from each other, along the path
    """
    travelled = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)) / step)])
    return np.unique(np.searchsorted(travelled, np.arange(0.0, travelled[-1])).clip(max=path.size - 1))


def receptances(wheel: Modes, rail: Modes) -> Plot:
    """Return lateral and vertical receptances of wheel and rail at the contact."""
    f = np.unique(np.concatenate([np.geomspace(20, HIGHEST_HZ, 600), wheel.omega / (2 * np.pi)]))
    f = f[(f >= 20) & (f <= HIGHEST_HZ)]
    traces = []
    for part, modes in (("wheel", wheel), ("rail", rail)):
        if len(modes):
            values = np.abs(receptance(2 * np.pi * f, modes))
            for k, dash in ((1, "solid"), (2, "dot")):
                word = ("lon", "lateral", "vertical")[k]
                trace = _line(f, values[:, k, k], f"{part} {word}", part, "%{x:.1f} Hz: %{y:.3g} m/N")
                traces.append({**trace, "line": {"dash": dash}})
    layout = _axes("Frequency [Hz]", "Receptance [m/N]", xaxis_type="log", yaxis_type="log")
    text = "Peaks of the wheel are its modes; the rail is smooth." if len(rail) else "The rail does not move."
    return Plot("Receptances at the contact", text, traces, layout)
