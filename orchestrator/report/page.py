"""One self-contained page about runs: results files in, HTML out. Nothing in it comes from the network."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import InputError
from ..published.cases import PAPER_HZ, SAME_TONE
from ..results.file import open_results
from ..signals.figures_told import FIGURES
from ..signals.limit_cycle import Growth, LimitCycle, growth_of, limit_cycle
from ..signals.spectra import regular
from ..signals.summary import sample_interval, summarise
from ..sound.levels import Sound, sound_of
from ..sound.wav import compressed, pressure_of
from ..stability.linear_model import LinearModel, model_of
from ..stability.scheme import growth_of_scheme
from ..visible import visible
from . import plots
from .plots import Plot

if TYPE_CHECKING:  # xarray takes a second to import
    import xarray as xr

TEMPLATES = Path(__file__).parent / "templates"

CLIP_S = 6.0
"""Longest sound that the page carries [s]."""

_ADDED = "contact.energy_added_"
"""Columns of the energy that holding the forces adds, by direction."""

_ALGORITHMS = ("staggered", "jacobi")
_LEAST_ROWS = 100


@dataclass(frozen=True)
class Section:
    """What the page says of one run.

    Attributes
    ----------
    key, title, source : identifier in the page, name of the case, file
    attributes : of the results file
    cycle, growth : what the run did
    sound : None if it is not known; `silence` then says why
    audio : MP3, base64; None if there is nothing to hear
    residual : energy that the coupling added, by direction [J]
    spurious : what the scheme adds to the growth, in words; None where it is not known
    figures : numbers of its second half: label and words
    plots : figures
    """

    key: str
    title: str
    source: str
    attributes: Mapping[str, Any]
    duration: float
    cycle: LimitCycle
    growth: tuple[Growth, ...]
    sound: Sound | None
    silence: str
    audio: str | None
    residual: Mapping[str, float]
    spurious: str | None
    figures: Sequence[tuple[str, str]]
    plots: Sequence[Plot] = field(default_factory=list)

    @property
    def paper_hz(self) -> float | None:
        """Dominant frequency that the paper gives for this case."""
        return PAPER_HZ.get(str(self.attributes.get("case")))

    @property
    def meets_paper(self) -> bool:
        """Whether the dominant tone is the paper's, within 1 %."""
        f, paper = self.cycle.frequency_hz, self.paper_hz
        return self.cycle.squeals and f is not None and paper is not None and abs(f / paper - 1) < SAME_TONE

    @property
    def summary(self) -> str:
        """The run in words."""
        cycle = self.cycle
        if not cycle.squeals or cycle.frequency_hz is None:
            return (
                f"No squeal: in the second half of {self.duration:.3g} s the wheel moves laterally with "
                f"{1e3 * cycle.lateral_rms:.2g} mm/s rms only. The figures show what there is."
            )
        parts = [
            f"Squeal at {cycle.frequency_hz:.1f} Hz; the wheel moves laterally with {cycle.lateral_rms:.3g} m/s rms."
        ]
        parts.append(
            "The vibration has reached a steady limit cycle."
            if cycle.steady
            else f"The level still changes by {cycle.unsteadiness:.0%}; a longer run may end otherwise."
        )
        if self.sound is not None:
            s = self.sound
            parts.append(f"At 7.5 m {s.level_dba:.1f} dB(A) ({s.low_dba:.1f} to {s.high_dba:.1f}).{plots.with_rail(s)}")
        if cycle.contact_lost:
            parts.append(f"Contact is lost {cycle.contact_lost:.1%} of the time.")
        return " ".join(parts)

    @cached_property
    def contact_parameters(self) -> Mapping[str, Any]:
        """Parameters of the contact."""
        values: Mapping[str, Any] = json.loads(self.attributes.get("all_parameters", "{}")).get("contact", {})
        return {name: value for name, value in values.items() if not name.startswith("mobility_")}

    @cached_property
    def versions(self) -> Mapping[str, str]:
        """Software of the run."""
        found: Mapping[str, str] = json.loads(self.attributes.get("versions", "{}"))
        return found

    @cached_property
    def fmus(self) -> Mapping[str, Mapping[str, str]]:
        """FMUs of the run."""
        found: Mapping[str, Mapping[str, str]] = json.loads(self.attributes.get("fmus", "{}"))
        return found


def write_report(results: Sequence[Path], out: Path) -> Path:
    """Write the page about some runs into a folder; return its path.

    Raises
    ------
    InputError
        For a file that holds no results of a wheel, or too few rows to say anything.
    """
    sections = []
    for number, path in enumerate(results, start=1):
        with open_results(path) as data:
            sections.append(section(data, f"run{number}", path))
    loud = [(s.title, s.sound) for s in sections if s.sound is not None and s.cycle.squeals]
    overview = [plots.levels(loud)] if loud else []
    try:
        out.mkdir(parents=True, exist_ok=True)
        page = out / "report.html"
        page.write_text(render(sections, overview), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{out}: cannot write there: {error.strerror or error}") from None
    return page


def section(data: xr.Dataset, key: str, path: Path) -> Section:
    """Return what there is to say of one run."""
    if "wheel.v_lat" not in data or "step_s" not in data.attrs:
        raise InputError(f"{path}: holds no wheel.v_lat, so it is not a run of the wheel/rail system")
    data = regular(data)
    if data.sizes["time"] < _LEAST_ROWS:
        raise InputError(f"{path}: has {data.sizes['time']} rows; a report needs at least {_LEAST_ROWS}")
    (model, unknown), cycle = _model(data), limit_cycle(data)
    (sound, silence), numbers = _sound(data), summarise(data)
    return Section(
        key=key,
        title=visible(str(data.attrs.get("title") or path.stem)),
        source=visible(path.name),
        attributes=dict(data.attrs),
        duration=data.sizes["time"] * sample_interval(data),
        cycle=cycle,
        growth=() if model is None else growth_of(data, model.poles),
        sound=sound,
        silence=silence,
        audio=_audio(data) if sound is not None and cycle.squeals else None,
        residual={str(n).removeprefix(_ADDED): float(data[n][-1]) for n in data.data_vars if str(n).startswith(_ADDED)},
        spurious=_spurious(data, model, unknown),
        figures=[(figure.label, figure.words(numbers)) for figure in FIGURES],
        plots=_plots(data, model, sound),
    )


def _sound(data: xr.Dataset) -> tuple[Sound | None, str]:
    """Return the sound of a run, or the sentence that says why there is none."""
    try:
        return sound_of(data), ""
    except InputError as reason:
        return None, str(reason)


def _audio(data: xr.Dataset) -> str | None:
    try:
        return base64.b64encode(compressed(pressure_of(data), CLIP_S)).decode()
    except InputError:
        return None


def _model(data: xr.Dataset) -> tuple[LinearModel | None, str]:
    """Return the linear model of a run, or the sentence that says why there is none."""
    try:
        return model_of(data), ""
    except InputError as reason:
        return None, str(reason)


def _spurious(data: xr.Dataset, model: LinearModel | None, unknown: str) -> str | None:
    """Return in words what the scheme adds to the growth of the modes below 5 kHz, or why that is not known."""
    algorithm = str(data.attrs.get("algorithm"))
    if algorithm not in _ALGORITHMS:
        return None
    if model is None:
        return f"not known: {unknown}"
    step = float(data.attrs["step_s"])
    return growth_of_scheme(model, step, algorithm).sentence(algorithm, step)


def _plots(data: xr.Dataset, model: LinearModel | None, sound: Sound | None) -> list[Plot]:
    """Return the figures that the results allow."""
    directions = [d for d in ("lat", "ver") if f"wheel.v_{d}" in data]
    found = [plots.history(data, d) for d in directions]
    found.append(plots.waveform(data))
    found += [plots.spectra(data, d) for d in directions]
    if sound is not None and sound.level_dba > 0:
        found.append(plots.sound_bands(sound))
    if model is not None:
        loci, crossings = model.open_loop()
        found += [plots.nyquist(loci, crossings), plots.bode(loci, crossings)]
        found.append(plots.receptances(*model.modal()))
    return found


def render(sections: Sequence[Section], overview: Sequence[Plot]) -> str:
    """Return the page."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # noqa: PLC0415 - takes its time

    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    figures = {f"overview-{i}": asdict(p) for i, p in enumerate(overview)}
    figures |= {f"{s.key}-{i}": asdict(p) for s in sections for i, p in enumerate(s.plots)}
    return environment.get_template("report.html.jinja").render(
        sections=sections,
        overview=overview,
        figures=json.dumps(figures, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        library=(TEMPLATES / "plotly-basic.min.js").read_text(encoding="utf-8"),
        script=(TEMPLATES / "report.js").read_text(encoding="utf-8"),
        style=(TEMPLATES / "report.css").read_text(encoding="utf-8"),
        version=version("curvesqueal"),
    )
